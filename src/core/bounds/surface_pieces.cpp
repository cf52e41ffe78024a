// Divides a mesh into pieces of connected surface. First all edges are sorted by their vertices, so
// that equal edges follow one another and tell which triangles are neighbours. Then each piece
// grows from a seed: of all triangles beside it, the one nearest to the seed is taken next, which
// makes pieces round.
#include "core/bounds/surface_pieces.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <utility>

namespace deformable_contact_monitor {
namespace {

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

}  // namespace

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

SurfacePieces surfacePieces(const CycleLimit& limit, const std::vector<PlacedTriangle>& triangles,
                            const std::vector<std::uint32_t>& neighbours, std::size_t most) {
  return Grower(triangles, neighbours, most).grow(limit);
}

}  // namespace deformable_contact_monitor
