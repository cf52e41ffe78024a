// Candidates and contacts (stages sweep, large, judge, output).
#pragma once

#include <cstdint>

#include "core/detector.h"
#include "core/predicates/swept_triangle.h"
#include "cuda/memory/device_memory.cuh"

namespace deformable_contact_monitor {

// Two members for the judge, and what is known of them.
struct DeviceCandidate {
  MemberIndex a, b;
  // Two bits for each of 3 + 3 sides (side + 1), then three for each triangle's shared vertices. In
  // swept motion see stages/swept_pairs.cuh.
  std::uint32_t facts;
};

// What is known of a candidate in swept motion, while its features are looked at. Times are bits of
// floats that are not negative: their order is that of the floats.
struct alignas(16) SweptState {
  std::uint32_t low, high;  // of the features that meet; those of 2: none does yet
  std::uint32_t open_low;   // before which no open feature meets
  std::uint32_t bits;       // of open features, and more: see stages/swept_pairs.cuh
};

// A pair that the device leaves to the host.
struct OpenPair {
  MovingTriangle a, b;
  TriangleIndex triangle_a, triangle_b;
  std::uint32_t shared;  // bits: vertices of a, of b << 3
  std::uint32_t open;    // SweptVerdict::open
  float low, high;       // SweptVerdict's
  std::uint32_t meets_at_end;
  float pad_m;  // of the two bodies
};

// Of a contact in swept motion, beside its key. A pad alone makes it: then `high` is negative.
struct alignas(8) ContactTimes {
  float low, high;
};

// What stage judge counts in swept motion; zero at the beginning of
// a cycle and of each pass.
struct alignas(128) SweptCounters {
  alignas(128) std::uint32_t touching;   // candidates for the static predicates
  alignas(128) std::uint32_t moving;     // for the fixed directions
  alignas(128) std::uint32_t robust;     // for the static predicates in full
  alignas(128) std::uint32_t featured;   // for their features
  alignas(128) std::uint32_t left;       // of those with features that float32 leaves open
  alignas(128) std::uint32_t beyond;     // of those that share vertices, left by float32
  alignas(128) std::uint32_t dismissed;  // no contacts, where a pad may make them some
};

struct ContactArrays : ArrayGroup {
  using ArrayGroup::ArrayGroup;

  DeviceArray<DeviceCandidate, Place> candidates{*this, &CycleSizes::candidates};
  // Places of candidates for the full verdict; from the end backwards, of those that share
  // vertices.
  DeviceArray<Place, Place> open{*this, &CycleSizes::candidates};
  // The lower triangle's number << CycleParams::index_bits | the higher one's.
  DeviceArray<std::uint64_t, Place> contacts{*this, &CycleSizes::contacts};
  DeviceArray<float, Place> separations_m{*this, &CycleSizes::contacts};

  // Of each triangle, how many contacts it is the lower triangle of; zero but in stage output. And
  // the place of the first of them in `rows`.
  DeviceArray<std::uint32_t, TriangleIndex> row_count{*this, &CycleSizes::triangles, 1};
  DeviceArray<Place, TriangleIndex> row_begin{*this, &CycleSizes::triangles, 1};
  // The contacts with those of one lower triangle together, and where they stand in `contacts`.
  DeviceArray<std::uint64_t, Place> rows{*this, &CycleSizes::contacts};
  DeviceArray<Place, Place> row_from{*this, &CycleSizes::contacts};
  DeviceArray<std::uint32_t, Place> row_too_long{*this, 1U};  // not 0: no order was made

  // In swept motion: what the candidates' stations are, as places of candidates.
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
