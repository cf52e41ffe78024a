// Stage `sort`: lays out a cluster's triangles in the order in which their intervals along its
// principal axis begin.
//
// The sweep then reads arrays from one end to the other. Each position has its interval along the
// first axis, quantised intervals along the other two (PackedBox), and the box in the scene frame.
#pragma once

#include <cstdint>
#include <type_traits>
#include <vector>

#include "core/cpu/assign.h"
#include "core/cpu/filter.h"
#include "core/cpu/lane_triangle.h"
#include "core/cpu/pair_stages.h"
#include "core/cpu/primitive.h"
#include "core/predicates/aabb.h"
#include "core/predicates/swept_triangle.h"
#include "core/rules/intervals.h"

namespace deformable_contact_monitor {

inline FloatLanes laneCorner(const Vec3f& v) { return FloatLanes{v.x, v.y, v.z, 0}; }

// A box with finite corners. The fourth lane is 0 throughout this file.
struct LaneBox {
  FloatLanes min, max;

  LaneBox() = default;
  // The same in another form.
  LaneBox(const Aabb& box)  // NOLINT(google-explicit-constructor)
      : min(laneCorner(box.min)), max(laneCorner(box.max)) {}
};

// Returns whether two closed boxes intersect, as for Aabb.
inline bool intersects(const LaneBox& a, const LaneBox& b) {
  return laneBits((a.max < b.min) | (b.max < a.min)) == 0;
}

// Returns the box of a triangle, grown by growth_m >= 0 [m].
inline LaneBox boxLanes(const Triangle& t, float growth_m) {
  if (growth_m > 0) return inflated(boxOf(t), growth_m);
  const FloatLanes a = laneCorner(t.v[0]), b = laneCorner(t.v[1]), c = laneCorner(t.v[2]);
  LaneBox box;
  box.min = least(least(a, b), c);
  box.max = most(most(a, b), c);
  return box;
}

// A moving box: its corners at both ends of the time interval.
struct LaneMovingBox {
  FloatLanes from_min, from_max, to_min, to_max;

  LaneMovingBox() = default;
  // The same in another form.
  LaneMovingBox(const MovingBox& box)  // NOLINT(google-explicit-constructor)
      : from_min(laneCorner(box.from.min)),
        from_max(laneCorner(box.from.max)),
        to_min(laneCorner(box.to.min)),
        to_max(laneCorner(box.to.max)) {}
};

inline LaneMovingBox boxLanes(const MovingTriangle& t, float growth_m) {
  return inflated(boxOf(t), growth_m);
}

// Returns whether two moving boxes may intersect, as for MovingBox.
inline bool intersects(const LaneMovingBox& a, const LaneMovingBox& b) {
  const IntLanes below = (a.from_max < b.from_min) & (a.to_max < b.to_min);
  const IntLanes above = (b.from_max < a.from_min) & (b.to_max < a.to_min);
  return laneBits(below | above) == 0;
}

// The positions in a sorted cluster that belong to one group of bodies.
struct GroupRange {
  std::uint32_t group, begin, end;
};

// Tells which of a triangle's clusters are lower than the one that is swept: its number if there is
// one, or one of the two constants below. For most pairs these two numbers tell, without a branch,
// whether a lower cluster reports the pair.
using LowerClusters = std::uint32_t;
constexpr LowerClusters kNoLower = ~LowerClusters{0};
constexpr LowerClusters kSeveralLower = kNoLower - 1;

// The entries of one cluster, sorted by body group, and within a group by where their intervals
// begin.
template <class Primitive>
struct SortedCluster {
  ClusterIndex cluster;
  std::vector<GroupRange> groups;  // ascending
  // All arrays are per position. Intervals along the first axis; `lo`, like the packed ones, is
  // kScanChunk longer, so that the last chunk of a scan may read on:
  std::vector<float> lo, hi;
  // Intervals along the other two axes, as in PackedBox; of moving triangles those at the begin of
  // the time interval, then those at its end.
  std::vector<std::uint32_t> packed_lo[kStates<Primitive>], packed_hi[kStates<Primitive>];
  // Boxes in the scene frame [m], grown by the body's margin or motion bound.
  std::vector<std::conditional_t<kIsMoving<Primitive>, LaneMovingBox, LaneBox>> boxes;
  std::vector<PreparedTriangle<Primitive>> triangles;
  std::vector<const std::uint32_t*> clusters;  // the triangle's clusters, ascending
  std::vector<LowerClusters> lower;            // which of them are below this one
  std::vector<std::uint32_t> parts;            // WorkingSet::part, if parts matter

  PackedColumns packed(int state) const {
    return {packed_lo[state].data(), packed_hi[state].data()};
  }
};

// Working memory of a sorter. There is one per thread, kept from cycle to cycle.
template <class Primitive>
struct SortBuffers {
  // Data of an entry that is computed before its position in the order is known.
  struct Projected {
    std::uint32_t group;
    Vec3f scaled[kPoints<Primitive>];
    Interval interval;                       // along the first axis, of all states
    Interval across[kStates<Primitive>][2];  // along the other two
  };

  std::vector<Projected> projected;  // per entry
  // Sort keys: where the entry's interval begins in the upper half, the entry's number in the lower
  // half.
  std::vector<std::uint64_t> order, scratch;
};

// Sorts clusters. There is one per thread and cycle.
template <class Primitive>
class ClusterSorter {
 public:
  ClusterSorter(const CycleInput<Primitive>& input, SortBuffers<Primitive>& buffers)
      : input_(input),
        pace_(input.limit, kPollPeriod),
        projected_(buffers.projected),
        order_(buffers.order),
        scratch_(buffers.scratch) {}

  // Fills in `sorted`. Returns false if the limit is over; then `sorted` is unspecified.
  bool sort(ClusterIndex cluster, SortedCluster<Primitive>& sorted);

 private:
  using Projected = typename SortBuffers<Primitive>::Projected;

  void project(const ClusterEntry<Primitive>* entries);
  void order();
  void layOut(ClusterIndex cluster, const ClusterEntry<Primitive>* entries,
              SortedCluster<Primitive>& sorted);

  static constexpr std::uint64_t kPollPeriod = 1 << 12;  // entries between two checks of the limit

  const CycleInput<Primitive>& input_;
  PacedLimit pace_;
  std::vector<Projected>& projected_;
  std::vector<std::uint64_t>&order_, &scratch_;
  bool one_group_ = true;
  Quantiser quantiser_[2];  // of the second and third axis
};

}  // namespace deformable_contact_monitor
