// Measures on the host, from a sample of the triangles, what the first cycle of a scene needs: the
// scene's scale, the rule for oversized triangles, and seeds for the prototypes.
#pragma once

#include <cstddef>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/cpu/body_boxes.h"
#include "core/options.h"
#include "core/rules/clustering.h"
#include "core/rules/scene_scale.h"
#include "core/scene.h"
#include "cuda/partitions/scene_partition.h"

namespace deformable_contact_monitor {

// The result of an inspection of the scene.
struct ColdStart {
  SceneScale scale;
  SizeRule size_rule;
  std::vector<Vec3f> seeds;   // initial prototypes [scaled]; at least one
  std::size_t regular = 0;    // triangles that go to the clusters
  std::size_t oversized = 0;  // triangles that go to the oversized list
};

// Selects how many triangles an inspection examines. kBrief examines some hundred, enough to tell
// whether a scene is similar to the one before. kSample examines some thousand, and four for each
// seed. kAll examines all of them; it is used where a sample was not representative.
enum class Inspection { kBrief, kSample, kAll };

// Inspects scenes for cold starts and after changes of their bodies. It keeps the boxes of bodies
// from call to call, and recomputes only those whose vertices have changed. For one thread at a
// time.
class SceneMeasurer {
 public:
  // Inspects the scene. The sampled triangles are evenly spread over their order, and are the same
  // ones each time. Counts are estimates unless all triangles were examined; seeds are centroids of
  // examined triangles. Scale and size rule are those of the whole scene; counts and seeds only
  // concern triangles that reach into the partition. The result is meaningless if the limit was
  // over.
  ColdStart measure(const Scene& scene, const ScenePartition& partition, const Options& options,
                    const ClusterCountPolicy& policy, Inspection inspection,
                    const CycleLimit& limit);

 private:
  static constexpr std::size_t kVerticesOfBrief = 256;  // read of each body

  BodyBoxes boxes_, brief_boxes_{kVerticesOfBrief};
};

}  // namespace deformable_contact_monitor
