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

Aabb reachOf(const Triangle& t) { return boxOf(t); }
Aabb reachOf(const MovingTriangle& t) { return shareBox(boxOf(t), 0); }

// Without margins and pads: who is wrong by one or two loses nothing.
template <class Hull>
void keepShare(const WorkingSet& set, const SceneShare& share, std::vector<TriangleIndex>& list) {
  if (share.isWhole()) return;
  const auto elsewhere = [&](TriangleIndex t) {
    return !share.reaches(reachOf(set.posed<Hull>(t)));
  };
  list.erase(std::remove_if(list.begin(), list.end(), elsewhere), list.end());
}

template <class Hull>
ColdStart measure(const Scene& scene, const SceneShare& share, const Options& options,
                  const ClusterCountPolicy& policy, const CycleLimit& limit) {
  WorkingSet set;
  SizeSplit split;
  Counters counters;
  ColdStart start;
  WorkingSetBuilder().build<Hull>(scene, set, counters, limit);
  if (!limit.wasOver()) splitBySize(set, split, limit);
  if (limit.wasOver()) return start;
  keepShare<Hull>(set, share, split.regular);
  keepShare<Hull>(set, share, split.large);
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

ColdStart measureScene(const Scene& scene, const SceneShare& share, const Options& options,
                       const ClusterCountPolicy& policy, const CycleLimit& limit) {
  return options.motion == Motion::kSwept
             ? measure<MovingTriangle>(scene, share, options, policy, limit)
             : measure<Triangle>(scene, share, options, policy, limit);
}

}  // namespace deformable_contact_monitor
