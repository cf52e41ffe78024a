#include "core/tiling.h"

#include <cstddef>
#include <stdexcept>

#include "core/cycle_limit.h"
#include "core/tiles/halving.h"
#include "core/tiles/layout.h"

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

}  // namespace

Tiling tilingByPosition(const TriangleMesh& mesh) {
  Tiling tiling = emptyTiling(mesh);
  std::vector<PlacedTriangle> all(mesh.triangleCount());
  for (std::uint32_t t = 0; t < all.size(); ++t) all[t] = placed(mesh, t);
  appendHalved(noLimit(), all, &tiling);
  layOut(noLimit(), mesh, &tiling);
  return tiling;
}

}  // namespace deformable_contact_monitor
