// Triangles with rational corners, for times between two states.
#pragma once

#include <array>
#include <vector>

#include "exact_points.h"

namespace deformable_contact_monitor {
namespace exact {

using Corners = std::array<Point, 3>;  // may coincide or be collinear

// As meetBeyondByConstruction.
bool meetBeyond(const Corners& a, const Corners& b, const std::vector<Point>& shared);

// Of triangles that do not intersect.
Rational squaredDistance(const Corners& a, const Corners& b);

}  // namespace exact
}  // namespace deformable_contact_monitor
