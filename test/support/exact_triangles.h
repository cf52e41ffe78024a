// Triangles with rational corners, for times between two states.
#pragma once

#include <array>
#include <vector>

#include "exact_points.h"

namespace deformable_contact_monitor {
namespace exact {

using Corners = std::array<Point, 3>;  // may coincide or be collinear

// Returns the same as meetBeyondByConstruction (exact_clip.h).
bool meetBeyond(const Corners& a, const Corners& b, const std::vector<Point>& shared);

// Returns the squared distance of two triangles that do not intersect.
Rational squaredDistance(const Corners& a, const Corners& b);

}  // namespace exact
}  // namespace deformable_contact_monitor
