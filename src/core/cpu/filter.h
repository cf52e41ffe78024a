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

// A triangle with what the filters need of it. Hull: as in hull.h; of what moves: swept_screen.h.
template <class Hull>
struct PreparedTriangle;

template <>
struct PreparedTriangle<Triangle> {
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

// What a screen works in. One per thread, from cycle to cycle.
template <class Hull>
struct ScreenBuffers;

template <>
struct ScreenBuffers<Triangle> {
  // A pair, and on which side of the other's plane the vertices are.
  struct SidedPair {
    BoxPair pair;
    PlaneSides a, b;
  };

  std::vector<BoxPair> neighbours;
  std::vector<SidedPair> open, crossing;
};

// One per thread and cycle.
template <class Hull>
class PairScreen;

template <>
class PairScreen<Triangle> {
 public:
  PairScreen(const CycleInput<Triangle>& input, ScreenBuffers<Triangle>& buffers);

  // Adds those of the pairs, positions in `triangles`, that are candidates; all of a row one after
  // the other. Leaves rubbish behind in `pairs`. Filter by filter over all of them, so that the
  // usual outcomes cost no mispredicted branch.
  void screen(const std::vector<PreparedTriangle<Triangle>>& triangles, BoxPair* pairs,
              std::size_t count, Screened<Triangle>& screened);

  // Adds the pair if it is a candidate.
  void screen(const PreparedTriangle<Triangle>& a, const PreparedTriangle<Triangle>& b,
              std::vector<Candidate<Triangle>>& candidates) const;

 private:
  using SidedPair = ScreenBuffers<Triangle>::SidedPair;

  std::size_t splitOff(const std::vector<PreparedTriangle<Triangle>>& triangles, BoxPair* pairs,
                       std::size_t count, std::size_t& neighbours);
  void dropAside(const std::vector<PreparedTriangle<Triangle>>& triangles, const BoxPair* pairs,
                 std::size_t count);
  void settleCrossings(const std::vector<PreparedTriangle<Triangle>>& triangles,
                       Screened<Triangle>& screened);
  void addCandidate(const PreparedTriangle<Triangle>& a, const PreparedTriangle<Triangle>& b,
                    const PlaneSides& sides_a, const PlaneSides& sides_b,
                    std::vector<Candidate<Triangle>>& candidates) const;
  void screenSeparate(const PreparedTriangle<Triangle>& a, const PreparedTriangle<Triangle>& b,
                      std::vector<Candidate<Triangle>>& candidates) const;
  bool screenNeighbours(const PreparedTriangle<Triangle>& a, const PreparedTriangle<Triangle>& b,
                        PairFacts& facts) const;
  void settleNeighbours(const std::vector<PreparedTriangle<Triangle>>& triangles, std::size_t count,
                        Screened<Triangle>& screened) const;

  const CycleInput<Triangle>& input_;
  bool margins_ = false;  // some body that takes part has one
  bool settles_ = false;  // float32 may decide
  std::vector<BoxPair>& neighbours_;
  std::vector<SidedPair>&open_, &crossing_;  // of which so many are in use:
  std::size_t open_count_ = 0, crossing_count_ = 0;
};

}  // namespace deformable_contact_monitor
