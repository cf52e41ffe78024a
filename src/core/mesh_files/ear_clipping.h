// Triangulates simple polygons in the plane.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/vector3.h"

namespace deformable_contact_monitor {

using PolygonTriangle = std::array<std::uint32_t, 3>;  // numbers of corners

// Returns n - 2 triangles whose union is the closed polygon and whose interiors are disjoint. They
// have the polygon's corners and its sense of rotation. The polygon must have at least 3 corners,
// finite, counter-clockwise, with z = 0. It may touch itself, as where a bridge leads to a hole,
// and may have equal corners or several corners on one line; some triangles have no area then.
// Returns nothing if the polygon crosses itself. All decisions are exact. `work` limits the time:
// it is the number of boxes that may still be tested, and at 0 nothing is returned.
std::optional<std::vector<PolygonTriangle>> clipEars(const std::vector<Vec3f>& corners,
                                                     std::uint64_t* work);

}  // namespace deformable_contact_monitor
