#include "cuda/cold_start.h"

#include <algorithm>

#include "core/cpu/pose.h"
#include "core/cpu/size_split.h"
#include "core/rules/sampling.h"

namespace deformable_contact_monitor {

namespace {

Vec3f seedAt(const SizeSplit& split, const Triangle& t) {
  Vec3f points[3];
  split.scaled(t, points);
  return meanOf<Triangle>(points);
}
Vec3f seedAt(const SizeSplit& split, const MovingTriangle& t) {
  Vec3f points[6];
  split.scaled(t, points);
  return meanOf<MovingTriangle>(points);
}

template <class Hull>
ColdStart measure(const Scene& scene, const Options& options, const ClusterCountPolicy& policy,
                  const CycleLimit& limit) {
  WorkingSet set;
  SizeSplit split;
  Counters counters;
  ColdStart start;
  WorkingSetBuilder().build<Hull>(scene, set, counters, limit);
  if (!limit.wasOver()) splitBySize(set, split, limit);
  if (limit.wasOver()) return start;
  start.scale = split.scale;
  start.size_rule = split.rule;
  start.regular = split.regular.size();
  start.large = split.large.size();
  start.seeds.resize(
      std::max<std::size_t>(1, clusterCountFor(options.clusters, policy, start.regular, 0)));
  for (std::size_t g = 0; g < start.seeds.size() && start.regular > 0; ++g) {
    const TriangleIndex t = split.regular[seedOf(g, start.seeds.size(), start.regular)];
    start.seeds[g] = seedAt(split, set.posed<Hull>(t));
  }
  return start;
}

}  // namespace

ColdStart measureScene(const Scene& scene, const Options& options, const ClusterCountPolicy& policy,
                       const CycleLimit& limit) {
  return options.motion == Motion::kSwept ? measure<MovingTriangle>(scene, options, policy, limit)
                                          : measure<Triangle>(scene, options, policy, limit);
}

}  // namespace deformable_contact_monitor
