#include "core/common/contact_geometry.h"

#include <vector>

#include "core/common/parallel.h"
#include "core/common/posed_body.h"
#include "core/rules/geometry_of_pair.h"

namespace deformable_contact_monitor {

// It has a limit of its own: a list of contacts is complete without geometry, so a limit that is
// over here must not mark the cycle as cut off.
void writeGeometry(const Scene& scene, const Options& options, DetectionResult& result) {
  constexpr std::size_t kBlock = 256;  // about 0.3 ms of work
  if (!options.geometry) return;
  std::vector<PosedBody> bodies(scene.bodies().begin(), scene.bodies().end());
  const CycleLimit limit(options.limits);
  const TrianglePairs& contacts = result.contacts;
  resizeWithin(limit, contacts.size(), result.geometry);
  if (limit.wasOver()) {
    result.geometry.clear();
    return;
  }
  parallelBlocks(
      limit, contacts.size(), kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          const TrianglePair& pair = contacts[i];
          result.geometry[i] =
              geometryOf(bodies[pair.body_a].triangle(pair.triangle_a),
                         bodies[pair.body_b].triangle(pair.triangle_b), result.separationM(i));
        }
      });
  if (limit.wasOver()) result.geometry.clear();
}

}  // namespace deformable_contact_monitor
