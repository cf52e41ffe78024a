// Groups of triangles of a mesh that lie close together. Whatever is decided for a group at once
// need not be decided for its triangles. Results are right with any grouping; a good one makes them
// fast.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/export.h"
#include "core/limits.h"
#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// The tiles of a mesh: groups of triangles; and regions: groups of tiles. Every triangle has one
// slot. Slots are ordered by tile, and tiles by region. A list that begins at x_begin[i] ends at
// x_begin[i + 1], so these arrays have one entry more than there are groups.
struct DCM_EXPORT Tiling {
  static constexpr std::size_t kTileTriangles = 32;  // at most
  static constexpr std::size_t kRegionTiles = 32;    // at most

  std::vector<std::uint32_t> triangle;      // per slot: its triangle of the mesh
  std::vector<std::uint32_t> tile_begin;    // per tile: its first slot
  std::vector<std::uint32_t> region_begin;  // per region: its first tile

  std::vector<std::uint32_t> vertex;        // vertices of the mesh by tile, each once, ascending
  std::vector<std::uint32_t> vertex_begin;  // per tile: its first place in `vertex`
  // Per slot: where the triangle's corners are among its tile's vertices.
  std::vector<std::array<std::uint8_t, 3>> corners;
  // Per slot: which triangles of its tile share a vertex index with it, itself included. Bit i
  // stands for the tile's slot i.
  std::vector<std::uint32_t> neighbours;

  std::size_t tileCount() const { return tile_begin.empty() ? 0 : tile_begin.size() - 1; }
  std::size_t regionCount() const { return region_begin.empty() ? 0 : region_begin.size() - 1; }
};

// Make a tiling of a valid mesh, whose vertices may be non-finite. Throw std::length_error for more
// than 2^32 / 3 triangles.

// Groups triangles by position alone. This is quick, and good for as long as the mesh keeps its
// shape. All tiles are full but the last one.
DCM_EXPORT Tiling tilingByPosition(const TriangleMesh& mesh);

// Groups triangles by connected surface, so the tiling stays good when the mesh unfolds. Connected
// parts that are smaller than a tile are grouped by position. Takes about a third of a millisecond
// for 1 000 triangles. Returns an empty tiling if the limits end it early.
DCM_EXPORT Tiling tilingBySurface(const TriangleMesh& mesh, const Limits& limits = Limits());

}  // namespace deformable_contact_monitor
