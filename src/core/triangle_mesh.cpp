#include "core/triangle_mesh.h"

#include <stdexcept>

namespace deformable_contact_monitor {

void validate(const TriangleMesh& mesh, const std::string& name) {
  const auto refuse = [&name](const std::string& what) {
    throw std::invalid_argument(name + ": " + what);
  };
  if (mesh.vertices.size() % 3 != 0) {
    refuse(std::to_string(mesh.vertices.size()) + " vertex coordinates are no multiple of 3");
  }
  if (mesh.triangles.size() % 3 != 0) {
    refuse(std::to_string(mesh.triangles.size()) + " triangle indices are no multiple of 3");
  }
  constexpr std::size_t kLimit = std::size_t{1} << 31;
  if (mesh.vertexCount() >= kLimit || mesh.triangleCount() >= kLimit) {
    refuse("2^31 vertices or triangles or more");
  }
  const std::size_t vertex_count = mesh.vertexCount();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (mesh.triangles[i] >= vertex_count) {
      refuse("triangle " + std::to_string(i / 3) + " refers to vertex " +
             std::to_string(mesh.triangles[i]) + ", but there are " + std::to_string(vertex_count) +
             " vertices");
    }
  }
}

}  // namespace deformable_contact_monitor
