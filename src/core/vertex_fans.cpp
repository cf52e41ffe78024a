#include "core/vertex_fans.h"

#include <algorithm>
#include <cstddef>

#include "core/parallel.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint32_t kMostTriangles = 32;  // around a vertex; ordering them takes their square

// The edge of a triangle opposite to one of its vertices.
struct Edge {
  std::uint32_t from, to;
};

// Orders the edges one behind the other; false if there is no such order.
bool order(Edge* edges, std::uint32_t count) {
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto leads_to_i = [&](const Edge& edge) { return edge.to == edges[i].from; };
    if (std::any_of(edges, edges + count, leads_to_i)) continue;
    std::swap(edges[0], edges[i]);
    break;
  }
  for (std::uint32_t i = 1; i < count; ++i) {
    std::uint32_t next = i;
    while (next < count && edges[next].from != edges[i - 1].to) ++next;
    if (next == count) return false;
    std::swap(edges[i], edges[next]);
  }
  return true;
}

// For each vertex the edges opposite to it: those of v begin at begin[v] - v.
std::vector<Edge> oppositeEdges(const TriangleMesh& mesh, const std::vector<std::uint32_t>& begin) {
  std::vector<Edge> edges(mesh.triangles.size());
  std::vector<std::uint32_t> place(begin.begin(), begin.end() - 1);
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const std::uint32_t* corner = &mesh.triangles[t];
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = corner[k];
      edges[place[v]++ - v] = {corner[(k + 1) % 3], corner[(k + 2) % 3]};
    }
  }
  return edges;
}

}  // namespace

VertexFans vertexFans(const TriangleMesh& mesh) {
  VertexFans fans;
  const std::size_t count = mesh.vertexCount();
  if (mesh.triangles.size() + count > ~std::uint32_t{0}) return fans;
  fans.begin.assign(count + 1, 1);
  fans.begin[0] = 0;
  for (const std::uint32_t v : mesh.triangles) ++fans.begin[v + 1];
  for (std::size_t v = 0; v < count; ++v) fans.begin[v + 1] += fans.begin[v];
  fans.ring.resize(mesh.triangles.size() + count);
  std::vector<Edge> edges = oppositeEdges(mesh, fans.begin);
  constexpr std::size_t kBlock = 4096;
  parallelBlocks(count, kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (auto v = static_cast<std::uint32_t>(begin); v < end; ++v) {
      std::uint32_t* ring = &fans.ring[fans.begin[v]];
      const std::uint32_t n = fans.begin[v + 1] - fans.begin[v] - 1;
      Edge* of_v = edges.data() + (fans.begin[v] - v);
      const bool ordered = n > 0 && n <= kMostTriangles && order(of_v, n);
      ring[0] = ordered ? of_v[0].from : v;
      for (std::uint32_t k = 0; k < n; ++k) ring[k + 1] = of_v[k].to;
    }
  });
  return fans;
}

}  // namespace deformable_contact_monitor
