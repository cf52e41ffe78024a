#include "core/tiling.h"

#include <cstddef>
#include <stdexcept>

#include "core/tiles/edge_neighbours.h"
#include "core/tiles/halving.h"
#include "core/tiles/layout.h"
#include "core/tiles/surface_regions.h"

namespace deformable_contact_monitor {
namespace {

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

// Large regions are halved each for itself; what is less than a tile goes together.
void appendRegions(const CycleLimit& limit, const std::vector<PlacedTriangle>& triangles,
                   const SurfaceRegions& regions, Tiling* tiling) {
  std::vector<PlacedTriangle> region, small;
  for (std::size_t i = 0; i < regions.count() && !limit.wasOver(); ++i) {
    const std::uint32_t begin = regions.begin[i], end = regions.begin[i + 1];
    const bool is_small = end - begin < Tiling::kTileTriangles;
    std::vector<PlacedTriangle>& to = is_small ? small : region;
    for (std::uint32_t t = begin; t < end; ++t) to.push_back(triangles[regions.triangle[t]]);
    if (is_small) continue;
    appendHalved(limit, region, tiling);
    region.clear();
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
  constexpr std::size_t kRegion = Tiling::kRegionTiles * Tiling::kTileTriangles;
  Tiling tiling = emptyTiling(mesh);
  std::vector<std::uint32_t> neighbours = edgeNeighbours(limit, mesh);
  if (limit.wasOver()) return {};
  const std::vector<PlacedTriangle> all = allPlaced(limit, mesh);
  if (limit.wasOver()) return {};
  const SurfaceRegions regions = surfaceRegions(limit, all, neighbours, kRegion);
  neighbours = {};  // before more memory is needed
  appendRegions(limit, all, regions, &tiling);
  if (limit.wasOver()) return {};
  layOut(limit, mesh, &tiling);
  return tiling;
}

}  // namespace deformable_contact_monitor
