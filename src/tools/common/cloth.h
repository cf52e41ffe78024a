// A square sheet of cloth that is held at one edge, falls, and is pushed by capsules.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// All points within `radius_m` of the segment a b [m].
struct Capsule {
  Eigen::Vector3d a, b;
  double radius_m = 0;
};

struct ClothOptions {
  int triangles = 5000;  // about: the nearest 2 n^2, n >= 1
  double edge_m = 0.8;   // length of the sheet's edges
  // Middle of the held edge, which runs along y. The sheet starts flat, towards -x.
  Eigen::Vector3d held_at = Eigen::Vector3d::Zero();
  std::uint32_t seed = 1;  // of the small unevenness by which the sheet starts
};

// Position-based dynamics on a grid; gravity along -z. No self-collision. The same calls give the
// same vertices, bit by bit. One thread at a time.
class Cloth {
 public:
  // Throws std::invalid_argument if an option is no positive finite number.
  explicit Cloth(const ClothOptions& options);

  // Advances by `dt_s` [s]. Afterwards every vertex that is free lies outside `obstacles` (of two
  // that overlap, outside the later one). An obstacle thinner than the grid acts as if it were
  // thicker; one that jumps may leave the sheet on either side.
  void step(double dt_s, const std::vector<Capsule>& obstacles);

  // The sheet as it lies now, float32.
  TriangleMesh mesh() const;

 private:
  struct Spring {
    std::size_t a, b;
    double length_m;
    double stiffness;  // share of an error that one pass removes, (0, 1]
  };

  std::size_t at(int row, int column) const {
    return static_cast<std::size_t>(row) * (static_cast<std::size_t>(cells_) + 1) +
           static_cast<std::size_t>(column);
  }
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
