// Unsigned integers that order as floats do.
#pragma once

#include <cstdint>
#include <cstring>

#include "core/host_device.h"

namespace deformable_contact_monitor {

// -0 before 0. No NaN.
DCM_HD inline std::uint32_t orderedBits(float x) {
  std::uint32_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  return (bits & 0x80000000U) != 0 ? ~bits : bits | 0x80000000U;
}

DCM_HD inline float fromOrderedBits(std::uint32_t ordered) {
  const std::uint32_t bits = (ordered & 0x80000000U) != 0 ? ordered ^ 0x80000000U : ~ordered;
  float x;
  std::memcpy(&x, &bits, sizeof x);
  return x;
}

}  // namespace deformable_contact_monitor
