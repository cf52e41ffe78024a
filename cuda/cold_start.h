// What a first cycle needs to know of the scene, found on the host by the CPU backend's stages.
#pragma once

#include <cstddef>
#include <vector>

#include "core/cycle_limit.h"
#include "core/options.h"
#include "core/rules/cluster_count.h"
#include "core/rules/scene_scale.h"
#include "core/rules/size_rule.h"
#include "core/scene.h"
#include "cuda/shares/scene_share.h"

namespace deformable_contact_monitor {

struct ColdStart {
  SceneScale scale;
  SizeRule size_rule;
  std::vector<Vec3f> seeds;  // prototypes [scaled], at least one
  std::size_t regular = 0;   // triangles for the clusters
  std::size_t large = 0;     // triangles for the list of their own
};

// Costs milliseconds (of no use where the limit was over): for first cycles and changes of the
// scene's make-up. Seeds are centroids of triangles evenly spread over their order. Scale and size
// rule are the scene's, the rest is of what reaches into the share.
ColdStart measureScene(const Scene& scene, const SceneShare& share, const Options& options,
                       const ClusterCountPolicy& policy, const CycleLimit& limit);

}  // namespace deformable_contact_monitor
