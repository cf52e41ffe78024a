// Makes a tiling in three steps. By surface, the triangles are divided into pieces of connected
// surface first; by position, all of them are one piece. Then each piece is halved again and again
// along its longest side, until the parts are full tiles. Last, each tile lists its vertices.
#include "core/tiling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>

#include "core/bounds/surface_pieces.h"
#include "core/common/cycle_limit.h"
#include "core/predicates/aabb.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kTile = Tiling::kTileTriangles;
constexpr std::size_t kRegion = kTile * Tiling::kRegionTiles;

// Returns the axis along which the centroids' bounding box is longest.
int longestSide(const PlacedTriangle* first, const PlacedTriangle* last) {
  Aabb box;
  for (const PlacedTriangle* t = first; t != last; ++t) box.include(t->at);
  int longest = 0;
  for (int k = 1; k < 3; ++k) {
    if (box.max[k] - box.min[k] > box.max[longest] - box.min[longest]) longest = k;
  }
  return longest;
}

// Reorders triangles so that each run of `unit` of them, from the first on, lies close together.
// `middle` is a multiple of `unit`, so that all runs but the last are full.
void halve(const CycleLimit& limit, PlacedTriangle* first, PlacedTriangle* last, std::size_t unit) {
  const auto count = static_cast<std::size_t>(last - first);
  if (count <= unit || limit.over()) return;
  PlacedTriangle* const middle = first + (count + unit - 1) / unit / 2 * unit;
  const int k = longestSide(first, last);
  const auto less = [k](const PlacedTriangle& a, const PlacedTriangle& b) {
    return a.at[k] != b.at[k] ? a.at[k] < b.at[k] : a.triangle < b.triangle;
  };
  sortWithin(limit, count, less,
             [=](const auto& by) { std::nth_element(first, middle, last, by); });
  halve(limit, first, middle, unit);
  halve(limit, middle, last, unit);
}

// Returns the triangle with its centroid; a coordinate that is not finite becomes 0.
PlacedTriangle placed(const TriangleMesh& mesh, std::uint32_t triangle) {
  const std::uint32_t* corner = &mesh.triangles[3 * std::size_t{triangle}];
  const Vec3f a = mesh.vertex(corner[0]), b = mesh.vertex(corner[1]), c = mesh.vertex(corner[2]);
  const auto mean = [](float x, float y, float z) {
    const float sum = x / 3 + y / 3 + z / 3;
    return std::isfinite(sum) ? sum : 0;
  };
  return {{mean(a.x, b.x, c.x), mean(a.y, b.y, c.y), mean(a.z, b.z, c.z)}, triangle};
}

// Appends these triangles to the tiling, in tiles and regions of their own. All of the tiles are
// full but one, and so are the regions. Takes n log n steps, wherever the triangles lie. If the
// limit is over, their order is arbitrary. Reorders `triangles`.
void appendHalved(const CycleLimit& limit, std::vector<PlacedTriangle>& triangles, Tiling* tiling) {
  PlacedTriangle* const first = triangles.data();
  const std::size_t count = triangles.size();
  halve(limit, first, first + count, kRegion);
  for (std::size_t region = 0; region < count; region += kRegion) {
    const std::size_t end = std::min(count, region + kRegion);
    halve(limit, first + region, first + end, kTile);
    for (std::size_t tile = region; tile < end; tile += kTile) {
      const std::size_t size = std::min(kTile, end - tile);
      for (std::size_t i = tile; i < tile + size; ++i) {
        tiling->triangle.push_back(triangles[i].triangle);
      }
      tiling->tile_begin.push_back(static_cast<std::uint32_t>(tiling->triangle.size()));
    }
    tiling->region_begin.push_back(static_cast<std::uint32_t>(tiling->tileCount()));
  }
}

constexpr std::size_t kMostVertices = 3 * Tiling::kTileTriangles;

// Lists each tile's vertices, and the corners and neighbours of its triangles.
class TileWriter {
 public:
  TileWriter(const TriangleMesh& mesh, Tiling* tiling)
      : mesh_(mesh), tiling_(*tiling), place_(mesh.vertexCount(), kNone) {}

  void write(std::size_t tile) {
    const std::uint32_t begin = tiling_.tile_begin[tile], end = tiling_.tile_begin[tile + 1];
    count_ = 0;
    for (std::uint32_t slot = begin; slot < end; ++slot) {
      for (std::size_t k = 0; k < 3; ++k) collect(corner(slot, k));
    }
    std::sort(vertex_.begin(), vertex_.begin() + static_cast<std::ptrdiff_t>(count_));
    for (std::size_t i = 0; i < count_; ++i) place_[vertex_[i]] = static_cast<std::uint8_t>(i);
    writeSlots(begin, end);
    for (std::size_t i = 0; i < count_; ++i) {
      tiling_.vertex.push_back(vertex_[i]);
      place_[vertex_[i]] = kNone;
    }
    tiling_.vertex_begin.push_back(static_cast<std::uint32_t>(tiling_.vertex.size()));
  }

 private:
  static constexpr std::uint8_t kNone = 255;
  static_assert(kMostVertices <= kNone, "places have 8 bits");

  std::uint32_t corner(std::uint32_t slot, std::size_t k) const {
    return mesh_.triangles[3 * std::size_t{tiling_.triangle[slot]} + k];
  }

  void collect(std::uint32_t vertex) {
    if (place_[vertex] != kNone) return;
    place_[vertex] = 0;
    vertex_[count_++] = vertex;
  }

  void writeSlots(std::uint32_t begin, std::uint32_t end) {
    std::array<std::uint32_t, kMostVertices> around{};  // of each vertex: bits of its triangles
    for (std::uint32_t slot = begin; slot < end; ++slot) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint8_t place = place_[corner(slot, k)];
        tiling_.corners[slot][k] = place;
        around[place] |= std::uint32_t{1} << (slot - begin);
      }
    }
    for (std::uint32_t slot = begin; slot < end; ++slot) {
      const std::array<std::uint8_t, 3>& c = tiling_.corners[slot];
      tiling_.neighbours[slot] = around[c[0]] | around[c[1]] | around[c[2]];
    }
  }

  const TriangleMesh& mesh_;
  Tiling& tiling_;
  std::vector<std::uint8_t> place_;  // of each vertex of the mesh among the tile's
  std::array<std::uint32_t, kMostVertices> vertex_{};
  std::size_t count_ = 0;
};

// Fills the tiles' vertices, corners and neighbours; not all of them if the limit is over.
void listVertices(const CycleLimit& limit, const TriangleMesh& mesh, Tiling* tiling) {
  constexpr std::uint64_t kPace = 1024;
  TileWriter writer(mesh, tiling);
  resizeWithin(limit, tiling->triangle.size(), tiling->corners);
  resizeWithin(limit, tiling->triangle.size(), tiling->neighbours);
  if (limit.wasOver()) return;
  tiling->vertex.reserve(tiling->triangle.size());
  tiling->vertex_begin.assign(1, 0);
  PacedLimit pace(limit, kPace);
  for (std::size_t tile = 0; tile < tiling->tileCount() && !pace.over(); ++tile) {
    writer.write(tile);
  }
}

// The largest piece [triangles]. It is larger than a region because tiles fit together better
// inside a piece than across its rim. It is not much larger because distant parts of a surface, if
// they lie close together now, would share tiles, and may move apart later.
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

// Halves each piece by itself. Pieces smaller than a tile are put together and halved by position.
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
  listVertices(noLimit(), mesh, &tiling);
  return tiling;
}

Tiling tilingBySurface(const TriangleMesh& mesh, const Limits& limits) {
  const CycleLimit limit(limits);
  Tiling tiling = emptyTiling(mesh);
  std::vector<std::uint32_t> neighbours = edgeNeighbours(limit, mesh);
  if (limit.wasOver()) return {};
  const std::vector<PlacedTriangle> all = allPlaced(limit, mesh);
  if (limit.wasOver()) return {};
  const SurfacePieces pieces = surfacePieces(limit, all, neighbours, kPiece);
  if (limit.wasOver()) return {};
  neighbours = {};  // before the next steps need memory
  appendPieces(limit, all, pieces, &tiling);
  listVertices(limit, mesh, &tiling);
  if (limit.wasOver()) return {};
  return tiling;
}

}  // namespace deformable_contact_monitor
