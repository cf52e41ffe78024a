// Declares the arrays of candidates and contacts, for the stages sweep, oversized, narrow_phase and
// output.
#pragma once

#include <cstdint>

#include "core/detector.h"
#include "core/predicates/swept_triangle.h"
#include "cuda/memory/device_memory.cuh"

namespace deformable_contact_monitor {

// A pair of tile entries for the narrow phase, with what the earlier filters found out.
struct DeviceCandidate {
  TileEntryIndex a, b;
  // Two bits (side + 1) for each of the three vertices of either triangle, then three bits for the
  // shared vertices of either triangle. In swept motion see stages/swept_pairs.cuh.
  std::uint32_t facts;
};

// The state of a candidate in swept motion, while its features are examined. Times are stored as
// bits of non-negative floats, which have the same order as the floats.
struct alignas(16) SweptState {
  std::uint32_t low, high;  // of the features that meet; 2 if none does yet
  std::uint32_t open_low;   // no open feature meets before this time
  std::uint32_t bits;       // which features are open, and flags: see stages/swept_pairs.cuh
};

// A pair of swept motion that the device leaves to the host.
struct OpenPair {
  MovingTriangle a, b;
  TriangleIndex triangle_a, triangle_b;
  std::uint32_t shared;  // bits of the shared vertices of a, and of b << 3
  std::uint32_t open;    // as in SweptVerdict::open
  float low, high;       // as in SweptVerdict
  std::uint32_t meets_at_end;
  float pad_m;  // of the two bodies together [m]
};

// The time interval of a contact in swept motion, stored beside its key. `high` is negative if only
// the pad makes the pair a contact.
struct alignas(8) ContactTimes {
  float low, high;
};

// Lengths of the lists of the narrow phase in swept motion, see stages/narrow_phase_moving.cuh.
// They are zero at the beginning of a cycle and of each pass.
struct alignas(128) SweptCounters {
  alignas(128) std::uint32_t touching;   // candidates for the static predicates
  alignas(128) std::uint32_t moving;     // pairs for the fixed directions
  alignas(128) std::uint32_t robust;     // pairs for the robust static predicates
  alignas(128) std::uint32_t featured;   // pairs for the test of their features
  alignas(128) std::uint32_t left;       // pairs with features that float32 leaves open
  alignas(128) std::uint32_t beyond;     // pairs that share vertices, left open by float32
  alignas(128) std::uint32_t dismissed;  // pairs that only a pad may make contacts
};

struct ContactArrays : ArrayGroup {
  using ArrayGroup::ArrayGroup;

  DeviceArray<DeviceCandidate, Place> candidates{*this, &CycleSizes::candidates};
  // Places of candidates that need the full verdict. Those that share vertices are stored from the
  // end of the array backwards.
  DeviceArray<Place, Place> open{*this, &CycleSizes::candidates};
  // Keys: the lower triangle's number << CycleParams::index_bits | the higher triangle's number.
  DeviceArray<std::uint64_t, Place> contacts{*this, &CycleSizes::contacts};
  DeviceArray<float, Place> separations_m{*this, &CycleSizes::contacts};

  // The number of contacts whose lower triangle is this one; it is zero except in stage output.
  // `row_begin` is the place of the first of them in `rows`.
  DeviceArray<std::uint32_t, TriangleIndex> row_count{*this, &CycleSizes::triangles, 1};
  DeviceArray<Place, TriangleIndex> row_begin{*this, &CycleSizes::triangles, 1};
  // The contacts grouped by their lower triangle, and their places in `contacts`.
  DeviceArray<std::uint64_t, Place> rows{*this, &CycleSizes::contacts};
  DeviceArray<Place, Place> row_from{*this, &CycleSizes::contacts};
  DeviceArray<std::uint32_t, Place> row_too_long{*this, 1U};  // 1 if a row was too long

  // Lists of candidates' places in swept motion; see stages/narrow_phase_moving.cuh.
  DeviceArray<SweptState, Place> states{*this, &CycleSizes::swept_candidates};
  DeviceArray<Place, Place> first_list{*this, &CycleSizes::swept_candidates};
  DeviceArray<Place, Place> second_list{*this, &CycleSizes::swept_candidates};
  DeviceArray<Place, Place> third_list{*this, &CycleSizes::swept_candidates};
  DeviceArray<Place, Place> dismissed{*this, &CycleSizes::swept_candidates};
  DeviceArray<ContactTimes, Place> times{*this, &CycleSizes::swept_contacts};
  DeviceArray<OpenPair, Place> open_pairs{*this, &CycleSizes::open_pairs};
  DeviceArray<SweptCounters, Place> swept_counters{*this, 1U};
};

}  // namespace deformable_contact_monitor
