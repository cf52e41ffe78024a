// Float32 filters over many pairs at once, in vector lanes. They decide most pairs whose boxes
// meet.
//
// In discrete detection, plane filters come first: a pair is apart if one triangle lies on one side
// of the other's plane. Pairs that cross each other's planes then go through two determinants
// (lane_crossing.h). In continuous detection see moving_pair_filter.h. What the filters say is
// certain; what they leave open becomes a candidate of the narrow phase. With
// Predicates::kConservative, every pair that is not certainly apart becomes a candidate.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/cpu/interval_scan.h"
#include "core/cpu/lane_triangle.h"
#include "core/cpu/moving_pair_filter.h"
#include "core/cpu/pair_stages.h"
#include "core/predicates/float32_filters.h"

namespace deformable_contact_monitor {

// A triangle with all that the filters need of it.
template <class Primitive>
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

// Working memory of a filter. There is one per thread, kept from cycle to cycle.
template <class Primitive>
struct FilterBuffers;

template <>
struct FilterBuffers<Triangle> {
  // A pair, and on which side of the other's plane the vertices of a and b lie.
  struct SidedPair {
    BoxPair pair;
    PlaneSides a, b;
  };

  std::vector<BoxPair> adjacent;
  std::vector<SidedPair> open, crossing;
};

// Filters pairs. There is one per thread and cycle.
template <class Primitive>
class PairFilter;

template <>
class PairFilter<Triangle> {
 public:
  PairFilter(const CycleInput<Triangle>& input, FilterBuffers<Triangle>& buffers);

  // Filters pairs of positions in `triangles`, in which the pairs of a row follow each other. Adds
  // candidates and decided pairs to `filtered`. `pairs` is left in an unspecified state. Each
  // filter runs over all pairs before the next one, so that usual outcomes cost no mispredicted
  // branch.
  void filter(const std::vector<PreparedTriangle<Triangle>>& triangles, BoxPair* pairs,
              std::size_t count, FilteredPairs<Triangle>& filtered);

  // Filters one pair, and adds it if it is a candidate.
  void filter(const PreparedTriangle<Triangle>& a, const PreparedTriangle<Triangle>& b,
              std::vector<Candidate<Triangle>>& candidates) const;

 private:
  using SidedPair = FilterBuffers<Triangle>::SidedPair;

  std::size_t splitAdjacent(const std::vector<PreparedTriangle<Triangle>>& triangles,
                            BoxPair* pairs, std::size_t count, std::size_t& adjacent);
  void dropByPlanes(const std::vector<PreparedTriangle<Triangle>>& triangles, const BoxPair* pairs,
                    std::size_t count);
  void decideCrossings(const std::vector<PreparedTriangle<Triangle>>& triangles,
                       FilteredPairs<Triangle>& filtered);
  void addCandidate(const PreparedTriangle<Triangle>& a, const PreparedTriangle<Triangle>& b,
                    const PlaneSides& sides_a, const PlaneSides& sides_b,
                    std::vector<Candidate<Triangle>>& candidates) const;
  void filterSeparate(const PreparedTriangle<Triangle>& a, const PreparedTriangle<Triangle>& b,
                      std::vector<Candidate<Triangle>>& candidates) const;
  bool filterAdjacent(const PreparedTriangle<Triangle>& a, const PreparedTriangle<Triangle>& b,
                      PairFacts& facts) const;
  void decideAdjacent(const std::vector<PreparedTriangle<Triangle>>& triangles, std::size_t count,
                      FilteredPairs<Triangle>& filtered) const;

  const CycleInput<Triangle>& input_;
  bool margins_ = false;  // whether some body that takes part has one
  bool decides_ = false;  // whether float32 may decide
  std::vector<BoxPair>& adjacent_;
  std::vector<SidedPair>&open_, &crossing_;  // the first ..._count_ are in use
  std::size_t open_count_ = 0, crossing_count_ = 0;
};

// The same for continuous detection.
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
struct FilterBuffers<MovingTriangle> {
  MovingPairFilter lanes;
  std::vector<MovingTriangles> separate;  // the pairs that share no vertex and have no motion bound
};

// Filters pairs of moving triangles whose moving boxes intersect, as PairFilter<Triangle> does.
// Pairs that are certain contacts are candidates too, with `meet` set.
template <>
class PairFilter<MovingTriangle> {
 public:
  PairFilter(const CycleInput<MovingTriangle>& input, FilterBuffers<MovingTriangle>& buffers);

  void filter(const std::vector<PreparedTriangle<MovingTriangle>>& triangles, BoxPair* pairs,
              std::size_t count, FilteredPairs<MovingTriangle>& filtered);
  void filter(const PreparedTriangle<MovingTriangle>& a, const PreparedTriangle<MovingTriangle>& b,
              std::vector<Candidate<MovingTriangle>>& candidates) const;

 private:
  float padOf(const PreparedTriangle<MovingTriangle>& a,
              const PreparedTriangle<MovingTriangle>& b) const;

  const CycleInput<MovingTriangle>& input_;
  bool pads_ = false;  // whether some body that takes part has one
  MovingPairFilter& lanes_;
  std::vector<MovingTriangles>& separate_;
};

}  // namespace deformable_contact_monitor
