// Provides tools for both parts of the sweep: a queue between the steps of a warp, and a test for
// dense pairs of tiles. The second part takes dense pairs first, because many of their triangles
// may meet.
#pragma once

#include <cassert>

#include "cuda/device/warp.cuh"
#include "cuda/memory/cycle_arrays.cuh"

namespace deformable_contact_monitor {

// Estimates which fraction of a tile's triangles meet another tile's box.
__device__ inline float fractionWithin(const Aabb& tile, const Aabb& other) {
  float fraction = 1;
  for (int k = 0; k < 3; ++k) {
    const float extent = tile.max[k] - tile.min[k];
    const float common = fminf(tile.max[k], other.max[k]) - fmaxf(tile.min[k], other.min[k]);
    if (common < extent) fraction *= __fdividef(common, extent);
  }
  return fraction;
}

// Returns whether many triangles of two tiles may meet, judging by the tiles' boxes.
__device__ inline bool isDense(const Aabb& a, const Aabb& b) {
  constexpr float kMany = 1.0F / 32;  // of all pairs of their triangles
  return fractionWithin(a, b) * fractionWithin(b, a) > kMany;
}

// Returns the lanes before this one, as bits. The value is read once and kept, where the compiler
// would compute it again in each step of a loop.
__device__ inline unsigned lanesBelow() {
  unsigned mask;
  asm volatile("mov.u32 %0, %%lanemask_lt;" : "=r"(mask));
  return mask;
}

// A queue of one warp, in shared memory. `size` is the same in all lanes. The caller makes sure
// that there is room: what is pushed beyond kCapacity items overwrites other memory of the block.
// Builds with assertions stop then. All calls are made by the whole warp.
template <class T, unsigned kCapacity>
struct WarpQueue {
  T* items;
  unsigned size = 0;

  // Takes an item from each lane that has one.
  __device__ void push(bool has, const T& item) {
    const unsigned mask = __ballot_sync(kFullWarp, has);
    if (has) items[size + __popc(mask & ((1U << laneId()) - 1))] = item;
    size += __popc(mask);
    assert(size <= kCapacity);
  }
  // Removes up to 32 items. Returns true in the lanes that got one.
  __device__ bool pop(T& item) {
    const unsigned taken = min(size, kWarp);
    size -= taken;
    const bool got = laneId() < taken;
    __syncwarp();
    if (got) item = items[size + laneId()];
    __syncwarp();
    return got;
  }
};

}  // namespace deformable_contact_monitor
