// How a cycle's counters come to the host: stage judge's last act.
#pragma once

#include "cuda/memory/cycle_arrays.cuh"

namespace deformable_contact_monitor {

// By a whole block, as its last act; by so many `blocks` of the kernel, of which the last leaves
// the counters on the host, for it has seen all of them settle.
__device__ inline void leaveCounters(const CycleArrays& c, std::uint32_t blocks) {
  __shared__ bool last;
  __shared__ CycleCounters left;
  CycleCounters& counters = c.counters();
  __syncthreads();
  if (threadIdx.x == 0) {
    __threadfence();
    last = blocks == 1 || atomicAdd(&counters.blocks_done, 1U) == blocks - 1;
    __threadfence();
  }
  __syncthreads();
  if (!last) return;
  static_assert(sizeof(CycleCounters) % sizeof(std::uint32_t) == 0);
  constexpr unsigned kWords = sizeof(CycleCounters) / sizeof(std::uint32_t);
  // Not through the first-level cache, which may hold older ones.
  const auto* const from = reinterpret_cast<const std::uint32_t*>(&counters);
  auto* const words = reinterpret_cast<std::uint32_t*>(&left);
  for (unsigned k = threadIdx.x; k < kWords; k += blockDim.x) words[k] = __ldcg(from + k);
  __syncthreads();
  if (threadIdx.x == 0) {
    const unsigned long long room = c.contacts.candidates.size();
    left.judged += min(left.candidates, room);
    left.unjudged += left.candidates - min(left.candidates, room);
    counters.judged = left.judged;
    counters.unjudged = left.unjudged;
  }
  __syncthreads();
  auto* const to = reinterpret_cast<std::uint32_t*>(c.host_counters.onHost());
  for (unsigned k = threadIdx.x; k < kWords; k += blockDim.x) to[k] = words[k];
}

}  // namespace deformable_contact_monitor
