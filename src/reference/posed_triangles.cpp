// What the references share: finite triangles of a body, received and posed.
#include "reference/posed_triangles.h"

#include <stdexcept>
#include <string>

namespace deformable_contact_monitor {

std::vector<PosedTriangle> finiteTriangles(const Body& body) {
  const TriangleMesh& mesh = body.mesh;
  const bool identity = body.pose.isIdentity();
  std::vector<PosedTriangle> triangles;
  triangles.reserve(mesh.triangleCount());
  for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t) {
    PosedTriangle triangle{t, {}, {}};
    bool finite = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const float* v = &mesh.vertices[std::size_t{3} * mesh.triangles[3 * std::size_t{t} + k]];
      const Vec3f received{v[0], v[1], v[2]};
      triangle.received.v[k] = received;
      triangle.posed.v[k] = identity ? received : apply(body.pose, received);
      finite = finite && isFinite(triangle.posed.v[k]);
    }
    if (finite) triangles.push_back(triangle);
  }
  return triangles;
}

bool takesPart(const Scene& scene, BodyId id) {
  for (BodyId other = 0; other < scene.bodyCount(); ++other) {
    if (scene.pairEnabled(id, other)) return true;
  }
  return false;
}

void requireValid(const Options& options) {
  std::string lines;
  for (const std::string& line : problems(options)) lines += (lines.empty() ? "" : "; ") + line;
  if (!lines.empty()) throw std::invalid_argument(lines);
}

}  // namespace deformable_contact_monitor
