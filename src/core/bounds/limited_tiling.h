// A tiling that is given up when its time is over.
#pragma once

#include "core/common/cycle_limit.h"
#include "core/tiling.h"
#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// As without a limit; where that was over, of no use.
Tiling tilingBySurface(const TriangleMesh& mesh, const CycleLimit& limit);

}  // namespace deformable_contact_monitor
