#include "core/bounds/edge_neighbours.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <utility>

namespace deformable_contact_monitor {
namespace {

// An edge of a triangle, filed under the lesser of its vertices.
struct FiledEdge {
  std::uint32_t greater;  // of its vertices
  std::uint32_t corner;   // of the mesh, at which it begins

  bool operator<(const FiledEdge& o) const {
    return greater != o.greater ? greater < o.greater : corner < o.corner;
  }
};

std::pair<std::uint32_t, std::uint32_t> endsOf(const TriangleMesh& mesh, std::size_t corner) {
  const std::size_t next = corner % 3 == 2 ? corner - 2 : corner + 1;
  return std::minmax(mesh.triangles[corner], mesh.triangles[next]);
}

// All edges by their lesser vertices; of vertex v they begin at begin[v].
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
  for (std::size_t v = begin->size() - 1; v > 0; --v) (*begin)[v] = (*begin)[v - 1];
  (*begin)[0] = 0;
  return edges;
}

// Of one lesser vertex, in order.
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

}  // namespace deformable_contact_monitor
