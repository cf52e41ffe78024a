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
    if (common < extent) share *= __fdividef(common, extent);
  }
  return share;
}

// Whether many triangles of two tiles may meet, by the tiles' boxes.
__device__ inline bool isCrowded(const Aabb& a, const Aabb& b) {
  constexpr float kMany = 1.0F / 32;  // of all pairs of their triangles
  return shareWithin(a, b) * shareWithin(b, a) > kMany;
}

// Room for a warp's pairs of tiles, so many crowded ones and others.
class TilePairWriter {
 public:
  __device__ TilePairWriter(const CycleArrays& c, std::uint32_t crowded, std::uint32_t others)
      : c_(c) {
    // Both counters at once: their answers are waited for.
    std::uint32_t first = 0;
    if (laneId() == 0 && crowded != 0) first = atomicAdd(&c.counters().crowded_pairs, crowded);
    if (laneId() == 1 && others != 0) first = atomicAdd(&c.counters().tile_pairs, others);
    crowded_ = __shfl_sync(kFullWarp, first, 0);
    others_ = __shfl_sync(kFullWarp, first, 1);
  }

  // By the whole warp: the pairs of the lanes that `keep` one, as far as there is room.
  __device__ void put(bool keep, bool crowded, const TilePair& pair) {
    const unsigned before = (1U << laneId()) - 1;
    const unsigned of_crowded = __ballot_sync(kFullWarp, keep && crowded);
    const unsigned of_others = __ballot_sync(kFullWarp, keep && !crowded);
    const Place place(crowded ? crowded_ + __popc(of_crowded & before)
                              : others_ + __popc(of_others & before));
    const auto& to = crowded ? c_.sweep.crowded_pairs : c_.sweep.tile_pairs;
    if (keep && place.value < to.size()) to[place] = pair;
    crowded_ += __popc(of_crowded);
    others_ += __popc(of_others);
  }

 private:
  const CycleArrays& c_;
  std::uint32_t crowded_, others_;  // the next places
};

}  // namespace deformable_contact_monitor
