// Stage `oversized`: finds the pairs that an oversized triangle is part of.
//
// There are few of them, so that simple loops are enough: each one is tested against the box of
// each cluster, and, where they meet, against the entries of that cluster; and against the other
// oversized ones by a sweep along x.
#include <algorithm>

#include "core/common/parallel.h"
#include "core/common/stopwatch.h"
#include "core/cpu/filter.h"
#include "core/cpu/pair_stages.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint64_t kPollPeriod = 1 << 14;    // boxes between two checks of the limit
constexpr std::size_t kMostCandidates = 1 << 14;  // bounds the memory of dense scenes

// Returns the box of each cluster's triangles. A triangle counts in its lowest cluster only.
template <class Primitive>
std::vector<Aabb> homeBoxes(const CycleInput<Primitive>& input) {
  const ClusterAssignment<Primitive>& assignment = input.assignment;
  std::vector<Aabb> boxes(assignment.clusterCount());
  PacedLimit pace(input.limit, kPollPeriod);
  for (std::uint32_t g = 0; g < boxes.size(); ++g) {
    for (std::uint32_t m = assignment.entry_begin[g]; m < assignment.entry_begin[g + 1]; ++m) {
      if (pace.over()) return boxes;
      const ClusterEntry<Primitive>& entry = assignment.entries[m];
      if (!assignment.isHome(entry, ClusterIndex(g))) continue;
      boxes[g].include(input.set.box(entry.triangle));
    }
  }
  return boxes;
}

// Returns the oversized triangles in the order in which their boxes begin along x.
std::vector<TriangleIndex> sortedAlongX(const WorkingSet& set, std::vector<TriangleIndex> oversized,
                                        const CycleLimit& limit) {
  const auto along_x = [&set](TriangleIndex a, TriangleIndex b) {
    const float x_a = set.box(a).min.x, x_b = set.box(b).min.x;
    return x_a != x_b ? x_a < x_b : a < b;
  };
  sortWithin(limit, oversized.size(), along_x, [&oversized](const auto& less) {
    std::sort(oversized.begin(), oversized.end(), less);
  });
  return oversized;
}

// Returns a triangle of the working set in the form that the filters take.
template <class Primitive>
PreparedTriangle<Primitive> prepared(const WorkingSet& set, TriangleIndex t) {
  return {set.posed<Primitive>(t), set.vertexIds(t), t, set.bodyOf(t)};
}

// Takes oversized triangles, one after the other, through boxes, filters and verdicts. There is one
// per thread.
template <class Primitive>
class OversizedSweeper {
 public:
  OversizedSweeper(const CycleInput<Primitive>& input, const std::vector<TriangleIndex>& oversized,
                   const std::vector<Aabb>& cluster_boxes, CycleOutput<Primitive>& output)
      : input_(input),
        oversized_(oversized),
        cluster_boxes_(cluster_boxes),
        pace_(input.limit, kPollPeriod),
        filter_(input, filter_buffers_),
        output_(output) {}

  // Tests the i-th triangle in the order along x.
  void sweep(std::size_t i) {
    const PreparedTriangle<Primitive> triangle = prepared<Primitive>(input_.set, oversized_[i]);
    meetOversized(triangle, i);
    meetEntries(triangle);
    decide();
  }

 private:
  // Decides the candidates so far.
  void decide() {
    output_.work.add(Stage::kOversized, watch_.lapMs());
    narrowPhase(input_, filtered_, output_);
    filtered_.clear();
    output_.work.add(Stage::kNarrowPhase, watch_.lapMs());
  }

  // Tests a triangle against the oversized ones that come later in the order along x.
  void meetOversized(const PreparedTriangle<Primitive>& triangle, std::size_t i) {
    const float end = input_.set.box(triangle.triangle).max.x;
    for (std::size_t j = i + 1; j < oversized_.size(); ++j) {
      if (input_.set.box(oversized_[j]).min.x > end || pace_.over()) break;
      meet(triangle, oversized_[j]);
    }
  }

  // Tests a triangle against the regular ones, cluster by cluster.
  void meetEntries(const PreparedTriangle<Primitive>& triangle) {
    const ClusterAssignment<Primitive>& assignment = input_.assignment;
    for (std::uint32_t g = 0; g < cluster_boxes_.size(); ++g) {
      if (pace_.over()) return;
      if (!intersects(input_.set.box(triangle.triangle), cluster_boxes_[g])) continue;
      for (std::uint32_t m = assignment.entry_begin[g]; m < assignment.entry_begin[g + 1]; ++m) {
        if (pace_.over()) return;
        const ClusterEntry<Primitive>& entry = assignment.entries[m];
        if (assignment.isHome(entry, ClusterIndex(g))) meet(triangle, entry.triangle);
      }
    }
  }

  // Tests a triangle against one other: boxes, groups of bodies, parts, then the filters.
  void meet(const PreparedTriangle<Primitive>& triangle, TriangleIndex other) {
    ++output_.counters.interval_overlaps;
    const WorkingSet& set = input_.set;
    const std::vector<std::uint32_t>& group = input_.groups.group;
    if (intersects(set.box(triangle.triangle), set.box(other)) &&
        input_.groups.enabled[group[triangle.body.value]][group[set.bodyOf(other).value]] &&
        set.partsEnabled(triangle.triangle, other)) {
      filter_.filter(triangle, prepared<Primitive>(set, other), filtered_.candidates);
      if (filtered_.candidates.size() >= kMostCandidates) decide();
    }
  }

  const CycleInput<Primitive>& input_;
  const std::vector<TriangleIndex>& oversized_;
  const std::vector<Aabb>& cluster_boxes_;
  PacedLimit pace_;
  FilterBuffers<Primitive> filter_buffers_;
  PairFilter<Primitive> filter_;
  FilteredPairs<Primitive> filtered_;
  Stopwatch watch_;
  CycleOutput<Primitive>& output_;
};

}  // namespace

// Divides the oversized triangles into blocks, which run on several threads.
template <class Primitive>
void sweepOversized(const CycleInput<Primitive>& input, CycleOutput<Primitive>& output) {
  if (input.split.oversized.empty()) return;
  const Stopwatch watch;
  const std::vector<Aabb> cluster_boxes = homeBoxes(input);
  const std::vector<TriangleIndex> oversized =
      sortedAlongX(input.set, input.split.oversized, input.limit);
  output.work.add(Stage::kOversized, watch.elapsedMs());
  constexpr std::size_t kBlock = 16;
  if (input.limit.wasOver()) return;
  std::vector<CycleOutput<Primitive>> outputs(blockCount(oversized.size(), kBlock),
                                              CycleOutput<Primitive>(input));
  const auto sweepBlock = [&](std::size_t block, std::size_t begin, std::size_t end) {
    OversizedSweeper<Primitive> sweeper(input, oversized, cluster_boxes, outputs[block]);
    for (std::size_t i = begin; i < end && !input.limit.over(); ++i) sweeper.sweep(i);
  };
  parallelBlocks(input.limit, oversized.size(), kBlock, sweepBlock);
  for (CycleOutput<Primitive>& part : outputs) output.take(part);
}

template void sweepOversized(const CycleInput<Triangle>&, CycleOutput<Triangle>&);
template void sweepOversized(const CycleInput<MovingTriangle>&, CycleOutput<MovingTriangle>&);

}  // namespace deformable_contact_monitor
