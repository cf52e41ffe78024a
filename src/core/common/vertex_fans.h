// Which triangles are around each vertex of a mesh, in their order.
#pragma once

#include <cstdint>
#include <vector>

#include "core/export.h"
#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// The ring of vertex v: ring[begin[v]] up to ring[begin[v + 1]]. Each two that follow one another
// are, with v, a triangle as the mesh has it, and there is no other with v; of a vertex that is not
// so, in too many triangles, or in none, the ring begins with v itself.
struct VertexFans {
  std::vector<std::uint32_t> begin;  // one more than vertices; empty: too large for 32 bits
  std::vector<std::uint32_t> ring;   // indices of vertices
};

// By index alone. Of a valid mesh.
DCM_EXPORT VertexFans vertexFans(const TriangleMesh& mesh);

}  // namespace deformable_contact_monitor
