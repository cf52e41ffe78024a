// A square sheet of cloth that is held at one edge, falls, and is pushed by capsules.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// A capsule: all points within `radius_m` of the segment from a to b [m].
struct Capsule {
  Eigen::Vector3d a, b;
  double radius_m = 0;
};

// The size, the place and the start of a sheet.
struct ClothOptions {
  int triangles = 5000;  // about: the nearest 2 n^2, n >= 1
  double edge_m = 0.8;   // length of the sheet's edges
  // The middle of the held edge, which runs along y [m]. The sheet starts flat, towards -x.
  Eigen::Vector3d held_at = Eigen::Vector3d::Zero();
  std::uint32_t seed = 1;  // of the small unevenness by which the sheet starts
};

// Simulates the sheet by position-based dynamics on a grid, with gravity along -z and without
// self-collision. The same calls give the same vertices, bit by bit. Use it from one thread at a
// time.
class Cloth {
 public:
  // Throws std::invalid_argument if an option is no positive finite number.
  explicit Cloth(const ClothOptions& options);

  // Advances by `dt_s` [s]. Afterwards every vertex that is free lies outside `obstacles` (of two
  // that overlap, outside the later one). An obstacle thinner than the grid acts as if it were
  // thicker; one that jumps may leave the sheet on either side.
  void step(double dt_s, const std::vector<Capsule>& obstacles);

  // Returns the sheet in its present state, rounded to float32.
  TriangleMesh mesh() const;

 private:
  // A distance between two vertices that the sheet tries to keep.
  struct Spring {
    std::size_t a, b;
    double length_m;
    double stiffness;  // share of an error that one pass removes, (0, 1]
  };

  // Returns the index of a vertex. Row 0 is the held edge.
  std::size_t at(int row, int column) const {
    return static_cast<std::size_t>(row) * (static_cast<std::size_t>(cells_) + 1) +
           static_cast<std::size_t>(column);
  }
  // Parts of step() and of the constructor. cloth.cpp says how each works.
  void addSprings();
  void satisfy(const Spring& spring);
  void limitStretch();
  void pushOut(const Capsule& obstacle);
  void substep(double dt_s, const std::vector<Capsule>& obstacles);

  int cells_;  // along each edge
  double spacing_m_;
  std::vector<Spring> springs_;
  std::vector<Eigen::Vector3d> positions_, before_, velocities_;
};

}  // namespace deformable_contact_monitor
