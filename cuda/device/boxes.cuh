// Bounding boxes that many threads grow at once, by atomic operations.
#pragma once

#include <cstdint>

#include "core/predicates/aabb.h"
#include "core/rules/axis_box.h"
#include "core/rules/diagonal_box.h"
#include "core/rules/intervals.h"
#include "cuda/device/warp.cuh"

namespace deformable_contact_monitor {

// A shared box consists of six words: the inverted ordered bits of the least x, y, z, then the
// ordered bits of the greatest x, y, z. So every side grows by atomicMax, and six zeros are the
// empty box.
constexpr unsigned kSides = 6;

DCM_HD inline Aabb boxOf(const std::uint32_t* sides) {
  if (sides[3] == 0) return {};
  return {{fromOrderedBits(~sides[0]), fromOrderedBits(~sides[1]), fromOrderedBits(~sides[2])},
          {fromOrderedBits(sides[3]), fromOrderedBits(sides[4]), fromOrderedBits(sides[5])}};
}

__device__ inline float lowest(float x) { return fromOrderedBits(~warpMost(~orderedBits(x))); }
__device__ inline float highest(float x) { return fromOrderedBits(warpMost(orderedBits(x))); }

// Returns the box of all lanes' boxes, which may be empty. Called by a whole warp.
__device__ inline Aabb warpBox(const Aabb& box) {
  Aabb all;
  all.min = {lowest(box.min.x), lowest(box.min.y), lowest(box.min.z)};
  all.max = {highest(box.max.x), highest(box.max.y), highest(box.max.z)};
  return all;
}

// Returns the intervals of all lanes' points. Called by a whole warp.
__device__ inline DiagonalBox warpDiagonals(DiagonalBox box) {
  for (unsigned o = kWarp / 2; o > 0; o /= 2) {
    for (PackedBox& part : box.parts) {
      part.lo = __vminu2(part.lo, __shfl_xor_sync(kFullWarp, part.lo, o));
      part.hi = __vmaxu2(part.hi, __shfl_xor_sync(kFullWarp, part.hi, o));
    }
  }
  return box;
}

// Returns the box of all lanes' boxes. Called by a whole warp.
__device__ inline AxisBox warpBox(AxisBox box) {
  for (unsigned o = kWarp / 2; o > 0; o /= 2) {
    for (std::uint32_t& word : box.words) {
      word = __vminu2(word, __shfl_xor_sync(kFullWarp, word, o));
    }
  }
  return box;
}

// Returns `v` of another lane. Called by a whole warp.
__device__ inline Vec3f laneVector(const Vec3f& v, int lane) {
  return {__shfl_sync(kFullWarp, v.x, lane), __shfl_sync(kFullWarp, v.y, lane),
          __shfl_sync(kFullWarp, v.z, lane)};
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
