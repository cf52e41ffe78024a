// Which parts of bodies lie within others, by maps and exact rationals.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/scene.h"

namespace deformable_contact_monitor {

// Inner body, outer body, least triangle of the part.
using OraclePart = std::array<std::uint32_t, 3>;

// Of all enabled pairs of different bodies, sorted. Components and closedness are found by maps of
// coordinates, contacts by the contact oracle, sides by rays in random directions that meet no
// edge. Slow. It shares the scene, and the rounding of poses, with what it checks.
std::vector<OraclePart> oracleInside(const Scene& scene);

}  // namespace deformable_contact_monitor
