#include "core/cpu/assign.h"

#include <algorithm>

#include "core/parallel.h"
#include "core/rules/margins.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kBlock = 4096;
constexpr std::size_t kLook = 64;  // triangles or vertices between looks at the limit
constexpr std::uint32_t kUnused = ~std::uint32_t{0};

}  // namespace

std::vector<float> scaledSlacks(const Scene& scene, const SceneScale& scale) {
  std::vector<float> slack;
  for (const Body& body : scene.bodies()) slack.push_back(scaledSlack(body.margin_m, scale));
  return slack;
}

void ClusterAssigner::findNearest(const WorkingSet& set, const SizeSplit& split,
                                  const PrototypesView& view, const std::vector<float>& slack,
                                  const CycleLimit& limit) {
  user_.assign(set.vertices.size(), kUnused);
  serialBlocks(limit, split.regular.size(), 16 * kBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const TriangleIndex t = split.regular[i];
      for (int k = 0; k < 3; ++k) user_[set.cornersOf(t)[k]] = set.bodyOf(t).value;
    }
  });
  scaled_.resize(set.vertices.size());
  nearest_.resize(set.vertices.size());
  const auto findBlock = [&](std::size_t, std::size_t begin, std::size_t end) {
    PacedLimit pace(limit, kLook);
    for (std::size_t i = begin; i < end && !pace.over(); ++i) {
      if (user_[i] == kUnused) continue;
      scaled_[i] = split.scale.apply(set.vertices[i]);
      // What was the nearest last cycle is the best guess, where there was one.
      const std::uint32_t start = nearest_[i].cluster < view.count ? nearest_[i].cluster : 0;
      nearest_[i] = nearestPrototype(view, scaled_[i], start, slack[user_[i]]);
    }
  };
  parallelBlocks(limit, set.vertices.size(), kBlock, findBlock);
}

// Fills block.length and block.lists for regular triangles [begin, end).
void ClusterAssigner::assignBlock(const WorkingSet& set, const SizeSplit& split,
                                  const PrototypesView& view, float overlap,
                                  const std::vector<float>& slack, std::size_t begin,
                                  std::size_t end, const CycleLimit& limit, Block& block) const {
  block.length.clear();
  block.lists.clear();
  PacedLimit pace(limit, kLook);
  for (std::size_t i = begin; i < end && !pace.over(); ++i) {
    const TriangleIndex t = split.regular[i];
    const std::uint32_t* corner = set.cornersOf(t);
    const NearestPrototype nearest[3] = {nearest_[corner[0]], nearest_[corner[1]],
                                         nearest_[corner[2]]};
    if (isInterior(nearest)) {
      block.length.push_back(1);
      block.lists.push_back(nearest[0].cluster);
      continue;
    }
    const Vec3f v[3] = {scaled_[corner[0]], scaled_[corner[1]], scaled_[corner[2]]};
    std::uint32_t first;
    const HalfSpaceRule rule =
        ruleFor(view, v, nearest, overlap, slack[set.bodyOf(t).value], first);
    const std::size_t before = block.lists.size();
    forEachAdmitted(view, rule, first, [&](std::uint32_t g) { block.lists.push_back(g); });
    std::sort(block.lists.begin() + static_cast<std::ptrdiff_t>(before), block.lists.end());
    block.length.push_back(static_cast<std::uint32_t>(block.lists.size() - before));
  }
}

void ClusterAssigner::assign(const Scene& scene, const WorkingSet& set, const SizeSplit& split,
                             const Prototypes& prototypes, float overlap,
                             ClusterAssignment& assignment, const CycleLimit& limit) {
  const PrototypesView view = prototypes.view();
  const std::vector<float> slack = scaledSlacks(scene, split.scale);
  findNearest(set, split, view, slack, limit);

  const std::size_t count = split.regular.size();
  blocks_.resize(blockCount(count, kBlock));
  parallelBlocks(limit, count, kBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
    Block& block = blocks_[b];
    assignBlock(set, split, view, overlap, slack, begin, end, limit, block);
    block.members.assign(prototypes.size(), 0);
    for (const std::uint32_t g : block.lists) ++block.members[g];
  });
  if (!limit.wasOver()) collectMembers(set, split, prototypes.size(), limit, assignment);
}

// A counting sort of the (cluster, triangle) pairs by cluster.
void ClusterAssigner::collectMembers(const WorkingSet& set, const SizeSplit& split,
                                     std::size_t cluster_count, const CycleLimit& limit,
                                     ClusterAssignment& assignment) {
  assignment.member_begin.resize(cluster_count + 1);
  std::uint32_t total = 0;
  PacedLimit pace(limit, 1 << 16);
  for (std::size_t g = 0; g < cluster_count && !pace.over(blocks_.size()); ++g) {
    assignment.member_begin[g] = total;
    for (Block& block : blocks_) {
      const std::uint32_t count = block.members[g];
      block.members[g] = total;
      total += count;
    }
  }
  if (limit.over()) return;
  assignment.member_begin[cluster_count] = total;
  resizeWithin(limit, total, assignment.members);
  resizeWithin(limit, total, assignment.lists);
  if (limit.wasOver()) return;
  std::vector<std::uint32_t> list_begin(blocks_.size(), 0);
  for (std::size_t b = 1; b < blocks_.size(); ++b) {
    list_begin[b] = list_begin[b - 1] + static_cast<std::uint32_t>(blocks_[b - 1].lists.size());
  }
  const auto collectBlock = [&](std::size_t b, std::size_t begin, std::size_t end) {
    Block& block = blocks_[b];
    std::copy(block.lists.begin(), block.lists.end(), assignment.lists.begin() + list_begin[b]);
    std::uint32_t list = list_begin[b];
    PacedLimit pace(limit, 1 << 14);
    for (std::size_t i = begin; i < end && !pace.over(block.length[i - begin]); ++i) {
      const TriangleIndex t = split.regular[i];
      const std::uint32_t size = block.length[i - begin];
      const ClusterMember member{set.posed(t), set.vertexIds(t), t, set.bodyOf(t), list, size};
      for (std::uint32_t k = 0; k < size; ++k) {
        assignment.members[block.members[assignment.lists[list + k]]++] = member;
      }
      list += size;
    }
  };
  parallelBlocks(limit, split.regular.size(), kBlock, collectBlock);
}

}  // namespace deformable_contact_monitor
