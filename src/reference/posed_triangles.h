// Lists the finite triangles of a body, as received and in the scene frame. All reference backends
// start from these.
#pragma once

#include <cstdint>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/options.h"
#include "core/predicates/adjacency.h"
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
std::vector<PosedTriangle> finiteTriangles(const Body& body, const CycleLimit& limit);

}  // namespace deformable_contact_monitor
