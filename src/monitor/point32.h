// Vectors as geometry_msgs/Point32.
#pragma once

#include <geometry_msgs/Point32.h>

namespace deformable_contact_monitor {

// Of a Vec3f, or of a Vec3d, which is rounded.
template <class Vector>
geometry_msgs::Point32 toPoint32(const Vector& v) {
  geometry_msgs::Point32 point;
  point.x = static_cast<float>(v.x);
  point.y = static_cast<float>(v.y);
  point.z = static_cast<float>(v.z);
  return point;
}

}  // namespace deformable_contact_monitor
