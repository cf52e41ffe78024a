// The shortest translation that parts two triangles, by exact rationals.
#pragma once

#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

// How far b must move along `direction`, of any length above 0, until a plane across it parts the
// two, or they touch [m]. At least exactParting().
double exactPartingAlong(const Triangle& a, const Triangle& b, const Vec3f& direction);

// [m], right to a part in 2^50; of triangles that intersect. The least along all directions that
// can have it: the normals of both, and the products of their edges, both ways. Infinite where all
// of them are zero.
double exactParting(const Triangle& a, const Triangle& b);

}  // namespace deformable_contact_monitor
