// A sort in shared memory.
#pragma once

#include <cstdint>

#include "cuda/device/warp.cuh"

namespace deformable_contact_monitor {

// This lane's key and that of the lane `apart` from it: which of them it has from now on.
__device__ inline std::uint32_t exchanged(std::uint32_t key, unsigned apart, bool ascends) {
  const std::uint32_t other = __shfl_xor_sync(kFullWarp, key, apart);
  return ((laneId() & apart) == 0) == ascends ? min(key, other) : max(key, other);
}

// K. Batcher's bitonic sort by a block, whose threads all call it with the same: each `part` of the
// first `whole` keys, ascending. Both are powers of two, part >= 64, and the block has whole / 2
// threads at least. All of the block have seen to their keys, and may read all keys then.
// A lane holds two keys 32 places apart, for a warp is done with its 64 places faster in registers.
__device__ inline void bitonicSort(std::uint32_t* key, unsigned whole, unsigned part) {
  const unsigned at = 2 * (threadIdx.x - laneId()) + laneId();
  const bool mine = at < whole;  // of the whole warp
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
