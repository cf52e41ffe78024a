// Bounding boxes that many threads grow at once, by atomic operations.
#pragma once

#include <cstdint>

#include "core/predicates/aabb.h"
#include "core/rules/intervals.h"
#include "cuda/device/warp.cuh"

namespace deformable_contact_monitor {

// A shared box consists of six words: the inverted ordered bits of the least x, y, z, then the
// ordered bits of the greatest x, y, z. So every side grows by atomicMax, and six zeros are the
// empty box.
constexpr unsigned kSides = 6;

__device__ inline Aabb boxOf(const std::uint32_t* sides) {
  if (sides[3] == 0) return {};
  return {{fromOrderedBits(~sides[0]), fromOrderedBits(~sides[1]), fromOrderedBits(~sides[2])},
          {fromOrderedBits(sides[3]), fromOrderedBits(sides[4]), fromOrderedBits(sides[5])}};
}

// A box of a thread block, in shared memory. All threads of the block make each call.
struct BlockBox {
  std::uint32_t sides[kSides];

  __device__ void clear() {
    if (threadIdx.x < kSides) sides[threadIdx.x] = 0;
    __syncthreads();
  }
  // Grows the box by a box of each thread, which may be empty. A warp combines its boxes first, so
  // that it needs one atomic for each side.
  __device__ void include(const Aabb& box) {
    const bool counts = !box.empty();
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t low = warpMost(counts ? ~orderedBits(box.min[k]) : 0);
      const std::uint32_t high = warpMost(counts ? orderedBits(box.max[k]) : 0);
      if (laneId() == 0 && high != 0) {
        atomicMax(&sides[k], low);
        atomicMax(&sides[3 + k], high);
      }
    }
    __syncthreads();
  }
  __device__ Aabb get() const { return boxOf(sides); }
  // Grows a box in global memory by this one.
  __device__ void addTo(std::uint32_t* box) const {
    if (threadIdx.x < kSides && sides[threadIdx.x] != 0) {
      atomicMax(&box[threadIdx.x], sides[threadIdx.x]);
    }
  }
};

}  // namespace deformable_contact_monitor
