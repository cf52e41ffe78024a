#include "core/cpu/large.h"

#include <algorithm>
#include <chrono>

#include "core/parallel.h"

namespace deformable_contact_monitor {
namespace {

// Boxes of the triangles that are at home in each cluster.
std::vector<Aabb> homeBoxes(const SweepInput& input) {
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

Contender contender(const WorkingSet& set, std::uint32_t t) {
  const std::uint32_t* corner = &set.corners[3 * std::size_t{t}];
  const std::uint32_t id[3] = {set.vertex_id[corner[0]], set.vertex_id[corner[1]],
                               set.vertex_id[corner[2]]};
  return {set.posed(t), id, t, set.body[t]};
}

// One large triangle against others: boxes, then the verdict.
class LargeTriangle {
 public:
  LargeTriangle(const SweepInput& input, std::uint32_t t, SweepOutput& output)
      : input_(input),
        triangle_(contender(input.set, t)),
        box_(input.set.boxes[t]),
        output_(output),
        judge_(input, output) {}

  void meet(std::uint32_t other) {
    ++output_.interval_overlaps;
    const WorkingSet& set = input_.set;
    const std::vector<std::uint32_t>& group = input_.groups.group;
    if (overlap(box_, set.boxes[other]) &&
        input_.groups.enabled[group[set.body[triangle_.triangle]]][group[set.body[other]]]) {
      judge_.judge(triangle_, contender(set, other));
    }
  }

 private:
  const SweepInput& input_;
  Contender triangle_;
  Aabb box_;
  SweepOutput& output_;
  CandidateJudge judge_;
};

}  // namespace

void sweepLargeTriangles(const SweepInput& input, SweepOutput& output) {
  if (input.split.large.empty()) return;
  const ClusterAssignment& assignment = input.assignment;
  const std::vector<Aabb> cluster_boxes = homeBoxes(input);
  std::vector<std::uint32_t> large = input.split.large;
  const std::vector<Aabb>& boxes = input.set.boxes;
  std::sort(large.begin(), large.end(), [&boxes](std::uint32_t a, std::uint32_t b) {
    return boxes[a].min.x != boxes[b].min.x ? boxes[a].min.x < boxes[b].min.x : a < b;
  });
  constexpr std::size_t kBlock = 16;
  std::vector<SweepOutput> outputs(blockCount(large.size(), kBlock));
  parallelBlocks(large.size(), kBlock, [&](std::size_t block, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      LargeTriangle triangle(input, large[i], outputs[block]);
      const Aabb& box = boxes[large[i]];
      for (std::size_t j = i + 1; j < large.size() && boxes[large[j]].min.x <= box.max.x; ++j) {
        triangle.meet(large[j]);
      }
      for (std::uint32_t g = 0; g < cluster_boxes.size(); ++g) {
        if (!overlap(box, cluster_boxes[g])) continue;
        for (std::uint32_t m = assignment.member_begin[g]; m < assignment.member_begin[g + 1];
             ++m) {
          const ClusterMember& member = assignment.members[m];
          if (assignment.isHome(member, g)) triangle.meet(member.triangle);
        }
      }
    }
  });
  for (const SweepOutput& part : outputs) output.add(part);
}

}  // namespace deformable_contact_monitor
