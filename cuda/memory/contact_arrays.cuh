// Candidates and contacts (stages sweep, large, judge, output).
#pragma once

#include <cstdint>

#include "cuda/memory/device_memory.cuh"

namespace deformable_contact_monitor {

// Two members for the judge, and what is known of them.
struct DeviceCandidate {
  MemberIndex a, b;
  // Two bits for each of 3 + 3 sides (side + 1), then three for each triangle's shared vertices.
  std::uint32_t facts;
};

struct ContactArrays : ArrayGroup {
  using ArrayGroup::ArrayGroup;

  DeviceArray<DeviceCandidate, Place> candidates{*this, &CycleSizes::candidates};
  // Candidates that the filters could not settle: their places.
  DeviceArray<Place, Place> open{*this, &CycleSizes::candidates};
  // The lower triangle's number << CycleParams::index_bits | the higher one's.
  DeviceArray<std::uint64_t, Place> contacts{*this, &CycleSizes::contacts};
  DeviceArray<float, Place> separations_m{*this, &CycleSizes::contacts};
};

}  // namespace deformable_contact_monitor
