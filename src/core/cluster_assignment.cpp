#include "core/cluster_assignment.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kBlock = 4096;
constexpr std::uint32_t kUnused = ~std::uint32_t{0};

// Lists of one block of triangles, to be joined in order.
struct Lists {
  std::vector<std::uint32_t> length, clusters;
};

Vec3f shrunk(const Vec3f& centroid, const Vec3f& v, float overlap) {
  return centroid + (v - centroid) * overlap;
}

// Counting sort of (cluster, triangle) by cluster; stable, so members ascend.
void collectMembers(std::size_t cluster_count, ClusterAssignment& a) {
  a.member_begin.assign(cluster_count + 1, 0);
  for (const std::uint32_t g : a.clusters) ++a.member_begin[g + 1];
  for (std::size_t g = 0; g < cluster_count; ++g) a.member_begin[g + 1] += a.member_begin[g];
  std::vector<std::uint32_t> next(a.member_begin.begin(), a.member_begin.end() - 1);
  a.members.resize(a.clusters.size());
  for (std::uint32_t i = 0; i + 1 < a.list_begin.size(); ++i) {
    for (std::uint32_t k = a.list_begin[i]; k < a.list_begin[i + 1]; ++k) {
      a.members[next[a.clusters[k]]++] = i;
    }
  }
}

}  // namespace

std::vector<float> scaledSlack(const Scene& scene, const SceneScale& scale) {
  std::vector<float> slack(scene.bodyCount(), 0.0F);
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    const double margin = scene.body(id).margin_m * scale.scale;
    if (margin > 0) slack[id] = std::nextafter(static_cast<float>(2 * margin), INFINITY);
  }
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

  std::vector<Lists> blocks(blockCount(split.regular.size(), kBlock));
  parallelBlocks(
      split.regular.size(), kBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
        Lists& lists = blocks[b];
        lists.length.reserve(end - begin);
        lists.clusters.reserve(2 * (end - begin));
        for (std::size_t i = begin; i < end; ++i) {
          const std::uint32_t t = split.regular[i];
          const std::uint32_t* corner = &set.corners[3 * std::size_t{t}];
          const Winner w[3] = {winners_[corner[0]], winners_[corner[1]], winners_[corner[2]]};
          const bool inside = w[0].cluster == w[1].cluster && w[0].cluster == w[2].cluster;
          if (inside && !w[0].tied && !w[1].tied && !w[2].tied) {  // in the interior of one cell
            lists.length.push_back(1);
            lists.clusters.push_back(w[0].cluster);
            continue;
          }
          HalfSpaceRule rule;
          for (int k = 0; k < 3; ++k) rule.v[k] = scaled_[corner[k]];
          const float body_slack = slack[set.body[t]];
          std::uint32_t first = w[0].cluster;
          if (overlap < 1) {
            const Vec3f centroid = (rule.v[0] + rule.v[1] + rule.v[2]) * (1.0F / 3);
            for (Vec3f& v : rule.v) v = shrunk(centroid, v, overlap);
            first = nearestPrototype(view, centroid, first, body_slack).cluster;
            rule.addCompetitor(view.prototypes[first], body_slack);
          }
          for (const Winner& winner : w) {
            rule.addCompetitor(view.prototypes[winner.cluster], body_slack);
          }
          const std::size_t before = lists.clusters.size();
          forEachAdmitted(view, rule, first, [&](std::uint32_t g) { lists.clusters.push_back(g); });
          std::sort(lists.clusters.begin() + static_cast<std::ptrdiff_t>(before),
                    lists.clusters.end());
          lists.length.push_back(static_cast<std::uint32_t>(lists.clusters.size() - before));
        }
      });

  assignment.list_begin.assign(1, 0);
  assignment.clusters.clear();
  for (const Lists& lists : blocks) {
    for (const std::uint32_t length : lists.length) {
      assignment.list_begin.push_back(assignment.list_begin.back() + length);
    }
    assignment.clusters.insert(assignment.clusters.end(), lists.clusters.begin(),
                               lists.clusters.end());
  }
  collectMembers(prototypes.size(), assignment);
}

}  // namespace deformable_contact_monitor
