#include "cuda/cold_start.h"

#include <algorithm>

#include "core/cpu/pose.h"
#include "core/cpu/size_split.h"
#include "core/rules/sampling.h"

namespace deformable_contact_monitor {

ColdStart measureScene(const Scene& scene, const Options& options, const ClusterCountPolicy& policy,
                       const CycleLimit& limit) {
  WorkingSet set;
  SizeSplit split;
  Counters counters;
  ColdStart start;
  WorkingSetBuilder().build(scene, set, counters, limit);
  if (!limit.wasOver()) splitBySize(set, split, limit);
  if (limit.wasOver()) return start;
  start.scale = split.scale;
  start.size_rule = split.rule;
  start.regular = split.regular.size();
  start.large = split.large.size();
  start.seeds.resize(
      std::max<std::size_t>(1, clusterCountFor(options.clusters, policy, start.regular, 0)));
  for (std::size_t g = 0; g < start.seeds.size() && start.regular > 0; ++g) {
    const Triangle t = set.posed(split.regular[seedOf(g, start.seeds.size(), start.regular)]);
    const Vec3f scaled[3] = {split.scale.apply(t.v[0]), split.scale.apply(t.v[1]),
                             split.scale.apply(t.v[2])};
    start.seeds[g] = centroidOf(scaled);
  }
  return start;
}

}  // namespace deformable_contact_monitor
