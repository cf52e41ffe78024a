#include "core/cpu/size_split.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/parallel.h"
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
  const auto box = [&](std::size_t i) -> const Aabb& { return set.boxes[i * set.size() / count]; };
  Usual usual;
  std::vector<double> values(count);
  const auto medianOf = [&](const auto& value) {
    for (std::size_t i = 0; i < count; ++i) values[i] = value(box(i));
    return median(values);
  };
  usual.origin = {medianOf([](const Aabb& b) { return middleOf(b).x; }),
                  medianOf([](const Aabb& b) { return middleOf(b).y; }),
                  medianOf([](const Aabb& b) { return middleOf(b).z; })};
  usual.extent = medianOf(largestSide);
  usual.reach = medianOf([&](const Aabb& b) { return reachFrom(usual.origin, b); });
  return usual;
}

}  // namespace

void splitBySize(const WorkingSet& set, SizeSplit& split, const CycleLimit& limit) {
  split.large.clear();
  split.regular.clear();
  split.scale = SceneScale();
  split.rule = SizeRule();
  if (set.size() == 0) return;
  const Usual usual = measure(set);
  constexpr std::size_t kBlock = 8192;
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
  serialBlocks(limit, set.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) {
      (rule.isLarge(set.boxes[i]) ? split.large : split.regular).emplace_back(i);
    }
  });
  split.scale.origin = usual.origin;
  const double reach = *std::max_element(reach_in.begin(), reach_in.end());
  if (reach > 0) split.scale.scale = std::ldexp(1.0, -(std::ilogb(reach) + 1));
  split.scale_after = withoutMotion(split.scale, set.common_motion);
}

}  // namespace deformable_contact_monitor
