// Makes a tiling in three steps. By surface, the triangles are divided into pieces of connected
// surface first; by position, all of them are one piece. To find the pieces, all edges are sorted
// by their vertices, so that equal edges follow one another and tell which triangles are
// neighbours. Each piece grows from a seed: of all triangles beside it, the one nearest to the seed
// is taken next, which makes pieces round. Then each piece is halved again and again along its
// longest side, until the parts are full tiles. Last, each tile lists its vertices.
#include "core/tiling.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <utility>

#include "core/common/cycle_limit.h"
#include "core/common/halving.h"

namespace deformable_contact_monitor {
namespace {

struct SurfacePieces {
  std::vector<std::uint32_t> triangle;  // piece by piece
  std::vector<std::uint32_t> begin{0};  // per piece: its first place in `triangle`; one more

  std::size_t count() const { return begin.size() - 1; }
};

// An edge of a triangle, stored with the lesser of its two vertices.
struct FiledEdge {
  std::uint32_t greater;  // of its vertices
  std::uint32_t corner;   // of the mesh, at which it begins

  bool operator<(const FiledEdge& o) const {
    return greater != o.greater ? greater < o.greater : corner < o.corner;
  }
};

// Returns the vertices of the edge that begins at a corner, the lesser one first.
std::pair<std::uint32_t, std::uint32_t> endsOf(const TriangleMesh& mesh, std::size_t corner) {
  const std::size_t next = corner % 3 == 2 ? corner - 2 : corner + 1;
  return std::minmax(mesh.triangles[corner], mesh.triangles[next]);
}

// Returns all edges, grouped by their lesser vertices: those of vertex v begin at begin[v].
std::vector<FiledEdge> filedEdges(const CycleLimit& limit, const TriangleMesh& mesh,
                                  std::vector<std::uint32_t>* begin) {
  begin->assign(mesh.vertexCount() + 1, 0);
  const std::size_t count = mesh.triangles.size();
  PacedLimit pace(limit, 1 << 16);
  for (std::size_t i = 0; i < count && !pace.over(); ++i) ++(*begin)[endsOf(mesh, i).first];
  std::uint32_t total = 0;
  for (std::uint32_t& first : *begin) total += std::exchange(first, total);
  std::vector<FiledEdge> edges;
  resizeWithin(limit, count, edges);
  if (limit.wasOver()) return edges;
  for (std::size_t i = 0; i < count && !pace.over(); ++i) {
    const auto [lesser, greater] = endsOf(mesh, i);
    edges[(*begin)[lesser]++] = {greater, static_cast<std::uint32_t>(i)};
  }
  // Each entry has moved on to where the next vertex's edges begin, so all are shifted back by one.
  for (std::size_t v = begin->size() - 1; v > 0; --v) (*begin)[v] = (*begin)[v - 1];
  (*begin)[0] = 0;
  return edges;
}

// Links edges of one lesser vertex, which are sorted: each run of equal edges becomes a circle.
void linkEqual(const FiledEdge* first, const FiledEdge* last,
               std::vector<std::uint32_t>* neighbours) {
  while (first != last) {
    const FiledEdge* const circle = first;
    for (; first + 1 != last && first[1].greater == circle->greater; ++first) {
      (*neighbours)[first->corner] = first[1].corner / 3;
    }
    (*neighbours)[first->corner] = circle->corner / 3;
    ++first;
  }
}

// A triangle beside the piece that grows. The same triangle may be found several times.
struct Candidate {
  float distance2;      // from the seed [m^2]; the nearest is taken first
  std::uint32_t order;  // in which they were found: decides between equal distances
  std::uint32_t triangle;
};

bool isLater(const Candidate& a, const Candidate& b) {
  return a.distance2 != b.distance2 ? a.distance2 > b.distance2 : a.order > b.order;
}

// Grows one piece after the other, each from a seed triangle over edges.
class Grower {
 public:
  Grower(const std::vector<PlacedTriangle>& triangles, const std::vector<std::uint32_t>& neighbours,
         std::size_t most)
      : triangles_(triangles), neighbours_(neighbours), most_(most), is_taken_(triangles.size()) {
    pieces_.triangle.reserve(triangles.size());
    pieces_.begin.assign(1, 0);
  }

  SurfacePieces grow(const CycleLimit& limit) {
    PacedLimit pace(limit, 1 << 13);
    for (std::uint32_t t = 0; t < triangles_.size() && !pace.over(); ++t) {
      // The next seeds lie beside pieces that are there already, so that few gaps remain.
      seeds_.assign(1, t);
      for (std::size_t i = 0; i < seeds_.size() && !pace.over(); ++i) {
        if (!is_taken_[seeds_[i]]) pace.over(growFrom(seeds_[i]));
      }
    }
    return std::move(pieces_);
  }

 private:
  // Returns how many triangles the growing piece has.
  std::size_t size() const { return pieces_.triangle.size() - pieces_.begin.back(); }

  // Grows a piece from a seed. Returns how many triangles it has.
  std::size_t growFrom(std::uint32_t seed) {
    candidates_.clear();
    order_ = 0;
    seed_ = triangles_[seed].at;
    take(seed);
    while (size() < most_ && !candidates_.empty()) {
      std::pop_heap(candidates_.begin(), candidates_.end(), isLater);
      const std::uint32_t t = candidates_.back().triangle;
      candidates_.pop_back();
      if (!is_taken_[t]) take(t);
    }
    for (const Candidate& c : candidates_) seeds_.push_back(c.triangle);
    const std::size_t taken = size();
    pieces_.begin.push_back(static_cast<std::uint32_t>(pieces_.triangle.size()));
    return taken;
  }

  // Adds a triangle to the piece, and its neighbours to the candidates.
  void take(std::uint32_t t) {
    is_taken_[t] = true;
    pieces_.triangle.push_back(t);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t n = neighbours_[3 * std::size_t{t} + k];
      if (is_taken_[n]) continue;
      const Vec3f off = triangles_[n].at - seed_;
      candidates_.push_back({dot(off, off), order_++, n});
      std::push_heap(candidates_.begin(), candidates_.end(), isLater);
    }
  }

  const std::vector<PlacedTriangle>& triangles_;
  const std::vector<std::uint32_t>& neighbours_;
  std::size_t most_;
  std::vector<bool> is_taken_;
  SurfacePieces pieces_;
  std::vector<std::uint32_t> seeds_;
  // These describe the piece that grows now.
  std::vector<Candidate> candidates_;  // a heap
  std::uint32_t order_ = 0;
  Vec3f seed_;
};

// Returns three neighbours for each triangle of a mesh, one across each of its edges. Triangles
// that have an edge in common, however many, form a circle in the order of their indices, and each
// has the next one as its neighbour. A triangle whose edge no other triangle has is its own
// neighbour there. Takes about n log n steps at most. 32 bits must be able to number the mesh's
// corners. The list is incomplete if the limit is over.
std::vector<std::uint32_t> edgeNeighbours(const CycleLimit& limit, const TriangleMesh& mesh) {
  std::vector<std::uint32_t> neighbours, begin;
  std::vector<FiledEdge> edges = filedEdges(limit, mesh, &begin);
  resizeWithin(limit, mesh.triangles.size(), neighbours);
  if (limit.wasOver()) return neighbours;
  PacedLimit pace(limit, 1 << 14);
  for (std::size_t v = 0; v + 1 < begin.size() && !pace.over(); ++v) {
    FiledEdge *const first = edges.data() + begin[v], *const last = edges.data() + begin[v + 1];
    sortWithin(limit, static_cast<std::size_t>(last - first), std::less<>(),
               [=](const auto& less) { std::sort(first, last, less); });
    if (limit.wasOver()) break;
    linkEqual(first, last, &neighbours);
  }
  return neighbours;
}

// Divides a mesh into pieces, each triangle in one of them. Each piece is grown over edges
// (`neighbours`), from one triangle up to `most` of them, compact rather than long. `triangles` are
// all triangles of the mesh, in order. Takes n log(most) steps. If the limit is over, some
// triangles are in no piece.
SurfacePieces surfacePieces(const CycleLimit& limit, const std::vector<PlacedTriangle>& triangles,
                            const std::vector<std::uint32_t>& neighbours, std::size_t most) {
  return Grower(triangles, neighbours, most).grow(limit);
}

constexpr std::size_t kTile = Tiling::kTileTriangles;
constexpr std::size_t kRegion = kTile * Tiling::kRegionTiles;

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
