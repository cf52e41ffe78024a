#include "core/cpu/assign.h"

#include <algorithm>

#include "core/rules/margins.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kBlock = 2048;
constexpr std::size_t kPollPeriod = 64;  // triangles or vertices between two checks of the limit
constexpr std::uint32_t kUnused = ~std::uint32_t{0};

// Returns the place of the k-th point of a primitive with these corners in an array of vertex
// states.
template <class Primitive>
std::size_t place(const std::uint32_t corner[3], std::size_t k) {
  return kStates<Primitive> * std::size_t{corner[k % 3]} + k / 3;
}

}  // namespace

template <class Primitive>
std::vector<float> scaledSlacks(const Scene& scene, const Options& options,
                                const SceneScale& scale) {
  std::vector<float> slack;
  for (const Body& body : scene.bodies())
    slack.push_back(scaledSlack(growthOf<Primitive>(body, options), scale));
  return slack;
}

// Notes which vertices regular triangles use. Several threads may store the same body for the same
// vertex, hence the atomics.
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

// Finds the nearest prototype of each vertex that a regular triangle uses, in each state.
template <class Primitive>
void ClusterAssigner::findNearest(const WorkingSet& set, const SizeSplit& split,
                                  const PrototypesView& view, const std::vector<float>& slack,
                                  const CycleLimit& limit, std::vector<NearestPrototype>& nearest) {
  markUsers(set, split, limit);
  scaled_.resize(kStates<Primitive> * set.vertices.size());
  nearest.resize(kStates<Primitive> * set.vertices.size());
  const auto findBlock = [&](std::size_t, std::size_t begin, std::size_t end) {
    PacedLimit pace(limit, kPollPeriod);
    for (std::size_t i = begin; i < end && !pace.over(); ++i) {
      const std::uint32_t user = user_[i].load(std::memory_order_relaxed);
      if (user == kUnused) continue;
      const auto find = [&](const SceneScale& scale, const Vec3f& vertex, std::size_t at) {
        scaled_[at] = scale.apply(vertex);
        // The nearest prototype of the last cycle is the best guess for this one.
        const std::uint32_t start = nearest[at].cluster < view.count ? nearest[at].cluster : 0;
        nearest[at] = nearestPrototype(view, scaled_[at], start, slack[user]);
      };
      if constexpr (kIsMoving<Primitive>) {
        find(split.scale, set.earlier[i], 2 * i);
        find(split.scale_after, set.vertices[i], 2 * i + 1);
      } else {
        find(split.scale, set.vertices[i], i);
      }
    }
  };
  parallelBlocks(limit, set.vertices.size(), kBlock, findBlock);
}

// Fills in block.length and block.lists for the regular triangles [begin, end). Most triangles lie
// inside one Voronoi cell and are done without the rule.
template <class Primitive>
void ClusterAssigner::assignBlock(const WorkingSet& set, const SizeSplit& split,
                                  const PrototypesView& view, float overlap,
                                  const std::vector<float>& slack,
                                  const std::vector<NearestPrototype>& nearest_of,
                                  std::size_t begin, std::size_t end, const CycleLimit& limit,
                                  Block& block) const {
  block.length.clear();
  block.lists.clear();
  PacedLimit pace(limit, kPollPeriod);
  for (std::size_t i = begin; i < end && !pace.over(); ++i) {
    const TriangleIndex t = split.regular[i];
    const std::uint32_t* corner = set.cornersOf(t);
    NearestPrototype nearest[kPoints<Primitive>];
    for (std::size_t k = 0; k < kPoints<Primitive>; ++k)
      nearest[k] = nearest_of[place<Primitive>(corner, k)];
    if (isInterior<kPoints<Primitive>>(nearest)) {
      block.length.push_back(1);
      block.lists.push_back(nearest[0].cluster);
      continue;
    }
    Vec3f v[kPoints<Primitive>];
    for (std::size_t k = 0; k < kPoints<Primitive>; ++k)
      v[k] = scaled_[place<Primitive>(corner, k)];
    std::uint32_t first;
    const auto rule =
        ruleFor<kPoints<Primitive>>(view, v, nearest, overlap, slack[set.bodyOf(t).value], first);
    const std::size_t before = block.lists.size();
    forEachAdmitted(view, rule, first, [&](std::uint32_t g) { block.lists.push_back(g); });
    std::sort(block.lists.begin() + static_cast<std::ptrdiff_t>(before), block.lists.end());
    block.length.push_back(static_cast<std::uint32_t>(block.lists.size() - before));
  }
}

// Finds nearest prototypes, lists the clusters of each block of triangles, and gathers the entries.
template <class Primitive>
void ClusterAssigner::assign(const Scene& scene, const WorkingSet& set, const SizeSplit& split,
                             const Prototypes& prototypes, const Options& options,
                             std::vector<NearestPrototype>& nearest,
                             ClusterAssignment<Primitive>& assignment, const CycleLimit& limit) {
  const PrototypesView view = prototypes.view();
  const std::vector<float> slack = scaledSlacks<Primitive>(scene, options, split.scale);
  findNearest<Primitive>(set, split, view, slack, limit, nearest);

  const std::size_t count = split.regular.size();
  blocks_.resize(blockCount(count, kBlock));
  parallelBlocks(limit, count, kBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
    Block& block = blocks_[b];
    assignBlock<Primitive>(set, split, view, options.overlap, slack, nearest, begin, end, limit,
                           block);
    block.entries.assign(prototypes.size(), 0);
    for (const std::uint32_t g : block.lists) ++block.entries[g];
  });
  if (!limit.wasOver()) collectEntries(set, split, prototypes.size(), limit, assignment);
}

// Computes where each cluster's entries begin, and where each block's entries of that cluster
// begin. Returns false if the limit is over.
bool ClusterAssigner::countEntries(std::size_t cluster_count, const CycleLimit& limit,
                                   std::vector<std::uint32_t>& entry_begin) {
  entry_begin.resize(cluster_count + 1);
  std::uint32_t total = 0;
  PacedLimit pace(limit, 1 << 16);
  for (std::size_t g = 0; g < cluster_count && !pace.over(blocks_.size()); ++g) {
    entry_begin[g] = total;
    for (Block& block : blocks_) {
      const std::uint32_t count = block.entries[g];
      block.entries[g] = total;
      total += count;
    }
  }
  entry_begin[cluster_count] = total;
  return !limit.over();
}

// Sorts the (cluster, triangle) pairs by cluster, with a counting sort.
template <class Primitive>
void ClusterAssigner::collectEntries(const WorkingSet& set, const SizeSplit& split,
                                     std::size_t cluster_count, const CycleLimit& limit,
                                     ClusterAssignment<Primitive>& assignment) {
  if (!countEntries(cluster_count, limit, assignment.entry_begin)) return;
  const std::uint32_t total = assignment.entry_begin[cluster_count];
  resizeWithin(limit, total, assignment.entries);
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
      const ClusterEntry<Primitive> entry{
          set.posed<Primitive>(t), set.vertexIds(t), t, set.bodyOf(t), list, size};
      for (std::uint32_t k = 0; k < size; ++k) {
        assignment.entries[block.entries[assignment.lists[list + k]]++] = entry;
      }
      list += size;
    }
  };
  parallelBlocks(limit, split.regular.size(), kBlock, collectBlock);
}

template std::vector<float> scaledSlacks<Triangle>(const Scene&, const Options&, const SceneScale&);
template std::vector<float> scaledSlacks<MovingTriangle>(const Scene&, const Options&,
                                                         const SceneScale&);
template void ClusterAssigner::assign<Triangle>(const Scene&, const WorkingSet&, const SizeSplit&,
                                                const Prototypes&, const Options&,
                                                std::vector<NearestPrototype>&,
                                                ClusterAssignment<Triangle>&, const CycleLimit&);
template void ClusterAssigner::assign<MovingTriangle>(
    const Scene&, const WorkingSet&, const SizeSplit&, const Prototypes&, const Options&,
    std::vector<NearestPrototype>&, ClusterAssignment<MovingTriangle>&, const CycleLimit&);

}  // namespace deformable_contact_monitor
