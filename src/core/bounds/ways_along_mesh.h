// Ways along the edges of a mesh.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/scene.h"

namespace deformable_contact_monitor {

// Tells which triangles of one mesh can be reached from another one along its edges. Vertices at
// the same place (-0 equals 0) are one. An edge at a vertex that is not finite has the length 0, so
// that a rope with a hidden piece does not touch itself across it.
class WaysAlongMesh {
 public:
  // Reads the body's posed mesh, whose vertices must be on the host.
  explicit WaysAlongMesh(const Body& body);

  // Finds all vertices less than `limit_m` [m] away from the triangle. Its own are at 0.
  void startAt(std::uint32_t triangle, double limit_m);

  // Returns whether a vertex of this triangle was found by startAt().
  bool reaches(std::uint32_t triangle) const;

 private:
  struct Edge {
    std::uint32_t to;
    double length_m;
  };

  std::vector<std::uint32_t> corners_;     // three places for each triangle
  std::vector<std::uint32_t> first_edge_;  // per place, and one more
  std::vector<Edge> edges_;
  std::vector<double> way_m_;  // per place; infinite: not found
  std::vector<std::uint32_t> found_;
  std::vector<std::pair<double, std::uint32_t>> queue_;  // a heap of [way, place]
};

}  // namespace deformable_contact_monitor
