#include "core/cpu/vertex_identity.h"

#include <cstddef>

#include "core/parallel.h"
#include "core/rules/vertex_hash.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint32_t kFree = ~std::uint32_t{0};

}  // namespace

void VertexIdentity::identify(const std::vector<float>& xyz,
                              std::vector<std::uint32_t>& least_equal, const CycleLimit& limit) {
  constexpr std::size_t kBlock = 8192;
  const auto count = static_cast<std::uint32_t>(xyz.size() / 3);
  const auto at = [&xyz](std::uint32_t i) {
    const float* v = &xyz[3 * std::size_t{i}];
    return Vec3f{v[0], v[1], v[2]};
  };
  std::size_t size = 16;
  while (size < 2 * std::size_t{count}) size *= 2;
  table_.assign(size, kFree);
  least_equal.resize(count);
  serialBlocks(limit, count, kBlock, [&](std::size_t begin, std::size_t end) {
    for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) {
      const Vec3f v = at(i);
      least_equal[i] = i;
      if (!isFinite(v)) continue;
      std::size_t slot = vertexHash(v, 0) & (size - 1);
      while (table_[slot] != kFree && at(table_[slot]) != v) slot = (slot + 1) & (size - 1);
      if (table_[slot] == kFree) table_[slot] = i;
      least_equal[i] = table_[slot];
    }
  });
}

}  // namespace deformable_contact_monitor
