// Stage judge in swept motion: lists of candidates go from kernel to kernel, and each kernel is one
// part of quickSweptVerdict (core/predicates/swept_intersection.h), for all of it together takes
// all registers there are. Here is what the kernels have in common.
#pragma once

#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/cut_off.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/swept_pairs.cuh"

namespace deformable_contact_monitor {

// The lists: contacts.open has what moving planes leave, and from its end backwards the pairs that
// share vertices; first_list what the static filters leave, then pairs with open features, then
// what float32 leaves of the sharers; second_list the pairs whose features are looked at;
// third_list those for the static predicates in full; dismissed those that a pad may make contacts.

__device__ inline SweptCounters& sweptCounters(const CycleArrays& c) {
  return *c.contacts.swept_counters.data();
}

__device__ inline std::uint32_t candidateCount(const CycleArrays& c) {
  return static_cast<std::uint32_t>(
      min(c.counters().candidates, static_cast<unsigned long long>(c.contacts.candidates.size())));
}

// By a whole warp: adds the lanes' places to a list.
__device__ inline void append(const DeviceArray<Place, Place>& list, std::uint32_t* counter,
                              bool wanted, Place place) {
  const std::uint32_t at = warpReserve(counter, wanted);
  if (wanted) list[Place(at)] = place;  // as many places as candidates
}

// By a whole warp: what is no contact on the straight ways may be one within a pad.
__device__ inline void dismiss(const CycleArrays& c, bool dismissed, Place place) {
  if (c.params().pads == 0) return;
  append(c.contacts.dismissed, &sweptCounters(c).dismissed, dismissed, place);
}

// By a whole warp, of which some lanes have a contact: adds to contacts.contacts.
__device__ inline void reportMoving(const CycleArrays& c, bool contact, Place candidate,
                                    const ContactTimes& times) {
  const unsigned long long at = warpReserve(&c.counters().contacts, contact);
  if (!contact || at >= c.contacts.contacts.size()) return;
  const DeviceCandidate pair = c.contacts.candidates[candidate];
  const std::uint32_t a = c.members.members[pair.a].triangle.value;
  const std::uint32_t b = c.members.members[pair.b].triangle.value;
  const Place place(static_cast<std::uint32_t>(at));
  c.contacts.contacts[place] = std::uint64_t{min(a, b)} << c.params().index_bits | max(a, b);
  c.contacts.times[place] = times;
}

// By any thread: leaves a pair to the host, with what is certain so far.
__device__ inline void leaveToHost(const CycleArrays& c, Place candidate,
                                   const SweptVerdict& quick) {
  const std::uint32_t at = atomicAdd(&c.counters().open_pairs, 1U);
  if (at >= c.contacts.open_pairs.size()) return;
  const DeviceCandidate pair = c.contacts.candidates[candidate];
  const Member& a = c.members.members[pair.a];
  const Member& b = c.members.members[pair.b];
  OpenPair& open = c.contacts.open_pairs[Place(at)];
  open.a = movingAt(c, pair.a);
  open.b = movingAt(c, pair.b);
  open.triangle_a = a.triangle;
  open.triangle_b = b.triangle;
  open.shared = sharedBitsOf(pair);
  open.open = quick.open;
  open.low = quick.first_low;
  open.high = quick.first_high;
  open.meets_at_end = quick.meets_at_end ? 1 : 0;
  open.pad_m = padOf(c, a, b);
}

// A warp's way through a list, its lanes side by side: visit(place in the list, whether there is
// one) by whole warps, until the cycle is cut off.
template <class Visit>
__device__ inline void forEachByWarp(const CycleArrays& c, std::uint32_t count,
                                     const Visit& visit) {
  const std::uint32_t stride = gridDim.x * blockDim.x;
  const std::uint32_t warp = (blockIdx.x * blockDim.x + threadIdx.x) / kWarp;
  for (std::uint32_t first = warp * kWarp; first < count; first += stride) {
    // The first round is always worth its time.
    if (first >= stride && warpIsCutOff(c, warp % kWarpsPerAsker == 0)) return;
    visit(Place(first + laneId()), first + laneId() < count);
  }
}

// In place of launchJudge, and its parts in their order.
void launchJudgeMoving(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);
void launchFeatures(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);
void launchSharers(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// A kernel over a list, in one wave.
inline void launchList(void (*kernel)(CycleArrays), unsigned threads, const CycleArrays& cycle,
                       const CycleShape& shape, cudaStream_t stream) {
  kernel<<<blocksInOneWave(kernel, threads, 0, shape.device), threads, 0, stream>>>(cycle);
}

}  // namespace deformable_contact_monitor
