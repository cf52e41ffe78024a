// A hash of a vertex's coordinates as received, to find equal vertices.
#pragma once

#include <cstdint>
#include <cstring>

#include "core/host_device.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

DCM_HD inline std::uint64_t mixed(std::uint64_t x) {  // the finaliser of MurmurHash3
  x ^= x >> 33;
  x *= 0xff51afd7ed558ccdU;
  x ^= x >> 33;
  x *= 0xc4ceb9fe1a85ec53U;
  return x ^ x >> 33;
}

// Returns a hash that is equal for vertices of the same body number with equal coordinates; -0
// equals 0.
DCM_HD inline std::uint64_t vertexHash(const Vec3f& v, std::uint32_t body) {
  const float xyz[3] = {v.x + 0.0F, v.y + 0.0F, v.z + 0.0F};  // -0 becomes 0
  std::uint32_t bits[3];
  std::memcpy(bits, xyz, sizeof bits);
  return mixed((std::uint64_t{bits[0]} << 32 | bits[1]) ^
               mixed(std::uint64_t{bits[2]} << 32 | body));
}

}  // namespace deformable_contact_monitor
