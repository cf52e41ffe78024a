#include "core/common/vertex_fans.h"

#include <cstddef>

#include "core/common/parallel.h"
#include "core/rules/fan_order.h"

namespace deformable_contact_monitor {
namespace {

// Returns the edges opposite to each vertex, grouped by vertex: those of v begin at begin[v] - v.
std::vector<FanEdge> oppositeEdges(const TriangleMesh& mesh,
                                   const std::vector<std::uint32_t>& begin) {
  std::vector<FanEdge> edges(mesh.triangles.size());
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
  std::vector<FanEdge> edges = oppositeEdges(mesh, fans.begin);
  constexpr std::size_t kBlock = 4096;
  parallelBlocks(count, kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (auto v = static_cast<std::uint32_t>(begin); v < end; ++v) {
      std::uint32_t* ring = &fans.ring[fans.begin[v]];
      const std::uint32_t n = fans.begin[v + 1] - fans.begin[v] - 1;
      putRing(v, edges.data() + (fans.begin[v] - v), n, ring);
    }
  });
  return fans;
}

}  // namespace deformable_contact_monitor
