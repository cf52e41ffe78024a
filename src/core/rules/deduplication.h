// The deduplication rule: two triangles may be together in several clusters, but only one of these
// reports the pair. It is the lowest cluster that both are in. So every pair comes up exactly once,
// without any search for duplicates.
#pragma once

#include <cstdint>

#include "core/host_device.h"

namespace deformable_contact_monitor {

// Returns the lowest cluster that is in both of two ascending lists. They must have one in common.
DCM_HD inline std::uint32_t lowestCommon(const std::uint32_t* x, const std::uint32_t* y) {
  while (*x != *y) {
    if (*x < *y) {
      ++x;
    } else {
      ++y;
    }
  }
  return *x;
}

// Returns whether `cluster`, in which both triangles are, reports the pair. `a` and `b` are the
// triangles' ascending lists of clusters; null stands for a triangle that is in this cluster alone.
DCM_HD inline bool reportsPair(std::uint32_t cluster, const std::uint32_t* a,
                               const std::uint32_t* b) {
  return a == nullptr || b == nullptr || lowestCommon(a, b) == cluster;
}

}  // namespace deformable_contact_monitor
