// What the references share: finite triangles of a body, received and posed.
#include "reference/posed_triangles.h"

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

}  // namespace deformable_contact_monitor
