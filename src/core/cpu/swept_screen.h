// What filters leave of many pairs of moving triangles.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/cpu/screen.h"

namespace deformable_contact_monitor {

template <>
struct PreparedTriangle<MovingTriangle> {
  IntLanes vertex_id;
  TriangleIndex triangle;
  BodyIndex body;

  PreparedTriangle() = default;
  PreparedTriangle(const MovingTriangle& /*posed*/, const std::array<std::uint32_t, 3>& id,
                   TriangleIndex t, BodyIndex body_of_t)
      : vertex_id(identityLanes(id)), triangle(t), body(body_of_t) {}
};

// As PairScreen<Triangle>; the pairs' moving boxes intersect.
template <>
class PairScreen<MovingTriangle> {
 public:
  explicit PairScreen(const CycleInput<MovingTriangle>& input) : input_(input) {}

  void screen(const std::vector<PreparedTriangle<MovingTriangle>>& triangles, BoxPair* pairs,
              std::size_t count, std::vector<Candidate<MovingTriangle>>& candidates);
  void screen(const PreparedTriangle<MovingTriangle>& a, const PreparedTriangle<MovingTriangle>& b,
              std::vector<Candidate<MovingTriangle>>& candidates) const;

 private:
  const CycleInput<MovingTriangle>& input_;
};

}  // namespace deformable_contact_monitor
