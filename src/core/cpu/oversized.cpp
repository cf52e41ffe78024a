#include "core/cpu/oversized.h"

#include <algorithm>

#include "core/common/parallel.h"
#include "core/common/stopwatch.h"
#include "core/cpu/narrow_phase.h"
#include "core/cpu/swept_filter.h"
#include "core/cpu/swept_narrow_phase.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint64_t kLook = 1 << 14;          // boxes between looks at the limit
constexpr std::size_t kMostCandidates = 1 << 14;  // bounds the memory of dense scenes

// Boxes of the triangles that are at home in each cluster.
template <class Hull>
std::vector<Aabb> homeBoxes(const CycleInput<Hull>& input) {
  const ClusterAssignment<Hull>& assignment = input.assignment;
  std::vector<Aabb> boxes(assignment.clusterCount());
  PacedLimit pace(input.limit, kLook);
  for (std::uint32_t g = 0; g < boxes.size(); ++g) {
    for (std::uint32_t m = assignment.member_begin[g]; m < assignment.member_begin[g + 1]; ++m) {
      if (pace.over()) return boxes;
      const ClusterMember<Hull>& member = assignment.members[m];
      if (!assignment.isHome(member, ClusterIndex(g))) continue;
      boxes[g].include(input.set.box(member.triangle));
    }
  }
  return boxes;
}

// The large triangles by where their boxes begin along x.
std::vector<TriangleIndex> sortedAlongX(const WorkingSet& set, std::vector<TriangleIndex> large,
                                        const CycleLimit& limit) {
  const auto along_x = [&set](TriangleIndex a, TriangleIndex b) {
    const float x_a = set.box(a).min.x, x_b = set.box(b).min.x;
    return x_a != x_b ? x_a < x_b : a < b;
  };
  sortWithin(limit, large.size(), along_x,
             [&large](const auto& less) { std::sort(large.begin(), large.end(), less); });
  return large;
}

template <class Hull>
PreparedTriangle<Hull> prepared(const WorkingSet& set, TriangleIndex t) {
  return {set.posed<Hull>(t), set.vertexIds(t), t, set.bodyOf(t)};
}

// Takes large triangles, one after the other, through boxes, filters and verdicts. One per thread.
template <class Hull>
class LargeSweeper {
 public:
  LargeSweeper(const CycleInput<Hull>& input, const std::vector<TriangleIndex>& large,
               const std::vector<Aabb>& cluster_boxes, CycleOutput<Hull>& output)
      : input_(input),
        large_(large),
        cluster_boxes_(cluster_boxes),
        pace_(input.limit, kLook),
        screen_(input, screen_buffers_),
        output_(output) {}

  // The i-th in the order along x.
  void sweep(std::size_t i) {
    const PreparedTriangle<Hull> triangle = prepared<Hull>(input_.set, large_[i]);
    meetLarge(triangle, i);
    meetMembers(triangle);
    judge();
  }

 private:
  void judge() {
    output_.work.add(Stage::kOversized, watch_.lapMs());
    judgeCandidates(input_, screened_, output_);
    screened_.clear();
    output_.work.add(Stage::kNarrowPhase, watch_.lapMs());
  }

  void meetLarge(const PreparedTriangle<Hull>& triangle, std::size_t i) {
    const float end = input_.set.box(triangle.triangle).max.x;
    for (std::size_t j = i + 1; j < large_.size(); ++j) {
      if (input_.set.box(large_[j]).min.x > end || pace_.over()) break;
      meet(triangle, large_[j]);
    }
  }

  void meetMembers(const PreparedTriangle<Hull>& triangle) {
    const ClusterAssignment<Hull>& assignment = input_.assignment;
    for (std::uint32_t g = 0; g < cluster_boxes_.size(); ++g) {
      if (pace_.over()) return;
      if (!intersects(input_.set.box(triangle.triangle), cluster_boxes_[g])) continue;
      for (std::uint32_t m = assignment.member_begin[g]; m < assignment.member_begin[g + 1]; ++m) {
        if (pace_.over()) return;
        const ClusterMember<Hull>& member = assignment.members[m];
        if (assignment.isHome(member, ClusterIndex(g))) meet(triangle, member.triangle);
      }
    }
  }

  void meet(const PreparedTriangle<Hull>& triangle, TriangleIndex other) {
    ++output_.interval_overlaps;
    const WorkingSet& set = input_.set;
    const std::vector<std::uint32_t>& group = input_.groups.group;
    if (intersects(set.box(triangle.triangle), set.box(other)) &&
        input_.groups.enabled[group[triangle.body.value]][group[set.bodyOf(other).value]]) {
      screen_.screen(triangle, prepared<Hull>(set, other), screened_.candidates);
      if (screened_.candidates.size() >= kMostCandidates) judge();
    }
  }

  const CycleInput<Hull>& input_;
  const std::vector<TriangleIndex>& large_;
  const std::vector<Aabb>& cluster_boxes_;
  PacedLimit pace_;
  ScreenBuffers<Hull> screen_buffers_;
  PairScreen<Hull> screen_;
  Screened<Hull> screened_;
  Stopwatch watch_;
  CycleOutput<Hull>& output_;
};

}  // namespace

template <class Hull>
void sweepLargeTriangles(const CycleInput<Hull>& input, CycleOutput<Hull>& output) {
  if (input.split.large.empty()) return;
  const Stopwatch watch;
  const std::vector<Aabb> cluster_boxes = homeBoxes(input);
  const std::vector<TriangleIndex> large = sortedAlongX(input.set, input.split.large, input.limit);
  output.work.add(Stage::kOversized, watch.elapsedMs());
  constexpr std::size_t kBlock = 16;
  if (input.limit.wasOver()) return;
  std::vector<CycleOutput<Hull>> outputs(blockCount(large.size(), kBlock),
                                         CycleOutput<Hull>(input));
  const auto sweepBlock = [&](std::size_t block, std::size_t begin, std::size_t end) {
    LargeSweeper<Hull> sweeper(input, large, cluster_boxes, outputs[block]);
    for (std::size_t i = begin; i < end && !input.limit.over(); ++i) sweeper.sweep(i);
  };
  parallelBlocks(input.limit, large.size(), kBlock, sweepBlock);
  for (CycleOutput<Hull>& part : outputs) output.take(part);
}

template void sweepLargeTriangles(const CycleInput<Triangle>&, CycleOutput<Triangle>&);
template void sweepLargeTriangles(const CycleInput<MovingTriangle>&, CycleOutput<MovingTriangle>&);

}  // namespace deformable_contact_monitor
