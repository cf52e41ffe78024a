#include "core/cpu/large.h"

#include <algorithm>

#include "core/cpu/judge.h"
#include "core/cpu/screen.h"
#include "core/parallel.h"
#include "core/stopwatch.h"

namespace deformable_contact_monitor {
namespace {

// Boxes of the triangles that are at home in each cluster.
std::vector<Aabb> homeBoxes(const CycleInput& input) {
  const ClusterAssignment& assignment = input.assignment;
  std::vector<Aabb> boxes(assignment.clusterCount());
  for (std::uint32_t g = 0; g < boxes.size(); ++g) {
    for (std::uint32_t m = assignment.member_begin[g]; m < assignment.member_begin[g + 1]; ++m) {
      const ClusterMember& member = assignment.members[m];
      if (assignment.isHome(member, g)) boxes[g].include(input.set.boxes[member.triangle]);
    }
  }
  return boxes;
}

// The large triangles by where their boxes begin along x.
std::vector<std::uint32_t> sortedAlongX(const CycleInput& input) {
  std::vector<std::uint32_t> large = input.split.large;
  const std::vector<Aabb>& boxes = input.set.boxes;
  std::sort(large.begin(), large.end(), [&boxes](std::uint32_t a, std::uint32_t b) {
    return boxes[a].min.x != boxes[b].min.x ? boxes[a].min.x < boxes[b].min.x : a < b;
  });
  return large;
}

PreparedTriangle prepared(const WorkingSet& set, std::uint32_t t) {
  return {set.posed(t), set.vertexIds(t), t, set.body[t]};
}

// Takes large triangles, one after the other, through boxes, filters and verdicts. One per thread.
class LargeSweeper {
 public:
  LargeSweeper(const CycleInput& input, const std::vector<std::uint32_t>& large,
               const std::vector<Aabb>& cluster_boxes, CycleOutput& output)
      : input_(input),
        large_(large),
        cluster_boxes_(cluster_boxes),
        screen_(input),
        output_(output) {}

  // The i-th in the order along x.
  void sweep(std::size_t i) {
    const PreparedTriangle triangle = prepared(input_.set, large_[i]);
    candidates_.clear();
    meetLarge(triangle, i);
    meetMembers(triangle);
    output_.work.add(Stage::kLarge, watch_.lapMs());
    judgeCandidates(input_, candidates_, output_);
    output_.work.add(Stage::kJudge, watch_.lapMs());
  }

 private:
  void meetLarge(const PreparedTriangle& triangle, std::size_t i) {
    const std::vector<Aabb>& boxes = input_.set.boxes;
    const float end = boxes[triangle.triangle].max.x;
    for (std::size_t j = i + 1; j < large_.size() && boxes[large_[j]].min.x <= end; ++j) {
      meet(triangle, large_[j]);
    }
  }

  void meetMembers(const PreparedTriangle& triangle) {
    const ClusterAssignment& assignment = input_.assignment;
    for (std::uint32_t g = 0; g < cluster_boxes_.size(); ++g) {
      if (!intersects(input_.set.boxes[triangle.triangle], cluster_boxes_[g])) continue;
      for (std::uint32_t m = assignment.member_begin[g]; m < assignment.member_begin[g + 1]; ++m) {
        const ClusterMember& member = assignment.members[m];
        if (assignment.isHome(member, g)) meet(triangle, member.triangle);
      }
    }
  }

  void meet(const PreparedTriangle& triangle, std::uint32_t other) {
    ++output_.interval_overlaps;
    const WorkingSet& set = input_.set;
    const std::vector<std::uint32_t>& group = input_.groups.group;
    if (intersects(set.boxes[triangle.triangle], set.boxes[other]) &&
        input_.groups.enabled[group[triangle.body]][group[set.body[other]]]) {
      screen_.screen(triangle, prepared(set, other), candidates_);
    }
  }

  const CycleInput& input_;
  const std::vector<std::uint32_t>& large_;
  const std::vector<Aabb>& cluster_boxes_;
  PairScreen screen_;
  std::vector<Candidate> candidates_;
  Stopwatch watch_;
  CycleOutput& output_;
};

}  // namespace

void sweepLargeTriangles(const CycleInput& input, CycleOutput& output) {
  if (input.split.large.empty()) return;
  const Stopwatch watch;
  const std::vector<Aabb> cluster_boxes = homeBoxes(input);
  const std::vector<std::uint32_t> large = sortedAlongX(input);
  output.work.add(Stage::kLarge, watch.elapsedMs());
  constexpr std::size_t kBlock = 16;
  std::vector<CycleOutput> outputs(blockCount(large.size(), kBlock));
  parallelBlocks(large.size(), kBlock, [&](std::size_t block, std::size_t begin, std::size_t end) {
    LargeSweeper sweeper(input, large, cluster_boxes, outputs[block]);
    for (std::size_t i = begin; i < end; ++i) sweeper.sweep(i);
  });
  for (const CycleOutput& part : outputs) output.add(part);
}

}  // namespace deformable_contact_monitor
