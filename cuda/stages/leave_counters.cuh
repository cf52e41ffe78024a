// How a cycle's counters come to the host: stage judge's last act.
#pragma once

#include "cuda/memory/cycle_arrays.cuh"

namespace deformable_contact_monitor {

// By the whole block, as its last act: the last block of the kernel leaves the counters on the
// host, for it has seen all of them settle.
__device__ inline void leaveCounters(const CycleArrays& c) {
  __shared__ bool last;
  CycleCounters& counters = c.counters();
  __syncthreads();
  if (threadIdx.x == 0) {
    __threadfence();
    last = atomicAdd(&counters.blocks_done, 1U) == gridDim.x - 1;
    if (last) {
      const unsigned long long found = __ldcg(&counters.candidates);
      const unsigned long long room = c.contacts.candidates.size();
      counters.judged += min(found, room);
      counters.unjudged += found - min(found, room);
    }
    __threadfence();
  }
  __syncthreads();
  if (!last) return;
  // Not through the first-level cache, which may hold older ones.
  static_assert(sizeof(CycleCounters) % sizeof(std::uint32_t) == 0);
  const auto* from = reinterpret_cast<const std::uint32_t*>(&counters);
  auto* to = reinterpret_cast<std::uint32_t*>(c.host_counters.onHost());
  for (unsigned k = threadIdx.x; k < sizeof(CycleCounters) / sizeof(std::uint32_t);
       k += blockDim.x) {
    to[k] = __ldcg(from + k);
  }
}

}  // namespace deformable_contact_monitor
