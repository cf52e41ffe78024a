// Lists the finite triangles of a body, as received and in the scene frame. All reference backends
// start from these, with the same rounding to float32 as the other backends.
#pragma once

#include <cstdint>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/common/posed_body.h"
#include "core/predicates/triangle.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// One triangle of a body.
struct PosedTriangle {
  std::uint32_t index;  // in the body's mesh
  Triangle received;    // body frame
  Triangle posed;       // scene frame
};

// Returns the triangles of a body in ascending order of index. Triangles with a vertex that is not
// finite are left out. Once the limit is over, some are missing.
inline std::vector<PosedTriangle> finiteTriangles(const Body& body, const CycleLimit& limit) {
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
