// The rings of vertices around each vertex of a mesh, which tell the triangles that share it.
#pragma once

#include <cstdint>
#include <vector>

#include "core/export.h"
#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// The ring of vertex v goes from ring[begin[v]] up to ring[begin[v + 1]]. Any two entries that
// follow one another form a triangle of the mesh with v, in the mesh's orientation, and the mesh
// has no other triangle with v. If a vertex has no such ring, is in too many triangles, or in none,
// its ring begins with v itself.
struct VertexFans {
  std::vector<std::uint32_t> begin;  // per vertex, and one more; empty: too large for 32 bits
  std::vector<std::uint32_t> ring;   // indices of vertices
};

// Returns the rings of a valid mesh. Compares vertices by index, not by coordinates.
DCM_EXPORT VertexFans vertexFans(const TriangleMesh& mesh);

}  // namespace deformable_contact_monitor
