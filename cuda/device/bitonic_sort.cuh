// Sorts keys in shared memory, by one thread block.
#pragma once

#include <cstdint>

#include "cuda/device/warp.cuh"

namespace deformable_contact_monitor {

// Compares the key of this lane with that of the lane `apart` from it, and returns the one that
// this lane keeps. Called by a whole warp.
__device__ inline std::uint32_t exchanged(std::uint32_t key, unsigned apart, bool ascends) {
  const std::uint32_t other = __shfl_xor_sync(kFullWarp, key, apart);
  return ((laneId() & apart) == 0) == ascends ? min(key, other) : max(key, other);
}

// Sorts each `part` of the first `whole` keys in ascending order, by K. Batcher's bitonic sort.
// Both numbers are powers of two, part >= 64. All threads of the block call it with the same
// arguments; the block has at least whole / 2 threads. It synchronises the block before the first
// read and after the last write of the keys. Each lane holds two keys, 32 places apart: a warp
// sorts its 64 places in registers, which is faster than in shared memory.
__device__ inline void bitonicSort(std::uint32_t* key, unsigned whole, unsigned part) {
  const unsigned at = 2 * (threadIdx.x - laneId()) + laneId();
  const bool mine = at < whole;  // the same for all lanes of a warp
  const auto ascends = [part](unsigned run, unsigned i) { return run == part || (i & run) == 0; };
  std::uint32_t low = 0, high = 0;
  const auto load = [&] {
    __syncthreads();
    if (!mine) return;
    low = key[at];
    high = key[at + kWarp];
  };
  const auto store = [&] {
    if (mine) {
      key[at] = low;
      key[at + kWarp] = high;
    }
    __syncthreads();
  };
  load();
  for (unsigned run = 2; run <= part; run *= 2) {
    // Partners that are more than 32 places apart are exchanged in shared memory.
    if (run > 2 * kWarp) {
      store();
      for (unsigned apart = run / 2; apart > kWarp; apart /= 2) {
        const unsigned i = 2 * threadIdx.x - (threadIdx.x & (apart - 1));
        if (i < whole) {
          const std::uint32_t a = key[i], b = key[i + apart];
          if ((a > b) == ascends(run, i)) {
            key[i] = b;
            key[i + apart] = a;
          }
        }
        if (apart > 2 * kWarp) __syncthreads();
      }
      load();
    }
    // Partners that are 32 places apart are the two keys of one lane.
    if (run > kWarp && (low > high) == ascends(run, at)) {
      const std::uint32_t swapped = low;
      low = high;
      high = swapped;
    }
    const bool low_ascends = ascends(run, at), high_ascends = ascends(run, at + kWarp);
#pragma unroll
    for (unsigned apart = kWarp / 2; apart > 0; apart /= 2) {
      if (!mine || apart >= run) continue;
      low = exchanged(low, apart, low_ascends);
      high = exchanged(high, apart, high_ascends);
    }
  }
  store();
}

}  // namespace deformable_contact_monitor
