// A surface with fewer triangles and no holes, for pictures.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// Vertices that lie together in a cell of a grid, and hang together there, become one of them, and
// triangles of three different ones remain. Every triangle beside a removed one still meets its
// neighbours, so a closed surface stays closed. One thread at a time.
class DecimatedSurface {
 public:
  // `limit` > 0: the most triangles that remain.
  explicit DecimatedSurface(std::size_t limit) : limit_(limit) {}

  // Three indices of the mesh's vertices for each remaining triangle; of a mesh within the limit,
  // its own. Which vertices become one is chosen at the first mesh with such triangles (at the
  // first whose vertices are all finite) and kept, so that the picture moves and does not flicker.
  // The mesh must be valid. Two triangles on the same vertices are one, but for an even number,
  // which is two: every edge of a closed surface has an even number of triangles.
  const HostList<std::uint32_t>& triangles(const TriangleMesh& mesh);

 private:
  void choose(const TriangleMesh& mesh);

  const std::size_t limit_;
  double cell_m_ = 0;               // of the last choice, where the next one begins
  HostList<std::uint32_t> source_;  // the triangles that the choice is for
  HostList<std::uint32_t> remaining_;
  bool is_chosen_ = false;
};

}  // namespace deformable_contact_monitor
