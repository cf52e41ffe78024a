// Contacts that were found (stages sweep, large and judge).
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

}  // namespace deformable_contact_monitor
