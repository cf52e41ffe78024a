// Triangles of a file or a primitive, in double, before a link's origins and scales are applied.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// Holds triangles as indices into a list of vertices. Vertices may be stored several times.
struct SourceMesh {
  std::vector<Eigen::Vector3d> vertices;                // [m], unless a scale is applied later
  std::vector<std::array<std::uint32_t, 3>> triangles;  // counter-clockwise seen from outside
  std::string note;  // what may not be meant as it was read from a file; empty: nothing
};

// Collects source meshes into one mesh of a link. Triangles keep their order. Each vertex is
// transformed in double and rounded to float32 once; vertices whose coordinates are then equal bit
// by bit are stored once, which changes no triangle.
class LinkMeshBuilder {
 public:
  // Adds the triangles of a mesh. If the transform mirrors, their winding is reversed, so that
  // outside stays outside. Throws std::length_error beyond 2^31 vertices or triangles.
  void append(const SourceMesh& mesh, const Eigen::Affine3d& link_from_source);

  const TriangleMesh& mesh() const { return mesh_; }

 private:
  using Bits = std::array<std::uint32_t, 3>;
  struct BitsHash {
    std::size_t operator()(const Bits& bits) const;
  };

  // Returns the index of the vertex, after rounding, and adds it if it is new.
  std::uint32_t indexOf(const Eigen::Vector3d& vertex);

  TriangleMesh mesh_;
  std::unordered_map<Bits, std::uint32_t, BitsHash> index_of_;
};

}  // namespace deformable_contact_monitor
