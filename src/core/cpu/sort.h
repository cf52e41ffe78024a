// Stage `sort`: a cluster's triangles in the order of their intervals along its principal axis.
#pragma once

#include <cstdint>
#include <type_traits>
#include <vector>

#include "core/cpu/assign.h"
#include "core/cpu/cycle_data.h"
#include "core/cpu/lane_box.h"
#include "core/cpu/primitive.h"
#include "core/cpu/swept_filter.h"
#include "core/rules/intervals.h"

namespace deformable_contact_monitor {

// The positions in a sorted cluster that belong to one body group.
struct GroupRange {
  std::uint32_t group, begin, end;
};

// Which of a triangle's clusters are below the one that is swept: its number, or one of these. Most
// pairs' owner is told by these two numbers alone, without a branch.
using LowerClusters = std::uint32_t;
constexpr LowerClusters kNoLower = ~LowerClusters{0};
constexpr LowerClusters kSeveralLower = kNoLower - 1;

// One cluster's members by body group, and within it by where their intervals begin. Hull: as in
// hull.h, here and below.
template <class Hull>
struct SortedCluster {
  ClusterIndex cluster;
  std::vector<GroupRange> groups;  // ascending
  // All per position. Intervals along the first axis; lo, as the next, is kScanChunk longer, so
  // that the last chunk may read on:
  std::vector<float> lo, hi;
  // Along the other two, as in PackedBox. Of what moves at the step's beginning, then at its end.
  std::vector<std::uint32_t> packed_lo[kStates<Hull>], packed_hi[kStates<Hull>];
  // Scene frame [m], grown by the body's margin or pad.
  std::vector<std::conditional_t<kIsMoving<Hull>, LaneMovingBox, LaneBox>> boxes;
  std::vector<PreparedTriangle<Hull>> triangles;
  std::vector<const std::uint32_t*> clusters;  // that the triangle is in, ascending
  std::vector<LowerClusters> lower;            // which of them are below this one

  PackedColumns packed(int state) const {
    return {packed_lo[state].data(), packed_hi[state].data()};
  }
};

// What a sorter works in. One per thread, from cycle to cycle.
template <class Hull>
struct SortBuffers {
  // What is computed for a member before its place in the order is known.
  struct Projected {
    std::uint32_t group;
    Vec3f scaled[kPoints<Hull>];
    Interval interval;                  // along the first axis, of all states
    Interval across[kStates<Hull>][2];  // along the other two
  };

  std::vector<Projected> projected;  // per member
  // Where the member's interval begins, then the member; the members ascending at first.
  std::vector<std::uint64_t> order, scratch;
};

// One per thread and cycle.
template <class Hull>
class ClusterSorter {
 public:
  ClusterSorter(const CycleInput<Hull>& input, SortBuffers<Hull>& buffers)
      : input_(input),
        pace_(input.limit, kLook),
        projected_(buffers.projected),
        order_(buffers.order),
        scratch_(buffers.scratch) {}

  // False if the limit was over: then `sorted` is of no use.
  bool sort(ClusterIndex cluster, SortedCluster<Hull>& sorted);

 private:
  using Projected = typename SortBuffers<Hull>::Projected;

  void project(const ClusterMember<Hull>* members);
  void order();
  void layOut(ClusterIndex cluster, const ClusterMember<Hull>* members,
              SortedCluster<Hull>& sorted);

  static constexpr std::uint64_t kLook = 1 << 12;  // members between looks at the limit

  const CycleInput<Hull>& input_;
  PacedLimit pace_;
  std::vector<Projected>& projected_;
  std::vector<std::uint64_t>&order_, &scratch_;
  bool one_group_ = true;
  Quantiser quantiser_[2];  // of the second and third axis
};

}  // namespace deformable_contact_monitor
