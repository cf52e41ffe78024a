// Sums over the threads of a block.
#pragma once

#include <cstdint>

#include "cuda/device/warp.cuh"

namespace deformable_contact_monitor {

// By the whole block of kThreads threads, whole warps: the sum of x over the threads before this
// one; `total` becomes that over all.
template <unsigned kThreads>
__device__ std::uint32_t blockPrefix(std::uint32_t x, std::uint32_t& total) {
  __shared__ std::uint32_t warp_total[kThreads / kWarp];
  std::uint32_t before = warpPrefix(x, total);
  __syncthreads();  // who still reads those of the last time
  if (laneId() == 0) warp_total[threadIdx.x / kWarp] = total;
  __syncthreads();
  total = 0;
  for (unsigned w = 0; w < kThreads / kWarp; ++w) {
    before += w < threadIdx.x / kWarp ? warp_total[w] : 0;
    total += warp_total[w];
  }
  return before;
}

}  // namespace deformable_contact_monitor
