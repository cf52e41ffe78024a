#include "core/cpu/prototypes.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/common/parallel.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kLength = 64;  // longer lists cost more to build than they save here
static_assert(kLength <= kMostNeighbours);

// Of those that coincide the first. The others keep their order, so that a cluster has the same
// number from cycle to cycle.
std::vector<Vec3f> distinct(const std::vector<Vec3f>& prototypes, const CycleLimit& limit) {
  // Sorted by x, a prototype's duplicates are near in the order.
  std::vector<std::uint32_t> order(prototypes.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&prototypes](std::uint32_t a, std::uint32_t b) {
    return prototypes[a].x != prototypes[b].x ? prototypes[a].x < prototypes[b].x : a < b;
  });
  std::vector<bool> duplicate(prototypes.size(), false);
  PacedLimit pace(limit, 1 << 16);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Vec3f& p = prototypes[order[i]];
    for (std::size_t j = i; j-- > 0 && !pace.over();) {
      const Vec3f& q = prototypes[order[j]];
      if (!duplicate[order[j]] && squaredDistance(p, q) < kCoincident2) duplicate[order[i]] = true;
      if (duplicate[order[i]] || (p.x - q.x) * (p.x - q.x) >= kCoincident2) break;
    }
  }
  std::vector<Vec3f> kept;
  for (std::size_t g = 0; g < prototypes.size(); ++g) {
    if (!duplicate[g]) kept.push_back(prototypes[g]);
  }
  return kept;
}

}  // namespace

void Prototypes::build(const std::vector<Vec3f>& prototypes, const CycleLimit& limit) {
  points_ = distinct(prototypes, limit);
  list_reach_.resize(points_.size());
  neighbours_.assign(points_.size() * kMostNeighbours, Neighbour());
  neighbour_cluster_.resize(neighbours_.size());
  parallelBlocks(limit, points_.size(), 4, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<std::pair<float, std::uint32_t>> others;
    for (std::size_t g = begin; g < end; ++g) listNeighbours(g, others);
  });
}

// Of prototype g; `others` is scratch.
void Prototypes::listNeighbours(std::size_t g,
                                std::vector<std::pair<float, std::uint32_t>>& others) {
  const auto length = static_cast<std::uint32_t>(std::min(kLength, points_.size() - 1));
  others.clear();
  for (std::uint32_t k = 0; k < points_.size(); ++k) {
    if (k != g) others.emplace_back(squaredDistance(points_[g], points_[k]), k);
  }
  const auto last = others.begin() + length;
  std::nth_element(others.begin(), last - (length > 0 ? 1 : 0), others.end());
  std::sort(others.begin(), last);
  for (std::uint32_t i = 0; i < length; ++i) {
    const auto& [d2, k] = others[i];
    neighbours_[g * kMostNeighbours + i] = {points_[k], std::sqrt(d2)};
    neighbour_cluster_[g * kMostNeighbours + i] = k;
  }
  const bool all = length + 1 == points_.size();
  list_reach_[g] = all ? INFINITY : std::sqrt(others[length - 1].first);
}

}  // namespace deformable_contact_monitor
