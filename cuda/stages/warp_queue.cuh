// A queue between the parts of a warp's work.
#pragma once

#include "cuda/device/warp.cuh"

namespace deformable_contact_monitor {

// Of one warp, in shared memory; `size` is the same in all lanes. Room is the caller's.
template <class T>
struct WarpQueue {
  T* items;
  unsigned size = 0;

  // Takes an item from each lane that has one.
  __device__ void push(bool has, const T& item) {
    const unsigned mask = __ballot_sync(kFullWarp, has);
    if (has) items[size + __popc(mask & ((1U << laneId()) - 1))] = item;
    size += __popc(mask);
  }
  // Removes up to a warp of items; true in the lanes that got one.
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
