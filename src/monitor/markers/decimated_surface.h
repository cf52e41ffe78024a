// Draws a surface with fewer triangles and without holes, by vertex clustering.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// Vertices that lie in the same cell of a grid, and are connected within it, become one vertex.
// Triangles whose three vertices stay different remain. A triangle beside a removed one still meets
// its neighbors, so a closed surface stays closed. Not safe for use by several threads.
class DecimatedSurface {
 public:
  // `limit` (> 0) is the largest number of triangles that remain.
  explicit DecimatedSurface(std::size_t limit) : limit_(limit) {}

  // Returns three vertex indices of the mesh per remaining triangle; all triangles if the mesh is
  // within the limit. The mesh must be valid. Which vertices become one is chosen for the first
  // mesh with these triangles, and again until all vertices of a mesh are finite. Then the choice
  // stays, so that the picture moves and does not flicker. Triangles that end up on the same three
  // vertices become one, or two if their number is even: an edge of a closed surface has an even
  // number of triangles, and this keeps it even.
  const HostList<std::uint32_t>& triangles(const TriangleMesh& mesh);

 private:
  // Searches a cell size, and sets which triangles remain.
  void choose(const TriangleMesh& mesh);

  const std::size_t limit_;
  double cell_m_ = 0;               // size of the last choice; the next search begins there
  HostList<std::uint32_t> source_;  // the triangles for which the choice was made
  HostList<std::uint32_t> remaining_;
  bool is_chosen_ = false;
};

}  // namespace deformable_contact_monitor
