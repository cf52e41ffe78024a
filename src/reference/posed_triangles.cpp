// Poses the triangles of a body one by one, with the same rounding to float32 as the backends.
// Detectors can only be compared if they start from the same numbers.
#include "reference/posed_triangles.h"

#include "core/common/posed_body.h"

namespace deformable_contact_monitor {

std::vector<PosedTriangle> finiteTriangles(const Body& body, const CycleLimit& limit) {
  const auto count = static_cast<std::uint32_t>(body.mesh.triangleCount());
  const PosedBody posed(body);
  std::vector<PosedTriangle> triangles;
  triangles.reserve(count);
  PacedLimit pace(limit, 1 << 14);
  for (std::uint32_t t = 0; t < count && !pace.over(); ++t) {
    const PosedTriangle triangle{t, posed.received(t), posed.triangle(t)};
    if (isFinite(triangle.posed)) triangles.push_back(triangle);
  }
  return triangles;
}

}  // namespace deformable_contact_monitor
