// Candidates and contacts that were found (stages sweep, large and judge).
#pragma once

#include "core/predicates/narrow_phase.h"
#include "cuda/device/warp.cuh"
#include "cuda/memory/cycle_arrays.cuh"

namespace deformable_contact_monitor {

// Puts a contact to a place that was reserved in counters().contacts, if there is room.
__device__ inline void putContact(const CycleArrays& c, unsigned long long at, TriangleIndex a,
                                  TriangleIndex b, float separation_m) {
  if (at >= c.contacts.contacts.size()) return;
  const Place place(static_cast<std::uint32_t>(at));
  c.contacts.contacts[place] =
      std::uint64_t{min(a.value, b.value)} << c.params().index_bits | max(a.value, b.value);
  if (c.params().margins != 0) c.contacts.separations_m[place] = separation_m;
}

// By a whole warp, of which some lanes have a contact: adds to contacts.contacts.
__device__ inline void reportContacts(const CycleArrays& c, bool contact, TriangleIndex a,
                                      TriangleIndex b, float separation_m) {
  const unsigned long long at = warpReserve(&c.counters().contacts, contact);
  if (contact) putContact(c, at, a, b, separation_m);
}

// Puts a candidate to a place that was reserved in counters().candidates; false if there is no
// room.
__device__ inline bool putCandidate(const CycleArrays& c, unsigned long long at,
                                    const DeviceCandidate& candidate) {
  if (at >= c.contacts.candidates.size()) return false;
  c.contacts.candidates[Place(static_cast<std::uint32_t>(at))] = candidate;
  return true;
}

// Puts a candidate's place on contacts.open, to a place that was reserved in counters().open; of
// triangles that share vertices in counters().sharing, and from the end backwards: their verdicts
// go other ways, and warps are to go one way. As many places as candidates.
__device__ inline void putOpen(const CycleArrays& c, bool sharing, std::uint32_t at,
                               Place candidate) {
  const auto& open = c.contacts.open;
  open[Place(sharing ? open.size() - 1 - at : at)] = candidate;
}

// By a whole warp: adds the lanes' candidates' places to contacts.open.
__device__ inline void reportOpen(const CycleArrays& c, bool open, bool sharing, Place candidate) {
  const std::uint32_t front = warpReserve(&c.counters().open, open && !sharing);
  const std::uint32_t back = warpReserve(&c.counters().sharing, open && sharing);
  if (open) putOpen(c, sharing, sharing ? back : front, candidate);
}

}  // namespace deformable_contact_monitor
