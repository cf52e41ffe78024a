// Triangles of a mesh in small groups that lie together: what is decided for a group spares its
// triangles. Any grouping is right; how good it is, is a matter of speed alone.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/export.h"
#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// Tiles of triangles, and regions of tiles. Every triangle has one slot, tile after tile.
struct DCM_EXPORT Tiling {
  static constexpr std::size_t kTileTriangles = 32;  // at most
  static constexpr std::size_t kRegionTiles = 32;    // at most

  std::vector<std::uint32_t> triangle;      // per slot: which of the mesh
  std::vector<std::uint32_t> tile_begin;    // per tile: its first slot; one more
  std::vector<std::uint32_t> region_begin;  // per region: its first tile; one more

  // Of each tile: its vertices, each once, ascending.
  std::vector<std::uint32_t> vertex;                 // of the mesh, tile after tile
  std::vector<std::uint32_t> vertex_begin;           // per tile: where its own begin; one more
  std::vector<std::array<std::uint8_t, 3>> corners;  // per slot: places among its tile's vertices
  // Per slot: a bit for each triangle of its tile, by place there, that shares a vertex by index
  // with it; itself included.
  std::vector<std::uint32_t> neighbours;

  std::size_t tileCount() const { return tile_begin.empty() ? 0 : tile_begin.size() - 1; }
  std::size_t regionCount() const { return region_begin.empty() ? 0 : region_begin.size() - 1; }
};

// Of valid meshes, whose vertices may be non-finite. Throws std::length_error for more than
// 2^32 / 3 triangles.

// By position alone: quick, and good for as long as the mesh keeps its shape. All tiles but the
// last are full.
DCM_EXPORT Tiling tilingByPosition(const TriangleMesh& mesh);

// By what hangs together, and so still good when the mesh has unfolded; what hangs together in less
// than a tile goes by position. Takes about a third of a millisecond for 1 000 triangles.
DCM_EXPORT Tiling tilingBySurface(const TriangleMesh& mesh);

}  // namespace deformable_contact_monitor
