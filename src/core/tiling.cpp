#include "core/tiling.h"

#include <cstddef>
#include <stdexcept>

#include "core/bounds/edge_neighbours.h"
#include "core/bounds/halving.h"
#include "core/bounds/layout.h"
#include "core/bounds/limited_tiling.h"
#include "core/bounds/surface_pieces.h"
#include "core/common/cycle_limit.h"

namespace deformable_contact_monitor {
namespace {

// Grown to more than a region: tiles fit each other better within a piece than across its rim. To
// much more: far parts of a surface that lie together now share tiles, and may move apart.
constexpr std::size_t kPiece = 2 * Tiling::kRegionTiles * Tiling::kTileTriangles;

Tiling emptyTiling(const TriangleMesh& mesh) {
  if (mesh.triangles.size() > ~std::uint32_t{0}) {
    throw std::length_error("a tiling of more corners of triangles than 32 bits can number");
  }
  Tiling tiling;
  tiling.triangle.reserve(mesh.triangleCount());
  tiling.tile_begin.assign(1, 0);
  tiling.region_begin.assign(1, 0);
  return tiling;
}

std::vector<PlacedTriangle> allPlaced(const CycleLimit& limit, const TriangleMesh& mesh) {
  std::vector<PlacedTriangle> all;
  resizeWithin(limit, mesh.triangleCount(), all);
  PacedLimit pace(limit, 1 << 14);
  for (std::uint32_t t = 0; t < all.size() && !pace.over(); ++t) all[t] = placed(mesh, t);
  return all;
}

// Each is halved for itself; those of less than a tile go together.
void appendPieces(const CycleLimit& limit, const std::vector<PlacedTriangle>& triangles,
                  const SurfacePieces& pieces, Tiling* tiling) {
  std::vector<PlacedTriangle> large, small;
  for (std::size_t i = 0; i < pieces.count() && !limit.wasOver(); ++i) {
    const std::uint32_t begin = pieces.begin[i], end = pieces.begin[i + 1];
    const bool is_small = end - begin < Tiling::kTileTriangles;
    std::vector<PlacedTriangle>& to = is_small ? small : large;
    for (std::uint32_t t = begin; t < end; ++t) to.push_back(triangles[pieces.triangle[t]]);
    if (is_small) continue;
    appendHalved(limit, large, tiling);
    large.clear();
  }
  appendHalved(limit, small, tiling);
}

}  // namespace

Tiling tilingByPosition(const TriangleMesh& mesh) {
  Tiling tiling = emptyTiling(mesh);
  std::vector<PlacedTriangle> all = allPlaced(noLimit(), mesh);
  appendHalved(noLimit(), all, &tiling);
  layOut(noLimit(), mesh, &tiling);
  return tiling;
}

Tiling tilingBySurface(const TriangleMesh& mesh) { return tilingBySurface(mesh, noLimit()); }

Tiling tilingBySurface(const TriangleMesh& mesh, const CycleLimit& limit) {
  Tiling tiling = emptyTiling(mesh);
  std::vector<std::uint32_t> neighbours = edgeNeighbours(limit, mesh);
  if (limit.wasOver()) return {};
  const std::vector<PlacedTriangle> all = allPlaced(limit, mesh);
  if (limit.wasOver()) return {};
  const SurfacePieces pieces = surfacePieces(limit, all, neighbours, kPiece);
  neighbours = {};  // before more memory is needed
  appendPieces(limit, all, pieces, &tiling);
  layOut(limit, mesh, &tiling);
  return tiling;
}

}  // namespace deformable_contact_monitor
