#include "core/cpu/common_motion.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/common/posed_body.h"
#include "core/rules/common_motion.h"

namespace deformable_contact_monitor {

Vec3f commonMotionOf(const Scene& scene) {
  constexpr std::size_t kSample = 512;
  std::size_t count = 0;
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (scene.takesPart(id)) count += scene.body(id).mesh.vertexCount();
  }
  const std::size_t step = std::max<std::size_t>(1, count / kSample);
  std::vector<Vec3d> motions;
  std::size_t first = step / 2;  // of the body's vertices, one in `step`
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (!scene.takesPart(id)) continue;
    const Body& body = scene.body(id);
    const PosedBody from = PosedBody::earlier(body), to(body);
    const std::size_t vertices = body.mesh.vertexCount();
    std::size_t i = first;
    for (; i < vertices; i += step) {
      const Vec3f a = from.vertex(i), b = to.vertex(i);
      if (isFinite(a) && isFinite(b)) motions.push_back(toDouble(b) - toDouble(a));
    }
    first = i - vertices;
  }
  return commonMotion(motions);
}

}  // namespace deformable_contact_monitor
