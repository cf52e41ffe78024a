#include "cuda/cold_start.h"

#include <algorithm>

#include "core/cpu/pose.h"

namespace deformable_contact_monitor {

ColdStart measureScene(const Scene& scene, const Options& options,
                       const ClusterCountPolicy& policy) {
  WorkingSet set;
  SizeSplit split;
  Counters counters;
  WorkingSetBuilder().build(scene, set, counters);
  splitBySize(set, split);
  ColdStart start;
  start.scale = split.scale;
  start.size_rule = split.rule;
  start.regular = split.regular.size();
  start.large = split.large.size();
  start.seeds.resize(std::max<std::size_t>(1, clusterCountFor(options, policy, start.regular, 0)));
  for (std::size_t g = 0; g < start.seeds.size() && start.regular > 0; ++g) {
    const std::size_t place = (2 * g + 1) * start.regular / (2 * start.seeds.size());
    const Triangle t = set.posed(split.regular[place]);
    start.seeds[g] =
        (split.scale.apply(t.v[0]) + split.scale.apply(t.v[1]) + split.scale.apply(t.v[2])) *
        (1.0F / 3);
  }
  return start;
}

}  // namespace deformable_contact_monitor
