#include "core/cpu/assign.h"

#include <algorithm>

#include "core/parallel.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kBlock = 4096;
constexpr std::uint32_t kUnused = ~std::uint32_t{0};

}  // namespace

std::vector<float> scaledSlack(const Scene& scene, const SceneScale& scale) {
  std::vector<float> slack;
  for (const Body& body : scene.bodies()) slack.push_back(scaledSlack(body.margin_m, scale));
  return slack;
}

void ClusterAssigner::findWinners(const WorkingSet& set, const SizeSplit& split,
                                  const PrototypesView& view, const std::vector<float>& slack) {
  owner_.assign(set.vertices.size(), kUnused);
  for (const std::uint32_t t : split.regular) {
    for (int k = 0; k < 3; ++k) owner_[set.corners[3 * std::size_t{t} + k]] = set.body[t];
  }
  scaled_.resize(set.vertices.size());
  winners_.resize(set.vertices.size());
  parallelBlocks(set.vertices.size(), kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (owner_[i] == kUnused) continue;
      scaled_[i] = split.scale.apply(set.vertices[i]);
      // Last cycle's winner is the best guess, where there was one.
      const std::uint32_t start = winners_[i].cluster < view.count ? winners_[i].cluster : 0;
      winners_[i] = nearestPrototype(view, scaled_[i], start, slack[owner_[i]]);
    }
  });
}

void ClusterAssigner::assign(const Scene& scene, const WorkingSet& set, const SizeSplit& split,
                             const Prototypes& prototypes, float overlap,
                             ClusterAssignment& assignment) {
  const PrototypesView view = prototypes.view();
  const std::vector<float> slack = scaledSlack(scene, split.scale);
  findWinners(set, split, view, slack);

  blocks_.resize(blockCount(split.regular.size(), kBlock));
  const auto assignBlock = [&](std::size_t b, std::size_t begin, std::size_t end) {
    Block& block = blocks_[b];
    block.length.clear();
    block.lists.clear();
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t t = split.regular[i];
      const std::uint32_t* corner = &set.corners[3 * std::size_t{t}];
      const Winner w[3] = {winners_[corner[0]], winners_[corner[1]], winners_[corner[2]]};
      const bool inside = w[0].cluster == w[1].cluster && w[0].cluster == w[2].cluster;
      if (inside && !w[0].tied && !w[1].tied && !w[2].tied) {  // in the interior of one cell
        block.length.push_back(1);
        block.lists.push_back(w[0].cluster);
        continue;
      }
      const Vec3f v[3] = {scaled_[corner[0]], scaled_[corner[1]], scaled_[corner[2]]};
      std::uint32_t first;
      const HalfSpaceRule rule = ruleFor(view, v, w, overlap, slack[set.body[t]], first);
      const std::size_t before = block.lists.size();
      forEachAdmitted(view, rule, first, [&](std::uint32_t g) { block.lists.push_back(g); });
      std::sort(block.lists.begin() + static_cast<std::ptrdiff_t>(before), block.lists.end());
      block.length.push_back(static_cast<std::uint32_t>(block.lists.size() - before));
    }
    block.members.assign(prototypes.size(), 0);
    for (const std::uint32_t g : block.lists) ++block.members[g];
  };
  parallelBlocks(split.regular.size(), kBlock, assignBlock);
  collectMembers(set, split, prototypes.size(), assignment);
}

// A counting sort of the (cluster, triangle) pairs by cluster.
void ClusterAssigner::collectMembers(const WorkingSet& set, const SizeSplit& split,
                                     std::size_t cluster_count, ClusterAssignment& assignment) {
  assignment.member_begin.resize(cluster_count + 1);
  std::uint32_t total = 0;
  for (std::size_t g = 0; g < cluster_count; ++g) {
    assignment.member_begin[g] = total;
    for (Block& block : blocks_) {
      const std::uint32_t count = block.members[g];
      block.members[g] = total;
      total += count;
    }
  }
  assignment.member_begin[cluster_count] = total;
  assignment.members.resize(total);
  assignment.lists.resize(total);
  std::vector<std::uint32_t> list_begin(blocks_.size(), 0);
  for (std::size_t b = 1; b < blocks_.size(); ++b) {
    list_begin[b] = list_begin[b - 1] + static_cast<std::uint32_t>(blocks_[b - 1].lists.size());
  }
  const auto collectBlock = [&](std::size_t b, std::size_t begin, std::size_t end) {
    Block& block = blocks_[b];
    std::copy(block.lists.begin(), block.lists.end(), assignment.lists.begin() + list_begin[b]);
    std::uint32_t list = list_begin[b];
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t t = split.regular[i], size = block.length[i - begin];
      const std::uint32_t* corner = &set.corners[3 * std::size_t{t}];
      const ClusterMember member{
          set.posed(t),
          {set.vertex_id[corner[0]], set.vertex_id[corner[1]], set.vertex_id[corner[2]]},
          t,
          set.body[t],
          list,
          size};
      for (std::uint32_t k = 0; k < size; ++k) {
        assignment.members[block.members[assignment.lists[list + k]]++] = member;
      }
      list += size;
    }
  };
  parallelBlocks(split.regular.size(), kBlock, collectBlock);
}

}  // namespace deformable_contact_monitor
