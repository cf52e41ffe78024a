// How far apart two triangles are: a check on what a detector claims, and none of its code.
#pragma once

#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

// [m], of finite triangles, degenerate ones too; 0 where they intersect. In double, so it is off by
// some 1e-15 of the largest coordinate.
double triangleGapM(const Triangle& a, const Triangle& b);

}  // namespace deformable_contact_monitor
