// The float32 plane filters over many pairs at once, in vector lanes: what most pairs end in.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/cpu/cycle_data.h"
#include "core/cpu/interval_scan.h"
#include "core/cpu/lane_triangle.h"
#include "core/predicates/plane_filter.h"

namespace deformable_contact_monitor {

// A triangle with what the filters need of it.
struct PreparedTriangle {
  LaneTriangle lanes;
  IntLanes vertex_id;
  PlaneFilter plane;
  TriangleIndex triangle;
  BodyIndex body;

  PreparedTriangle() = default;
  PreparedTriangle(const Triangle& posed, const std::array<std::uint32_t, 3>& id, TriangleIndex t,
                   BodyIndex body_of_t)
      : lanes(posed), vertex_id(identityLanes(id)), plane(posed), triangle(t), body(body_of_t) {}
};

// Keeps its buffers from call to call. One per thread and cycle.
class PairScreen {
 public:
  explicit PairScreen(const CycleInput& input);

  // Adds those of the pairs, positions in `triangles`, that are candidates. Leaves rubbish behind
  // in `pairs`. Filter by filter over all of them, so that the usual outcomes cost no mispredicted
  // branch.
  void screen(const std::vector<PreparedTriangle>& triangles, BoxPair* pairs, std::size_t count,
              std::vector<Candidate>& candidates);

  // Adds the pair if it is a candidate.
  void screen(const PreparedTriangle& a, const PreparedTriangle& b,
              std::vector<Candidate>& candidates) const;

 private:
  void screenSeparate(const PreparedTriangle& a, const PreparedTriangle& b,
                      std::vector<Candidate>& candidates) const;
  void screenNeighbours(const PreparedTriangle& a, const PreparedTriangle& b,
                        std::vector<Candidate>& candidates) const;

  const CycleInput& input_;
  bool margins_ = false;  // some body that takes part has one
  std::vector<BoxPair> neighbours_;
};

}  // namespace deformable_contact_monitor
