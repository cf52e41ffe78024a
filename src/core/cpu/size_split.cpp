#include "core/cpu/size_split.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/common/parallel.h"
#include "core/rules/common_motion.h"

namespace deformable_contact_monitor {
namespace {

// Returns the longest side of a box [m].
double largestSide(const Aabb& box) {
  return std::max({double{box.max.x} - box.min.x, double{box.max.y} - box.min.y,
                   double{box.max.z} - box.min.z});
}

// Returns the largest coordinate of a box, as seen from `origin` [m].
double reachFrom(const Vec3d& origin, const Aabb& box) {
  return std::max({std::fabs(box.min.x - origin.x), std::fabs(box.max.x - origin.x),
                   std::fabs(box.min.y - origin.y), std::fabs(box.max.y - origin.y),
                   std::fabs(box.min.z - origin.z), std::fabs(box.max.z - origin.z)});
}

Vec3d middleOf(const Aabb& box) { return (toDouble(box.min) + toDouble(box.max)) * 0.5; }

// Returns the median. Reorders the values.
double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Typical sizes in the scene, from a sample. They are medians, which outliers do not move.
struct TypicalSize {
  Vec3d origin;
  double extent = 0;
  double reach = 0;
};

// Measures typical sizes on a sample of 2 048 triangles, evenly spread over the set.
TypicalSize measure(const WorkingSet& set) {
  constexpr std::size_t kSample = 2048;
  const std::size_t count = std::min(set.size(), kSample);
  const auto medianOf = [&](const auto& value) {
    std::vector<double> values(count);
    for (std::size_t i = 0; i < count; ++i) values[i] = value(set.boxes[i * set.size() / count]);
    return median(values);
  };
  TypicalSize typical;
  // The medians of a few numbers are found before another thread has started.
  parallelBlocks(4, count < kSample ? 4 : 1, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t what = begin; what < end; ++what) {
      if (what == 0) typical.origin.x = medianOf([](const Aabb& b) { return middleOf(b).x; });
      if (what == 1) typical.origin.y = medianOf([](const Aabb& b) { return middleOf(b).y; });
      if (what == 2) typical.origin.z = medianOf([](const Aabb& b) { return middleOf(b).z; });
      if (what == 3) typical.extent = medianOf(largestSide);
    }
  });
  typical.reach = medianOf([&](const Aabb& b) { return reachFrom(typical.origin, b); });
  return typical;
}

// Fills the two lists by the rule. `oversized_in` has the number of oversized triangles in each
// block of `block_size` triangles of the set.
void list(const WorkingSet& set, const std::vector<std::size_t>& oversized_in,
          std::size_t block_size, const CycleLimit& limit, SizeSplit& split) {
  std::vector<std::size_t> oversized_before(oversized_in.size() + 1, 0);
  std::partial_sum(oversized_in.begin(), oversized_in.end(), oversized_before.begin() + 1);
  split.oversized.resize(oversized_before.back());
  split.regular.resize(set.size() - oversized_before.back());
  const SizeBounds bounds(split.rule);
  parallelBlocks(
      limit, set.size(), block_size, [&](std::size_t b, std::size_t begin, std::size_t end) {
        std::size_t oversized = oversized_before[b], regular = begin - oversized;
        for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) {
          const bool is_oversized = oversized_in[b] > 0 && bounds.isOversized(set.boxes[i]);
          (is_oversized ? split.oversized[oversized++] : split.regular[regular++]) =
              TriangleIndex(i);
        }
      });
}

}  // namespace

void splitBySize(const WorkingSet& set, SizeSplit& split, const CycleLimit& limit) {
  split.oversized.clear();
  split.scale = SceneScale();
  split.rule = SizeRule();
  if (set.size() == 0) split.regular.clear();
  if (set.size() == 0) return;
  const TypicalSize typical = measure(set);
  constexpr std::size_t kBlock = 4096;
  const std::size_t allowed = split.spare + set.size() / 64;
  const std::size_t blocks = blockCount(set.size(), kBlock);
  std::vector<std::size_t> oversized_in(blocks);
  std::vector<double> reach_in(blocks);
  SizeRule& rule = split.rule;
  rule = {typical.origin, 32 * typical.extent, 64 * typical.reach};
  while (!limit.over()) {
    const SizeBounds bounds(rule);
    parallelBlocks(
        limit, set.size(), kBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
          oversized_in[b] = 0;
          reach_in[b] = 0;
          for (std::size_t i = begin; i < end; ++i) {
            if (bounds.isOversized(set.boxes[i])) {
              ++oversized_in[b];
            } else {
              reach_in[b] = std::max(reach_in[b], reachFrom(typical.origin, set.boxes[i]));
            }
          }
        });
    std::size_t oversized = 0;
    for (const std::size_t n : oversized_in) oversized += n;
    if (oversized <= allowed) break;
    // If the typical size is zero, multiplying does not raise the bound: start from a tiny one.
    rule.most_extent = std::max(4 * rule.most_extent, 1e-44);
    rule.most_reach = std::max(4 * rule.most_reach, 1e-44);
  }
  list(set, oversized_in, kBlock, limit, split);
  split.scale.origin = typical.origin;
  const double reach = *std::max_element(reach_in.begin(), reach_in.end());
  if (reach > 0) split.scale.scale = std::ldexp(1.0, -(std::ilogb(reach) + 1));
  split.scale_after = withoutMotion(split.scale, set.common_motion);
}

}  // namespace deformable_contact_monitor
