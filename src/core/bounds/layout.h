// What is known of each tile once its triangles are.
#pragma once

#include "core/common/cycle_limit.h"
#include "core/tiling.h"

namespace deformable_contact_monitor {

// Fills the tiles' vertices, corners and neighbours. Where the limit is over, not all of them.
void layOut(const CycleLimit& limit, const TriangleMesh& mesh, Tiling* tiling);

}  // namespace deformable_contact_monitor
