// Declares the parts of stage narrow_phase in swept motion. Lists of candidates go from kernel to
// kernel. Each kernel is one part of quickSweptVerdict (core/predicates/swept_intersection.h),
// because a single kernel for all parts would need too many registers.
#pragma once

#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/cut_off.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/swept_pairs.cuh"

namespace deformable_contact_monitor {

// The lists are these. contacts.open has the pairs that moving planes leave, and from its end
// backwards the pairs that share vertices. first_list has the pairs that the static filters leave,
// later pairs with open features, and then pairs with shared vertices that float32 leaves.
// second_list has the pairs whose features are examined. third_list has the pairs for the robust
// static predicates. dismissed has the pairs that a pad may make contacts.

__device__ inline SweptCounters& sweptCounters(const CycleArrays& c) {
  return *c.contacts.swept_counters.data();
}

__device__ inline std::uint32_t candidateCount(const CycleArrays& c) {
  return static_cast<std::uint32_t>(
      min(c.counters().candidates, static_cast<unsigned long long>(c.contacts.candidates.size())));
}

// Adds the lanes' places to a list. Called by a whole warp.
__device__ inline void append(const DeviceArray<Place, Place>& list, std::uint32_t* counter,
                              bool wanted, Place place) {
  const std::uint32_t at = warpReserve(counter, wanted);
  if (wanted) list[Place(at)] = place;  // a list has as many places as there are candidates
}

// Lists pairs that are no contacts on their straight paths, but may be within a pad. Called by a
// whole warp.
__device__ inline void dismiss(const CycleArrays& c, bool dismissed, Place place) {
  if (c.params().pads == 0) return;
  append(c.contacts.dismissed, &sweptCounters(c).dismissed, dismissed, place);
}

// Adds the lanes' pairs for which `contact` is set to contacts.contacts, with their times. Called
// by a whole warp.
__device__ inline void reportMoving(const CycleArrays& c, bool contact, Place candidate,
                                    const ContactTimes& times) {
  const unsigned long long at = warpReserve(&c.counters().contacts, contact);
  if (!contact || at >= c.contacts.contacts.size()) return;
  const DeviceCandidate pair = c.contacts.candidates[candidate];
  const std::uint32_t a = c.tiles.entries[pair.a].triangle.value;
  const std::uint32_t b = c.tiles.entries[pair.b].triangle.value;
  const Place place(static_cast<std::uint32_t>(at));
  c.contacts.contacts[place] = std::uint64_t{min(a, b)} << c.params().index_bits | max(a, b);
  c.contacts.times[place] = times;
}

// Leaves a pair to the host, with what is certain so far. May be called by any thread.
__device__ inline void leaveToHost(const CycleArrays& c, Place candidate,
                                   const SweptVerdict& quick) {
  const std::uint32_t at = atomicAdd(&c.counters().open_pairs, 1U);
  if (at >= c.contacts.open_pairs.size()) return;
  const DeviceCandidate pair = c.contacts.candidates[candidate];
  const TileEntry& a = c.tiles.entries[pair.a];
  const TileEntry& b = c.tiles.entries[pair.b];
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

// Calls visit(place in the list, whether there is one) for all places of a list, by whole warps,
// until the cycle is cut off. The lanes of a warp have consecutive places.
template <class Visit>
__device__ inline void forEachByWarp(const CycleArrays& c, std::uint32_t count,
                                     const Visit& visit) {
  const std::uint32_t stride = gridDim.x * blockDim.x;
  const std::uint32_t warp = (blockIdx.x * blockDim.x + threadIdx.x) / kWarp;
  for (std::uint32_t first = warp * kWarp; first < count; first += stride) {
    // The first round runs in any case, so that a cycle that is cut off reports some contacts.
    if (first >= stride && warpIsCutOff(c, warp % kWarpsPerAsker == 0)) return;
    visit(Place(first + laneId()), first + laneId() < count);
  }
}

// Enqueues the stage in swept motion; launchNarrowPhase() calls it. The functions below it are
// its parts.
void launchNarrowPhaseMoving(const CycleArrays& cycle, const CycleShape& shape,
                             cudaStream_t stream);
void launchNarrowPhaseFeatures(const CycleArrays& cycle, const CycleShape& shape,
                               cudaStream_t stream);
void launchCoarseRoots(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);
void launchFineRoots(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);
void launchNarrowPhaseAdjacent(const CycleArrays& cycle, const CycleShape& shape,
                               cudaStream_t stream);

// Launches a kernel that goes through a list, with as many blocks as the device can run at once. It
// must begin with followPrevious(), and directly follow another such kernel in the stream.
inline void launchList(void (*kernel)(CycleArrays), unsigned threads, const CycleArrays& cycle,
                       const CycleShape& shape, cudaStream_t stream) {
  launchDependent(kernel, blocksInOneWave(kernel, threads, 0, shape.device), threads, 0,
                  shape.device, stream, cycle);
}

// Waits for the previous kernel, and lets the blocks of the next one come as soon as there is room.
__device__ inline void followPrevious() {
  awaitPreviousKernel();
  letNextKernelStart();
}

}  // namespace deformable_contact_monitor
