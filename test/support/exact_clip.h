// The contact definition by construction: two closed sets are clipped in exact rationals.
#pragma once

#include <array>
#include <vector>

#include "core/vector3.h"

namespace deformable_contact_monitor {

// Vertices in the scene frame; may coincide or be collinear.
using OracleTriangle = std::array<Vec3f, 3>;

// Returns whether the convex hulls of a and b, boundaries included, meet anywhere outside the
// closed convex hull of `shared`. `shared` has at most three points; if it is empty, the function
// returns whether the hulls meet at all. It is exact for all finite input, and slow.
bool meetBeyondByConstruction(const OracleTriangle& a, const OracleTriangle& b,
                              const std::vector<Vec3f>& shared);

// The corners of what the closed hulls of a and b have in common, each coordinate to the nearest
// double or the next; some may be there twice. Empty: nothing.
std::vector<std::array<double, 3>> commonCorners(const OracleTriangle& a, const OracleTriangle& b);

}  // namespace deformable_contact_monitor
