// Triangles as a file or a primitive gives them, in double, before a link's origins and scales.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

struct SourceMesh {
  std::vector<Eigen::Vector3d> vertices;                // [m], as long as no scale says otherwise
  std::vector<std::array<std::uint32_t, 3>> triangles;  // counter-clockwise seen from outside
};

// Collects source meshes into one mesh of a link. Triangles keep their order. Each vertex is
// transformed in double and rounded to float32 once; vertices whose coordinates are then equal bit
// by bit are stored once, which changes no triangle.
class LinkMeshBuilder {
 public:
  // A mirroring transform turns the winding round, so that outside stays outside. Throws
  // std::length_error beyond 2^31 vertices or triangles.
  void append(const SourceMesh& mesh, const Eigen::Affine3d& link_from_source);

  const TriangleMesh& mesh() const { return mesh_; }

 private:
  using Bits = std::array<std::uint32_t, 3>;
  struct BitsHash {
    std::size_t operator()(const Bits& bits) const;
  };

  std::uint32_t indexOf(const Eigen::Vector3d& vertex);

  TriangleMesh mesh_;
  std::unordered_map<Bits, std::uint32_t, BitsHash> index_of_;
};

}  // namespace deformable_contact_monitor
