// Pairs of tiles that were found, for stage pairs.
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
    if (common < extent) share *= common / extent;
  }
  return share;
}

// By a whole warp, of which some lanes have a pair of tiles: adds to sweep.tile_pairs; those with
// many triangles that may meet in parts, for a warp to each, or it would be the last to end.
__device__ inline void putTilePair(const CycleArrays& c, bool has, const TilePair& pair) {
  constexpr std::uint32_t kParts = 4;
  constexpr float kMuch = 1.0F / 8;  // of all pairs of their triangles
  std::uint32_t parts = 0;
  if (has) {
    const Aabb a = c.members.tiles[pair.a].box, b = c.members.tiles[pair.b].box;
    parts = shareWithin(a, b) * shareWithin(b, a) > kMuch ? kParts : 1;
  }
  const std::uint32_t first = warpReserve(&c.counters().tile_pairs, parts);
  for (std::uint32_t part = 0; part < parts; ++part) {
    const Place place(first + part);
    if (place.value < c.sweep.tile_pairs.size()) {
      c.sweep.tile_pairs[place] = {pair.a, pair.b, part, parts};
    }
  }
}

}  // namespace deformable_contact_monitor
