// Pieces of connected surface, the first step of a tiling by surface (core/tiling.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// A triangle of a mesh, and its centroid [m, body frame].
struct PlacedTriangle {
  Vec3f at;
  std::uint32_t triangle;
};

struct SurfacePieces {
  std::vector<std::uint32_t> triangle;  // piece by piece
  std::vector<std::uint32_t> begin{0};  // per piece: its first place in `triangle`; one more

  std::size_t count() const { return begin.size() - 1; }
};

// Returns three neighbours for each triangle of a mesh, one across each of its edges. Triangles
// that have an edge in common, however many, form a circle in the order of their indices, and each
// has the next one as its neighbour. A triangle whose edge no other triangle has is its own
// neighbour there. Takes about n log n steps at most. 32 bits must be able to number the mesh's
// corners. The list is incomplete if the limit is over.
std::vector<std::uint32_t> edgeNeighbours(const CycleLimit& limit, const TriangleMesh& mesh);

// Divides a mesh into pieces, each triangle in one of them. Each piece is grown over edges
// (`neighbours`), from one triangle up to `most` of them, compact rather than long. `triangles` are
// all triangles of the mesh, in order. Takes n log(most) steps. If the limit is over, some
// triangles are in no piece.
SurfacePieces surfacePieces(const CycleLimit& limit, const std::vector<PlacedTriangle>& triangles,
                            const std::vector<std::uint32_t>& neighbours, std::size_t most);

}  // namespace deformable_contact_monitor
