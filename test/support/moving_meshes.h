// Meshes in two states, and their candidates, by brute force.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/predicates/swept_triangle.h"
#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// Two meshes of the same triangles.
std::vector<MovingTriangle> movingTriangles(const TriangleMesh& from, const TriangleMesh& to);

// All pairs (i < j), ascending, whose swept boxes intersect.
std::vector<std::pair<std::uint32_t, std::uint32_t>> sweptBoxPairs(
    const std::vector<MovingTriangle>& triangles);

}  // namespace deformable_contact_monitor
