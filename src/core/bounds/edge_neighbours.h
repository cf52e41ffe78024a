// Which triangles of a mesh lie beside each other.
#pragma once

#include <cstdint>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// Three for each triangle, one across each of its edges: the next of those that have this edge, by
// index, in a circle, however many there are. The triangle itself where no other has it. Takes
// about n log n steps at most. Of a mesh whose corners 32 bits can number. Where the limit is over,
// the list is not whole.
std::vector<std::uint32_t> edgeNeighbours(const CycleLimit& limit, const TriangleMesh& mesh);

}  // namespace deformable_contact_monitor
