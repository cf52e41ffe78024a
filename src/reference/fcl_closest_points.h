// Where two triangles are closest, as FCL has it: in double, with rounding.
#pragma once

#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

struct FclClosestPoints {
  Vec3d on_a, on_b;
  double distance = 0;  // [m]
};

// Of triangles that do not intersect. FCL passes over faces whose doubled area is below 3.2e-8 m2:
// of triangles that small it may say 0 although they are apart.
FclClosestPoints fclClosestPoints(const Triangle& a, const Triangle& b);

}  // namespace deformable_contact_monitor
