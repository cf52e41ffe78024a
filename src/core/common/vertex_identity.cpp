#include "core/common/vertex_identity.h"

#include "core/common/parallel.h"
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

// A hash table that all threads fill at once. A slot that is taken is only ever replaced by an
// equal vertex with a lesser index. So equal vertices all end in the same slot, the first one that
// no other vertex took, and when all are entered it holds the least of them. at(index) returns
// coordinates.
template <class Vertices>
class Table {
 public:
  // `size` is a power of two, and at most the number of slots.
  Table(std::vector<std::atomic<std::uint32_t>>& slots, std::size_t size, const Vertices& at)
      : slots_(slots), mask_(size - 1), at_(at) {}

  void enter(std::uint32_t i) {
    const auto v = at_(i);
    for (std::size_t s = hashOf(v) & mask_;; s = (s + 1) & mask_) {
      std::atomic<std::uint32_t>& slot = slots_[s];
      std::uint32_t there = slot.load(std::memory_order_relaxed);
      if (there == kFree && slot.compare_exchange_strong(there, i, std::memory_order_relaxed)) {
        return;
      }
      if (!(at_(there) == v)) continue;
      while (i < there && !slot.compare_exchange_weak(there, i, std::memory_order_relaxed)) {
      }
      return;
    }
  }

  // Returns the least vertex that equals i, which must have been entered.
  std::uint32_t leastEqual(std::uint32_t i) const {
    const auto v = at_(i);
    for (std::size_t s = hashOf(v) & mask_;; s = (s + 1) & mask_) {
      const std::uint32_t there = slots_[s].load(std::memory_order_relaxed);
      if (there == i || at_(there) == v) return there;
    }
  }

 private:
  std::vector<std::atomic<std::uint32_t>>& slots_;
  std::size_t mask_;
  const Vertices& at_;
};

}  // namespace

template <class Vertices>
void VertexIdentity::identifyAll(const Vertices& at, std::size_t vertex_count,
                                 std::vector<std::uint32_t>& least_equal, const CycleLimit& limit) {
  constexpr std::size_t kBlock = 2048;
  std::size_t size = 16;
  while (size < 2 * vertex_count) size *= 2;
  if (table_.size() < size) table_ = std::vector<std::atomic<std::uint32_t>>(size);
  least_equal.resize(vertex_count);
  parallelBlocks(limit, size, 4 * kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) table_[s].store(kFree, std::memory_order_relaxed);
  });
  Table<Vertices> table(table_, size, at);
  const auto forEach = [&](const auto& visit) {
    parallelBlocks(limit, vertex_count, kBlock,
                   [&](std::size_t, std::size_t begin, std::size_t end) {
                     for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) visit(i);
                   });
  };
  forEach([&](std::uint32_t i) {
    if (isFinite(at(i))) table.enter(i);
  });
  if (limit.wasOver()) return;  // some were not entered
  forEach([&](std::uint32_t i) { least_equal[i] = isFinite(at(i)) ? table.leastEqual(i) : i; });
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
