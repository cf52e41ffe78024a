#include "core/rejected_triangles.h"

#include "core/posed_body.h"
#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

std::vector<RejectedTriangles> rejectedTriangles(const Scene& scene) {
  std::vector<RejectedTriangles> rejected(scene.bodyCount());
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (!scene.takesPart(id)) continue;
    const PosedBody body(scene.body(id));
    const auto count = static_cast<std::uint32_t>(scene.body(id).mesh.triangleCount());
    for (std::uint32_t t = 0; t < count; ++t) {
      if (isFinite(body.triangle(t))) continue;
      ++rejected[id].count;
      rejected[id].by_pose = rejected[id].by_pose || isFinite(body.received(t));
    }
  }
  return rejected;
}

}  // namespace deformable_contact_monitor
