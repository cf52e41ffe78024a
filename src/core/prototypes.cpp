#include "core/prototypes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/parallel.h"

namespace deformable_contact_monitor {
namespace {

// Two prototypes closer than this, in a scene of size 2, would only share all their triangles.
constexpr float kCoincident2 = 1e-12F;

}  // namespace

void Prototypes::build(const std::vector<Vec3f>& prototypes) {
  // Sorted by x, a prototype's duplicates are its neighbours in the order.
  std::vector<Vec3f> sorted = prototypes;
  std::sort(sorted.begin(), sorted.end(), [](const Vec3f& a, const Vec3f& b) {
    return std::make_pair(a.x, std::make_pair(a.y, a.z)) <
           std::make_pair(b.x, std::make_pair(b.y, b.z));
  });
  points_.clear();
  for (const Vec3f& p : sorted) {
    const bool known = std::any_of(points_.rbegin(), points_.rend(), [&p](const Vec3f& q) {
      return squaredDistance(p, q) < kCoincident2;
    });
    if (!known) points_.push_back(p);
  }
  constexpr std::size_t kNeighbours = 64;
  neighbour_count_ = static_cast<std::uint32_t>(std::min(kNeighbours, points_.size() - 1));
  neighbours_.resize(points_.size() * neighbour_count_);
  parallelBlocks(points_.size(), 16, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<std::pair<float, std::uint32_t>> others;
    for (std::size_t g = begin; g < end; ++g) {
      others.clear();
      for (std::uint32_t k = 0; k < points_.size(); ++k) {
        if (k != g) others.emplace_back(squaredDistance(points_[g], points_[k]), k);
      }
      const auto last = others.begin() + neighbour_count_;
      std::nth_element(others.begin(), last - (neighbour_count_ > 0 ? 1 : 0), others.end());
      std::sort(others.begin(), last);
      for (std::uint32_t i = 0; i < neighbour_count_; ++i) {
        neighbours_[g * neighbour_count_ + i] = {points_[others[i].second],
                                                 std::sqrt(others[i].first), others[i].second};
      }
    }
  });
}

}  // namespace deformable_contact_monitor
