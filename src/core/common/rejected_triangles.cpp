#include "core/common/rejected_triangles.h"

#include "core/common/posed_body.h"
#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {
std::vector<RejectedTriangles> rejectedTriangles(const Scene& scene, Motion motion) {
  std::vector<RejectedTriangles> rejected(scene.bodyCount());
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (!scene.takesPart(id)) continue;
    const PosedBody now(scene.body(id)), earlier = PosedBody::earlier(scene.body(id));
    const auto count = static_cast<std::uint32_t>(scene.body(id).mesh.triangleCount());
    for (std::uint32_t t = 0; t < count; ++t) {
      bool is_rejected = false;
      for (const PosedBody* body : {&now, &earlier}) {
        if ((body == &earlier && motion == Motion::kInstant) || isFinite(body->triangle(t))) {
          continue;
        }
        is_rejected = true;
        rejected[id].by_pose = rejected[id].by_pose || isFinite(body->received(t));
      }
      rejected[id].count += is_rejected ? 1 : 0;
    }
  }
  return rejected;
}

}  // namespace deformable_contact_monitor
