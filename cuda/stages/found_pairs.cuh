// Adds candidates and contacts to their lists (stages sweep, oversized and narrow_phase), and
// copies a cycle's counters to the host as the last act of the narrow phase.
#pragma once

#include "core/predicates/narrow_phase.h"
#include "cuda/device/warp.cuh"
#include "cuda/memory/cycle_arrays.cuh"

namespace deformable_contact_monitor {

// Writes a contact to place `at`, which was reserved in counters().contacts, if there is room.
__device__ inline void putContact(const CycleArrays& c, unsigned long long at, TriangleIndex a,
                                  TriangleIndex b, float separation_m) {
  if (at >= c.contacts.contacts.size()) return;
  const Place place(static_cast<std::uint32_t>(at));
  c.contacts.contacts[place] =
      std::uint64_t{min(a.value, b.value)} << c.params().index_bits | max(a.value, b.value);
  if (c.params().margins != 0) c.contacts.separations_m[place] = separation_m;
}

// Adds the contacts of the lanes in which `contact` is set to contacts.contacts. Called by a whole
// warp.
__device__ inline void reportContacts(const CycleArrays& c, bool contact, TriangleIndex a,
                                      TriangleIndex b, float separation_m) {
  const unsigned long long at = warpReserve(&c.counters().contacts, contact);
  if (contact) putContact(c, at, a, b, separation_m);
}

// Writes a candidate to place `at`, which was reserved in counters().candidates. Returns false if
// there is no room.
__device__ inline bool putCandidate(const CycleArrays& c, unsigned long long at,
                                    const DeviceCandidate& candidate) {
  if (at >= c.contacts.candidates.size()) return false;
  c.contacts.candidates[Place(static_cast<std::uint32_t>(at))] = candidate;
  return true;
}

// Writes a candidate's place to contacts.open, at a place that was reserved in counters().open. For
// triangles that share vertices the place is reserved in counters().open_adjacent and counts from
// the end of the list backwards. The verdicts on them take other branches, and all lanes of a warp
// should take the same branch. The list has as many places as there are candidates.
__device__ inline void putOpen(const CycleArrays& c, bool adjacent, std::uint32_t at,
                               Place candidate) {
  const auto& open = c.contacts.open;
  open[Place(adjacent ? open.size() - 1 - at : at)] = candidate;
}

// Adds the places of the lanes' candidates to contacts.open. Called by a whole warp.
__device__ inline void reportOpen(const CycleArrays& c, bool open, bool adjacent, Place candidate) {
  const std::uint32_t front = warpReserve(&c.counters().open, open && !adjacent);
  const std::uint32_t back = warpReserve(&c.counters().open_adjacent, open && adjacent);
  if (open) putOpen(c, adjacent, adjacent ? back : front, candidate);
}

// Copies the counters to the host. Called by each whole block as its last act; of the `blocks`
// blocks of the kernel, the last one to end makes the copy.
__device__ inline void writeFinalCounters(const CycleArrays& c, std::uint32_t blocks) {
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
  // Bypasses the first-level cache, which may hold old values.
  const auto* const from = reinterpret_cast<const std::uint32_t*>(&counters);
  auto* const words = reinterpret_cast<std::uint32_t*>(&left);
  for (unsigned k = threadIdx.x; k < kWords; k += blockDim.x) words[k] = __ldcg(from + k);
  __syncthreads();
  if (threadIdx.x == 0) {
    const unsigned long long room = c.contacts.candidates.size();
    left.examined += min(left.candidates, room);
    left.unexamined += left.candidates - min(left.candidates, room);
    counters.examined = left.examined;
    counters.unexamined = left.unexamined;
  }
  __syncthreads();
  auto* const to = reinterpret_cast<std::uint32_t*>(c.host_counters.onHost());
  for (unsigned k = threadIdx.x; k < kWords; k += blockDim.x) to[k] = words[k];
}

}  // namespace deformable_contact_monitor
