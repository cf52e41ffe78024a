// What a first cycle needs to know of the scene, found on the host from a sample of its triangles.
#pragma once

#include <cstddef>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/cpu/body_boxes.h"
#include "core/options.h"
#include "core/rules/cluster_count.h"
#include "core/rules/scene_scale.h"
#include "core/rules/size_rule.h"
#include "core/scene.h"
#include "cuda/partitions/scene_partition.h"

namespace deformable_contact_monitor {

struct ColdStart {
  SceneScale scale;
  SizeRule size_rule;
  std::vector<Vec3f> seeds;  // prototypes [scaled], at least one
  std::size_t regular = 0;   // triangles for the clusters
  std::size_t large = 0;     // triangles for the list of their own
};

// How many triangles are looked at: some hundred, which tell whether a scene is like the one
// before; some thousand, and some for each seed; or, where such a sample has turned out to mislead,
// all.
enum class Look { kGlance, kSample, kAll };

// For first cycles, and where the scene's make-up changed. Keeps the boxes of bodies whose
// vertices did not change from call to call.
class SceneMeasurer {
 public:
  // From triangles that are evenly spread over their order, the same ones each time. Numbers of
  // triangles are estimates unless all were looked at. Seeds are centroids of those that were.
  // Scale and size rule are the scene's, the rest is of what reaches into the share. Of no use
  // where the limit was over.
  ColdStart measure(const Scene& scene, const SceneShare& share, const Options& options,
                    const ClusterCountPolicy& policy, Look look, const CycleLimit& limit);

 private:
  static constexpr std::size_t kVerticesAtAGlance = 256;  // of a body

  BodyBoxes boxes_, boxes_at_a_glance_{kVerticesAtAGlance};
};

}  // namespace deformable_contact_monitor
