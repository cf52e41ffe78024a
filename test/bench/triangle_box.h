// AABBs of triangles, for the rivals.
#pragma once

#include <algorithm>
#include <cstddef>

#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

inline void triangleBox(const TriangleMesh& mesh, std::size_t triangle, float low[3],
                        float high[3]) {
  const std::uint32_t* index = &mesh.triangles[3 * triangle];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto at = [&](int k) { return mesh.vertices[std::size_t{3} * index[k] + axis]; };
    low[axis] = std::min({at(0), at(1), at(2)});
    high[axis] = std::max({at(0), at(1), at(2)});
  }
}

}  // namespace deformable_contact_monitor
