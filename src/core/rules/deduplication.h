// Which cluster reports a pair of triangles that meet in several.
#pragma once

#include <cstdint>

#include "core/host_device.h"

namespace deformable_contact_monitor {

// The lowest cluster on both of two ascending lists, which have one in common.
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

// Whether `cluster`, in which both triangles are, reports the pair: it is the lowest that they have
// in common. `a` and `b` are the triangles' ascending lists of clusters; null: in this one alone.
DCM_HD inline bool ownsPair(std::uint32_t cluster, const std::uint32_t* a, const std::uint32_t* b) {
  return a == nullptr || b == nullptr || lowestCommon(a, b) == cluster;
}

}  // namespace deformable_contact_monitor
