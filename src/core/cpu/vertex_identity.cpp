#include "core/cpu/vertex_identity.h"

#include "core/parallel.h"
#include "core/predicates/swept_triangle.h"
#include "core/rules/vertex_hash.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint32_t kFree = ~std::uint32_t{0};

Vec3f vertexAt(const HostList<float>& xyz, std::uint32_t i) {
  const float* v = &xyz[3 * std::size_t{i}];
  return {v[0], v[1], v[2]};
}

std::uint64_t hashOf(const Vec3f& v) { return vertexHash(v, 0); }
std::uint64_t hashOf(const MovingPoint& p) {
  return vertexHash(p.from, static_cast<std::uint32_t>(vertexHash(p.to, 0)));
}

}  // namespace

template <class Vertices>
void VertexIdentity::identifyAll(const Vertices& at, std::size_t vertex_count,
                                 std::vector<std::uint32_t>& least_equal, const CycleLimit& limit) {
  constexpr std::size_t kBlock = 8192;
  const auto count = static_cast<std::uint32_t>(vertex_count);
  std::size_t size = 16;
  while (size < 2 * std::size_t{count}) size *= 2;
  table_.assign(size, kFree);
  least_equal.resize(count);
  serialBlocks(limit, count, kBlock, [&](std::size_t begin, std::size_t end) {
    for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) {
      const auto v = at(i);
      least_equal[i] = i;
      if (!isFinite(v)) continue;
      std::size_t slot = hashOf(v) & (size - 1);
      while (table_[slot] != kFree && !(at(table_[slot]) == v)) slot = (slot + 1) & (size - 1);
      if (table_[slot] == kFree) table_[slot] = i;
      least_equal[i] = table_[slot];
    }
  });
}

void VertexIdentity::identify(const HostList<float>& xyz, std::vector<std::uint32_t>& least_equal,
                              const CycleLimit& limit) {
  identifyAll([&xyz](std::uint32_t i) { return vertexAt(xyz, i); }, xyz.size() / 3, least_equal,
              limit);
}

void VertexIdentity::identify(const HostList<float>& xyz, const HostList<float>& earlier_xyz,
                              std::vector<std::uint32_t>& least_equal, const CycleLimit& limit) {
  identifyAll(
      [&](std::uint32_t i) {
        return MovingPoint{vertexAt(earlier_xyz, i), vertexAt(xyz, i)};
      },
      xyz.size() / 3, least_equal, limit);
}

}  // namespace deformable_contact_monitor
