// Triangles in full tiles, by position.
#pragma once

#include <cstdint>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/tiling.h"

namespace deformable_contact_monitor {

// A triangle, and where its centroid is; a coordinate that is not finite is 0.
struct PlacedTriangle {
  Vec3f at;
  std::uint32_t triangle;
};

PlacedTriangle placed(const TriangleMesh& mesh, std::uint32_t triangle);

// Appends these to the tiling's triangles, tiles and regions: halved along the longest side of what
// their centroids fill, again and again, so that all tiles of each call are full but one, and all
// regions but one. Takes n log n steps, however they lie. Where the limit is over, in any order.
void appendHalved(const CycleLimit& limit, std::vector<PlacedTriangle>& triangles, Tiling* tiling);

}  // namespace deformable_contact_monitor
