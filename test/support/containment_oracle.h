// Finds the parts of bodies that lie inside other bodies, with maps and exact rationals.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/scene.h"

namespace deformable_contact_monitor {

// Inner body, outer body, least triangle of the part.
using OraclePart = std::array<std::uint32_t, 3>;

// Returns the parts inside other bodies for all enabled pairs of different bodies, sorted. It finds
// components and closedness with maps of coordinates, and contacts with the contact oracle. To
// decide inside or outside it casts rays in random directions that meet no edge. It is slow. Only
// the scene and the rounding of poses are the same code as in what it checks.
std::vector<OraclePart> oracleInside(const Scene& scene);

}  // namespace deformable_contact_monitor
