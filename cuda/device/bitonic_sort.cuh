// A sort in shared memory.
#pragma once

#include <cstdint>

#include "cuda/device/warp.cuh"

namespace deformable_contact_monitor {

// K. Batcher's bitonic sort by a block, whose threads all call it with the same: each `part` of the
// first `whole` keys, ascending. Both are powers of two, part >= 64, and the block has whole / 2
// threads at least. All of the block have seen to their keys, and may read all keys then.
__device__ inline void bitonicSort(std::uint64_t* key, unsigned whole, unsigned part) {
  __syncthreads();
  for (unsigned run = 2; run <= part; run *= 2) {
    for (unsigned apart = run / 2; apart > 0; apart /= 2) {
      const unsigned i = 2 * threadIdx.x - (threadIdx.x & (apart - 1));
      if (i < whole) {
        const bool ascends = run == part || (i & run) == 0;
        const std::uint64_t a = key[i], b = key[i + apart];
        if ((a > b) == ascends) {
          key[i] = b;
          key[i + apart] = a;
        }
      }
      // Up to there, a warp has its 64 places to itself.
      if (apart > kWarp || (apart == 1 && run >= 2 * kWarp)) {
        __syncthreads();
      } else {
        __syncwarp();
      }
    }
  }
}

}  // namespace deformable_contact_monitor
