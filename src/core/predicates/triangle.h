// Triangles as closed convex hulls of three points; segments and points included.
#pragma once

#include "core/predicates/host_device.h"
#include "core/predicates/vector3.h"

namespace deformable_contact_monitor {

struct Triangle {
  Vec3f v[3];
};

}  // namespace deformable_contact_monitor
