// What filters leave of many pairs of moving triangles.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/cpu/filter.h"
#include "core/cpu/lane_screen.h"

namespace deformable_contact_monitor {

template <>
struct PreparedTriangle<MovingTriangle> {
  MovingTriangle posed;
  IntLanes vertex_id;
  TriangleIndex triangle;
  BodyIndex body;

  PreparedTriangle() = default;
  PreparedTriangle(const MovingTriangle& posed_at, const std::array<std::uint32_t, 3>& id,
                   TriangleIndex t, BodyIndex body_of_t)
      : posed(posed_at), vertex_id(identityLanes(id)), triangle(t), body(body_of_t) {}
};

template <>
struct ScreenBuffers<MovingTriangle> {
  LaneScreen lanes;
  std::vector<MovingTriangles> separate;  // the first of the pairs
};

// As PairScreen<Triangle>; the pairs' moving boxes intersect. Candidates are also the pairs that
// filters know to be contacts.
template <>
class PairScreen<MovingTriangle> {
 public:
  PairScreen(const CycleInput<MovingTriangle>& input, ScreenBuffers<MovingTriangle>& buffers);

  void screen(const std::vector<PreparedTriangle<MovingTriangle>>& triangles, BoxPair* pairs,
              std::size_t count, Screened<MovingTriangle>& screened);
  void screen(const PreparedTriangle<MovingTriangle>& a, const PreparedTriangle<MovingTriangle>& b,
              std::vector<Candidate<MovingTriangle>>& candidates) const;

 private:
  float padOf(const PreparedTriangle<MovingTriangle>& a,
              const PreparedTriangle<MovingTriangle>& b) const;

  const CycleInput<MovingTriangle>& input_;
  bool pads_ = false;  // some body that takes part has one
  LaneScreen& lanes_;
  std::vector<MovingTriangles>& separate_;
};

}  // namespace deformable_contact_monitor
