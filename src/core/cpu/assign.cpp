#include "core/cpu/assign.h"

#include <algorithm>

#include "core/common/parallel.h"
#include "core/rules/margins.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kBlock = 2048;
constexpr std::size_t kLook = 64;  // triangles or vertices between looks at the limit
constexpr std::uint32_t kUnused = ~std::uint32_t{0};

// Where the k-th point of a hull with these corners is, in arrays of vertices' states.
template <class Hull>
std::size_t place(const std::uint32_t corner[3], std::size_t k) {
  return kStates<Hull> * std::size_t{corner[k % 3]} + k / 3;
}

}  // namespace

template <class Hull>
std::vector<float> scaledSlacks(const Scene& scene, const SceneScale& scale) {
  std::vector<float> slack;
  for (const Body& body : scene.bodies()) slack.push_back(scaledSlack(growthOf<Hull>(body), scale));
  return slack;
}

// Fills user_. Triangles of one body may name the same vertex at the same time.
void ClusterAssigner::markUsers(const WorkingSet& set, const SizeSplit& split,
                                const CycleLimit& limit) {
  const std::size_t count = set.vertices.size();
  if (user_.size() < count) user_ = std::vector<std::atomic<std::uint32_t>>(count + count / 8);
  parallelBlocks(limit, count, 4 * kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) user_[i].store(kUnused, std::memory_order_relaxed);
  });
  const auto markBlock = [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const TriangleIndex t = split.regular[i];
      for (int k = 0; k < 3; ++k) {
        user_[set.cornersOf(t)[k]].store(set.bodyOf(t).value, std::memory_order_relaxed);
      }
    }
  };
  parallelBlocks(limit, split.regular.size(), kBlock, markBlock);
}

template <class Hull>
void ClusterAssigner::findNearest(const WorkingSet& set, const SizeSplit& split,
                                  const PrototypesView& view, const std::vector<float>& slack,
                                  const CycleLimit& limit) {
  markUsers(set, split, limit);
  scaled_.resize(kStates<Hull> * set.vertices.size());
  nearest_.resize(kStates<Hull> * set.vertices.size());
  const auto findBlock = [&](std::size_t, std::size_t begin, std::size_t end) {
    PacedLimit pace(limit, kLook);
    for (std::size_t i = begin; i < end && !pace.over(); ++i) {
      const std::uint32_t user = user_[i].load(std::memory_order_relaxed);
      if (user == kUnused) continue;
      const auto find = [&](const SceneScale& scale, const Vec3f& vertex, std::size_t at) {
        scaled_[at] = scale.apply(vertex);
        // What was the nearest last cycle is the best guess, where there was one.
        const std::uint32_t start = nearest_[at].cluster < view.count ? nearest_[at].cluster : 0;
        nearest_[at] = nearestPrototype(view, scaled_[at], start, slack[user]);
      };
      if constexpr (kIsMoving<Hull>) {
        find(split.scale, set.earlier[i], 2 * i);
        find(split.scale_after, set.vertices[i], 2 * i + 1);
      } else {
        find(split.scale, set.vertices[i], i);
      }
    }
  };
  parallelBlocks(limit, set.vertices.size(), kBlock, findBlock);
}

// Fills block.length and block.lists for regular triangles [begin, end).
template <class Hull>
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
    NearestPrototype nearest[kPoints<Hull>];
    for (std::size_t k = 0; k < kPoints<Hull>; ++k) nearest[k] = nearest_[place<Hull>(corner, k)];
    if (isInterior<kPoints<Hull>>(nearest)) {
      block.length.push_back(1);
      block.lists.push_back(nearest[0].cluster);
      continue;
    }
    Vec3f v[kPoints<Hull>];
    for (std::size_t k = 0; k < kPoints<Hull>; ++k) v[k] = scaled_[place<Hull>(corner, k)];
    std::uint32_t first;
    const auto rule =
        ruleFor<kPoints<Hull>>(view, v, nearest, overlap, slack[set.bodyOf(t).value], first);
    const std::size_t before = block.lists.size();
    forEachAdmitted(view, rule, first, [&](std::uint32_t g) { block.lists.push_back(g); });
    std::sort(block.lists.begin() + static_cast<std::ptrdiff_t>(before), block.lists.end());
    block.length.push_back(static_cast<std::uint32_t>(block.lists.size() - before));
  }
}

template <class Hull>
void ClusterAssigner::assign(const Scene& scene, const WorkingSet& set, const SizeSplit& split,
                             const Prototypes& prototypes, float overlap,
                             ClusterAssignment<Hull>& assignment, const CycleLimit& limit) {
  const PrototypesView view = prototypes.view();
  const std::vector<float> slack = scaledSlacks<Hull>(scene, split.scale);
  findNearest<Hull>(set, split, view, slack, limit);

  const std::size_t count = split.regular.size();
  blocks_.resize(blockCount(count, kBlock));
  parallelBlocks(limit, count, kBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
    Block& block = blocks_[b];
    assignBlock<Hull>(set, split, view, overlap, slack, begin, end, limit, block);
    block.members.assign(prototypes.size(), 0);
    for (const std::uint32_t g : block.lists) ++block.members[g];
  });
  if (!limit.wasOver()) collectMembers(set, split, prototypes.size(), limit, assignment);
}

// Where each cluster's members begin, and each block's among them. False if the limit was over.
bool ClusterAssigner::countMembers(std::size_t cluster_count, const CycleLimit& limit,
                                   std::vector<std::uint32_t>& member_begin) {
  member_begin.resize(cluster_count + 1);
  std::uint32_t total = 0;
  PacedLimit pace(limit, 1 << 16);
  for (std::size_t g = 0; g < cluster_count && !pace.over(blocks_.size()); ++g) {
    member_begin[g] = total;
    for (Block& block : blocks_) {
      const std::uint32_t count = block.members[g];
      block.members[g] = total;
      total += count;
    }
  }
  member_begin[cluster_count] = total;
  return !limit.over();
}

// A counting sort of the (cluster, triangle) pairs by cluster.
template <class Hull>
void ClusterAssigner::collectMembers(const WorkingSet& set, const SizeSplit& split,
                                     std::size_t cluster_count, const CycleLimit& limit,
                                     ClusterAssignment<Hull>& assignment) {
  if (!countMembers(cluster_count, limit, assignment.member_begin)) return;
  const std::uint32_t total = assignment.member_begin[cluster_count];
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
      const ClusterMember<Hull> member{
          set.posed<Hull>(t), set.vertexIds(t), t, set.bodyOf(t), list, size};
      for (std::uint32_t k = 0; k < size; ++k) {
        assignment.members[block.members[assignment.lists[list + k]]++] = member;
      }
      list += size;
    }
  };
  parallelBlocks(limit, split.regular.size(), kBlock, collectBlock);
}

template std::vector<float> scaledSlacks<Triangle>(const Scene&, const SceneScale&);
template std::vector<float> scaledSlacks<MovingTriangle>(const Scene&, const SceneScale&);
template void ClusterAssigner::assign<Triangle>(const Scene&, const WorkingSet&, const SizeSplit&,
                                                const Prototypes&, float,
                                                ClusterAssignment<Triangle>&, const CycleLimit&);
template void ClusterAssigner::assign<MovingTriangle>(const Scene&, const WorkingSet&,
                                                      const SizeSplit&, const Prototypes&, float,
                                                      ClusterAssignment<MovingTriangle>&,
                                                      const CycleLimit&);

}  // namespace deformable_contact_monitor
