#include "core/cpu/vertex_identity.h"

#include "core/parallel.h"
#include "core/predicates/swept_triangle.h"
#include "core/rules/vertex_hash.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint32_t kFree = ~std::uint32_t{0};

Vec3f vertexAt(const std::vector<float>& xyz, std::uint32_t i) {
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
  constexpr std::size_t kBlock = 2048;
  const auto count = static_cast<std::uint32_t>(vertex_count);
  std::size_t size = 16;
  while (size < 2 * std::size_t{count}) size *= 2;
  if (table_.size() < size) table_ = std::vector<std::atomic<std::uint32_t>>(size);
  least_equal.resize(count);
  parallelBlocks(limit, size, 4 * kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) table_[s].store(kFree, std::memory_order_relaxed);
  });
  // A slot, once taken, is only ever handed to an equal vertex: so all that are equal end in one,
  // the first that is not another vertex's, and what is least is in it when all are done.
  const auto slotAfter = [size](std::size_t slot) { return (slot + 1) & (size - 1); };
  const auto enterBlock = [&](std::size_t, std::size_t begin, std::size_t end) {
    for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) {
      const auto v = at(i);
      if (!isFinite(v)) continue;
      for (std::size_t slot = hashOf(v) & (size - 1);; slot = slotAfter(slot)) {
        std::uint32_t there = table_[slot].load(std::memory_order_relaxed);
        if (there == kFree &&
            table_[slot].compare_exchange_strong(there, i, std::memory_order_relaxed)) {
          break;
        }
        if (!(at(there) == v)) continue;
        while (i < there &&
               !table_[slot].compare_exchange_weak(there, i, std::memory_order_relaxed)) {
        }
        break;
      }
    }
  };
  const auto lookUpBlock = [&](std::size_t, std::size_t begin, std::size_t end) {
    for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) {
      const auto v = at(i);
      least_equal[i] = i;
      if (!isFinite(v)) continue;
      for (std::size_t slot = hashOf(v) & (size - 1);; slot = slotAfter(slot)) {
        least_equal[i] = table_[slot].load(std::memory_order_relaxed);
        if (least_equal[i] == i || at(least_equal[i]) == v) break;
      }
    }
  };
  parallelBlocks(limit, count, kBlock, enterBlock);
  if (!limit.wasOver()) parallelBlocks(limit, count, kBlock, lookUpBlock);
}

void VertexIdentity::identify(const std::vector<float>& xyz,
                              std::vector<std::uint32_t>& least_equal, const CycleLimit& limit) {
  identifyAll([&xyz](std::uint32_t i) { return vertexAt(xyz, i); }, xyz.size() / 3, least_equal,
              limit);
}

void VertexIdentity::identify(const std::vector<float>& xyz, const std::vector<float>& earlier_xyz,
                              std::vector<std::uint32_t>& least_equal, const CycleLimit& limit) {
  identifyAll(
      [&](std::uint32_t i) {
        return MovingPoint{vertexAt(earlier_xyz, i), vertexAt(xyz, i)};
      },
      xyz.size() / 3, least_equal, limit);
}

}  // namespace deformable_contact_monitor
