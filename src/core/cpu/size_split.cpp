#include "core/cpu/size_split.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/common/parallel.h"
#include "core/rules/common_motion.h"

namespace deformable_contact_monitor {
namespace {

double largestSide(const Aabb& box) {
  return std::max({double{box.max.x} - box.min.x, double{box.max.y} - box.min.y,
                   double{box.max.z} - box.min.z});
}

double reachFrom(const Vec3d& origin, const Aabb& box) {
  return std::max({std::fabs(box.min.x - origin.x), std::fabs(box.max.x - origin.x),
                   std::fabs(box.min.y - origin.y), std::fabs(box.max.y - origin.y),
                   std::fabs(box.min.z - origin.z), std::fabs(box.max.z - origin.z)});
}

Vec3d middleOf(const Aabb& box) { return (toDouble(box.min) + toDouble(box.max)) * 0.5; }

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// What is usual in the scene, from a sample; outliers do not move a median.
struct Usual {
  Vec3d origin;
  double extent = 0;
  double reach = 0;
};

Usual measure(const WorkingSet& set) {
  constexpr std::size_t kSample = 2048;
  const std::size_t count = std::min(set.size(), kSample);
  const auto medianOf = [&](const auto& value) {
    std::vector<double> values(count);
    for (std::size_t i = 0; i < count; ++i) values[i] = value(set.boxes[i * set.size() / count]);
    return median(values);
  };
  Usual usual;
  // Medians of few are found before another thread is up.
  parallelBlocks(4, count < kSample ? 4 : 1, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t what = begin; what < end; ++what) {
      if (what == 0) usual.origin.x = medianOf([](const Aabb& b) { return middleOf(b).x; });
      if (what == 1) usual.origin.y = medianOf([](const Aabb& b) { return middleOf(b).y; });
      if (what == 2) usual.origin.z = medianOf([](const Aabb& b) { return middleOf(b).z; });
      if (what == 3) usual.extent = medianOf(largestSide);
    }
  });
  usual.reach = medianOf([&](const Aabb& b) { return reachFrom(usual.origin, b); });
  return usual;
}

// Fills the lists by the rule; blocks of the set have so many large triangles each.
void list(const WorkingSet& set, const std::vector<std::size_t>& large_in, std::size_t block_size,
          const CycleLimit& limit, SizeSplit& split) {
  std::vector<std::size_t> large_before(large_in.size() + 1, 0);
  std::partial_sum(large_in.begin(), large_in.end(), large_before.begin() + 1);
  split.large.resize(large_before.back());
  split.regular.resize(set.size() - large_before.back());
  parallelBlocks(
      limit, set.size(), block_size, [&](std::size_t b, std::size_t begin, std::size_t end) {
        std::size_t large = large_before[b], regular = begin - large;
        for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) {
          const bool is_large = large_in[b] > 0 && split.rule.isLarge(set.boxes[i]);
          (is_large ? split.large[large++] : split.regular[regular++]) = TriangleIndex(i);
        }
      });
}

}  // namespace

void splitBySize(const WorkingSet& set, SizeSplit& split, const CycleLimit& limit) {
  split.large.clear();
  split.scale = SceneScale();
  split.rule = SizeRule();
  if (set.size() == 0) split.regular.clear();
  if (set.size() == 0) return;
  const Usual usual = measure(set);
  constexpr std::size_t kBlock = 4096;
  const std::size_t allowed = split.spare + set.size() / 64;
  const std::size_t blocks = blockCount(set.size(), kBlock);
  std::vector<std::size_t> large_in(blocks);
  std::vector<double> reach_in(blocks);
  SizeRule& rule = split.rule;
  rule = {usual.origin, 32 * usual.extent, 64 * usual.reach};
  while (!limit.over()) {
    parallelBlocks(limit, set.size(), kBlock,
                   [&](std::size_t b, std::size_t begin, std::size_t end) {
                     large_in[b] = 0;
                     reach_in[b] = 0;
                     for (std::size_t i = begin; i < end; ++i) {
                       if (rule.isLarge(set.boxes[i])) {
                         ++large_in[b];
                       } else {
                         reach_in[b] = std::max(reach_in[b], reachFrom(usual.origin, set.boxes[i]));
                       }
                     }
                   });
    std::size_t large = 0;
    for (const std::size_t n : large_in) large += n;
    if (large <= allowed) break;
    // From a scene whose usual size is zero, the next step up is any size at all.
    rule.most_extent = std::max(4 * rule.most_extent, 1e-44);
    rule.most_reach = std::max(4 * rule.most_reach, 1e-44);
  }
  list(set, large_in, kBlock, limit, split);
  split.scale.origin = usual.origin;
  const double reach = *std::max_element(reach_in.begin(), reach_in.end());
  if (reach > 0) split.scale.scale = std::ldexp(1.0, -(std::ilogb(reach) + 1));
  split.scale_after = withoutMotion(split.scale, set.common_motion);
}

}  // namespace deformable_contact_monitor
