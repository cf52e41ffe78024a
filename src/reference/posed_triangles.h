// What the references share: finite triangles of a body, received and posed.
#pragma once

#include <cstdint>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/options.h"
#include "core/predicates/adjacency.h"
#include "core/predicates/triangle.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

struct PosedTriangle {
  std::uint32_t index;  // in the body's mesh
  Triangle received;    // body frame
  Triangle posed;       // scene frame
};

// In ascending order of index; triangles with a non-finite vertex are left out. Not all where the
// limit was over.
std::vector<PosedTriangle> finiteTriangles(const Body& body, const CycleLimit& limit);

}  // namespace deformable_contact_monitor
