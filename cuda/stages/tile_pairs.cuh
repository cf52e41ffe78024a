// Which pairs of tiles go first in stage pairs.
#pragma once

#include "cuda/device/warp.cuh"
#include "cuda/memory/cycle_arrays.cuh"

namespace deformable_contact_monitor {

// About which share of a tile's triangles meet another tile's box.
__device__ inline float shareWithin(const Aabb& tile, const Aabb& other) {
  float share = 1;
  for (int k = 0; k < 3; ++k) {
    const float extent = tile.max[k] - tile.min[k];
    const float common = fminf(tile.max[k], other.max[k]) - fmaxf(tile.min[k], other.min[k]);
    if (common < extent) share *= __fdividef(common, extent);
  }
  return share;
}

// Whether many triangles of two tiles may meet, by the tiles' boxes.
__device__ inline bool isCrowded(const Aabb& a, const Aabb& b) {
  constexpr float kMany = 1.0F / 32;  // of all pairs of their triangles
  return shareWithin(a, b) * shareWithin(b, a) > kMany;
}

}  // namespace deformable_contact_monitor
