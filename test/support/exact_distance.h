// Distance of two triangles by exact rationals.
#pragma once

#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

// [m], right to a part in 2^50 for all finite input, degenerate triangles included; slow. Of
// triangles that do not intersect.
double exactDistance(const Triangle& a, const Triangle& b);

}  // namespace deformable_contact_monitor
