// A triangle mesh as it was received, as flat arrays. Nothing is welded or removed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <string>
#include <utility>

#include "core/export.h"
#include "core/host_list.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

struct DCM_EXPORT TriangleMesh {
  HostList<float> vertices;           // x y z per vertex [m]; may hold NaN or infinity
  HostList<std::uint32_t> triangles;  // three vertex indices per triangle

  // Moves both arrays to `memory`, which must outlive the mesh, and stays there.
  void moveTo(std::pmr::memory_resource& memory) {
    vertices.moveTo(memory);
    triangles.moveTo(memory);
  }

  // Takes the contents of `mesh`, but keeps its own memory resource. If there is not enough memory,
  // throws std::bad_alloc and stays as it was.
  void become(TriangleMesh&& mesh) {
    vertices.makeRoomFor(mesh.vertices);
    triangles.makeRoomFor(mesh.triangles);
    vertices = std::move(mesh.vertices);
    triangles = std::move(mesh.triangles);
  }

  std::size_t vertexCount() const { return vertices.size() / 3; }
  std::size_t triangleCount() const { return triangles.size() / 3; }
  Vec3f vertex(std::size_t i) const {
    return {vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]};
  }
};

// Throws std::invalid_argument, whose text begins with `name`, if the size of an array is not a
// multiple of three, an index is out of range, or there are 2^31 vertices or triangles or more.
// Non-finite vertices are not an error: the detector leaves their triangles out and counts them.
DCM_EXPORT void validate(const TriangleMesh& mesh, const std::string& name);

}  // namespace deformable_contact_monitor
