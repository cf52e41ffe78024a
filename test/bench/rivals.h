// Other libraries on the same job, one thread each; the calling thread limits TBB.
#pragma once

#include <cstddef>

#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// Pairs of overlapping closed AABBs of the mesh's triangles, neighbours included; boxes only.
std::size_t cgalBoxPairs(const TriangleMesh& mesh);

// The same by Embree's rtcCollide, tree built from scratch, as its users do each frame.
std::size_t embreeBoxPairs(const TriangleMesh& mesh);

}  // namespace deformable_contact_monitor
