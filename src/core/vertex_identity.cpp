#include "core/vertex_identity.h"

#include <cstddef>
#include <cstring>

#include "core/vector3.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint32_t kFree = ~std::uint32_t{0};

std::uint64_t mixed(std::uint64_t x) {  // the finaliser of MurmurHash3
  x ^= x >> 33;
  x *= 0xff51afd7ed558ccdU;
  x ^= x >> 33;
  x *= 0xc4ceb9fe1a85ec53U;
  return x ^ x >> 33;
}

std::uint64_t hashOf(const Vec3f& v) {
  const float xyz[3] = {v.x + 0.0F, v.y + 0.0F, v.z + 0.0F};  // -0 becomes 0
  std::uint32_t bits[3];
  std::memcpy(bits, xyz, sizeof bits);
  return mixed((std::uint64_t{bits[0]} << 32 | bits[1]) ^ mixed(bits[2]));
}

}  // namespace

void VertexIdentity::identify(const std::vector<float>& xyz,
                              std::vector<std::uint32_t>& least_equal) {
  const auto count = static_cast<std::uint32_t>(xyz.size() / 3);
  const auto at = [&xyz](std::uint32_t i) {
    const float* v = &xyz[3 * std::size_t{i}];
    return Vec3f{v[0], v[1], v[2]};
  };
  std::size_t size = 16;
  while (size < 2 * std::size_t{count}) size *= 2;
  table_.assign(size, kFree);
  least_equal.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3f v = at(i);
    least_equal[i] = i;
    if (!isFinite(v)) continue;
    std::size_t slot = hashOf(v) & (size - 1);
    while (table_[slot] != kFree && at(table_[slot]) != v) slot = (slot + 1) & (size - 1);
    if (table_[slot] == kFree) table_[slot] = i;
    least_equal[i] = table_[slot];
  }
}

}  // namespace deformable_contact_monitor
