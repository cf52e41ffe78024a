// The convex pieces of a link's mesh, as shapes of Bullet.
#include "tools/simulation/link_hulls.h"

#include <LinearMath/btConvexHullComputer.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <map>

#include "core/analysis/union_find.h"

namespace deformable_contact_monitor {

std::vector<std::unique_ptr<btConvexHullShape>> linkHulls(const TriangleMesh& mesh) {
  const auto finite = [&](std::size_t vertex) {
    const Vec3f p = mesh.vertex(vertex);
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
  };
  UnionFind parts(mesh.vertexCount());
  std::map<std::array<float, 3>, std::uint32_t> first_at;
  for (std::uint32_t i = 0; i < mesh.vertexCount(); ++i) {
    if (!finite(i)) continue;
    const Vec3f p = mesh.vertex(i);
    parts.join(i, first_at.emplace(std::array<float, 3>{p.x, p.y, p.z}, i).first->second);
  }
  std::map<std::uint32_t, std::vector<btScalar>> points;  // by the part's first vertex
  std::vector<bool> taken(mesh.vertexCount());
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const std::uint32_t a = mesh.triangles[t], b = mesh.triangles[t + 1], c = mesh.triangles[t + 2];
    if (!finite(a) || !finite(b) || !finite(c)) continue;
    parts.join(a, b);
    parts.join(b, c);
    for (const std::uint32_t vertex : {a, b, c}) taken[vertex] = true;
  }
  for (std::uint32_t i = 0; i < taken.size(); ++i) {
    if (!taken[i]) continue;
    const Vec3f p = mesh.vertex(i);
    std::vector<btScalar>& of_part = points[parts.find(i)];
    of_part.insert(of_part.end(), {p.x, p.y, p.z});
  }
  std::vector<std::unique_ptr<btConvexHullShape>> hulls;
  for (const auto& [part, coordinates] : points) {
    btConvexHullComputer computer;
    computer.compute(coordinates.data(), 3 * sizeof(btScalar),
                     static_cast<int>(coordinates.size() / 3), 0, 0);
    auto hull = std::make_unique<btConvexHullShape>();
    for (int i = 0; i < computer.vertices.size(); ++i) {
      hull->addPoint(computer.vertices[i], false);
    }
    hull->setMargin(0);
    hull->recalcLocalAabb();
    hulls.push_back(std::move(hull));
  }
  return hulls;
}

}  // namespace deformable_contact_monitor
