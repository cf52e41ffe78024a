// A triangle mesh as it was received: flat arrays, nothing welded, nothing removed.
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

  // From now on it lies there; `memory` outlives it.
  void moveTo(std::pmr::memory_resource& memory) {
    vertices.moveTo(memory);
    triangles.moveTo(memory);
  }

  // Becomes that one, but stays where it lies. Without memory for that it is as it was.
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

// Throws std::invalid_argument, beginning with `name`, if an array's size is no multiple of three,
// an index is out of range, or there are 2^31 vertices or triangles or more. Non-finite vertices
// are no error here: the detector leaves their triangles out and counts them.
DCM_EXPORT void validate(const TriangleMesh& mesh, const std::string& name);

}  // namespace deformable_contact_monitor
