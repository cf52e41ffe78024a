// Which way a triangle faces.
#pragma once

#include "core/predicates/triangle.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// Twice the triangle's area times its unit normal (right-handed) [m^2].
inline Vec3d doubleAreaNormal(const Triangle& t) {
  const Vec3d origin = toDouble(t.v[0]);
  return cross(toDouble(t.v[1]) - origin, toDouble(t.v[2]) - origin);
}

}  // namespace deformable_contact_monitor
