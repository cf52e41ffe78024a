// Triangles as closed convex hulls of three points; segments and points included.
#pragma once

#include "core/host_device.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

struct Triangle {
  Vec3f v[3];
};

}  // namespace deformable_contact_monitor
