#include "global_radius.h"

#include <algorithm>
#include <cmath>

namespace deformable_contact_monitor {
namespace {

struct Centroids {
  std::vector<Vec3f> scaled;  // per regular triangle
  double radius = 0;          // of the largest of them, and some for rounding
};

Centroids centroidsOf(const WorkingSet& set, const SizeSplit& split) {
  Centroids out;
  float most2 = 0;
  for (const TriangleIndex t : split.regular) {
    Vec3f v[3];
    for (int k = 0; k < 3; ++k) v[k] = split.scale.apply(set.posed(t).v[k]);
    out.scaled.push_back(centroidOf(v));
    for (const Vec3f& x : v) most2 = std::max(most2, squaredDistance(x, out.scaled.back()));
  }
  out.radius = std::sqrt(double{most2}) + 1e-6;
  return out;
}

// The prototypes that may matter for a point whose nearest one is `nearest`, that one first.
void findNear(const PrototypesView& view, std::uint32_t nearest, double reach,
              std::vector<std::uint32_t>* near) {
  near->assign(1, nearest);
  if (view.list_reach[nearest] > reach) {
    walkList(
        view, nearest, [reach] { return reach; },
        [&](std::uint32_t place, const Vec3f&) {
          near->push_back(view.neighbour_cluster[view.listBegin(nearest) + place]);
        });
    return;
  }
  for (std::uint32_t g = 0; g < view.count; ++g) {
    if (g != nearest) near->push_back(g);
  }
}

double distance2(const Vec3f& a, const Vec3f& b) {
  const Vec3d d = toDouble(a) - toDouble(b);
  return dot(d, d);
}

}  // namespace

ClusterAssignment<Triangle> assignByGlobalRadius(const WorkingSet& set, const SizeSplit& split,
                                                 const Prototypes& prototypes) {
  const PrototypesView view = prototypes.view();
  const Centroids centroids = centroidsOf(set, split);
  const double radius = centroids.radius;
  ClusterAssignment<Triangle> assignment;
  std::vector<std::uint32_t> list_begin, near;
  std::vector<double> d2;
  std::uint32_t nearest = 0;
  for (const Vec3f& c : centroids.scaled) {
    list_begin.push_back(static_cast<std::uint32_t>(assignment.lists.size()));
    nearest = nearestPrototype(view, c, nearest, 0).cluster;
    // d_g <= d_a + 2 R because d_g^2 <= d_a^2 + 2 R |p_g - p_a| and |p_g - p_a| <= d_g + d_a.
    const double d_nearest = std::sqrt(distance2(c, view.prototypes[nearest]));
    findNear(view, nearest, 2 * (d_nearest + radius) * (1 + 1e-5), &near);
    d2.clear();
    for (const std::uint32_t g : near) d2.push_back(distance2(c, view.prototypes[g]));
    for (std::size_t g = 0; g < near.size(); ++g) {
      bool inside = true;
      for (std::size_t k = 0; k < near.size() && inside; ++k) {
        const double excess = d2[g] - d2[k];  // of a centroid on the far side of the border
        const double between2 = distance2(view.prototypes[near[g]], view.prototypes[near[k]]);
        inside = excess <= 0 || excess * excess <= 4 * radius * radius * between2;
      }
      if (inside) assignment.lists.push_back(near[g]);
    }
    std::sort(assignment.lists.begin() + list_begin.back(), assignment.lists.end());
  }
  list_begin.push_back(static_cast<std::uint32_t>(assignment.lists.size()));

  assignment.entry_begin.assign(prototypes.size() + 1, 0);
  for (const std::uint32_t g : assignment.lists) ++assignment.entry_begin[g + 1];
  for (std::size_t g = 0; g < prototypes.size(); ++g) {
    assignment.entry_begin[g + 1] += assignment.entry_begin[g];
  }
  assignment.entries.resize(assignment.lists.size());
  std::vector<std::uint32_t> next = assignment.entry_begin;
  for (std::size_t i = 0; i < split.regular.size(); ++i) {
    const TriangleIndex t = split.regular[i];
    const ClusterEntry<Triangle> entry{
        set.posed(t),  set.vertexIds(t), t,
        set.bodyOf(t), list_begin[i],    list_begin[i + 1] - list_begin[i]};
    for (std::uint32_t k = list_begin[i]; k < list_begin[i + 1]; ++k) {
      assignment.entries[next[assignment.lists[k]]++] = entry;
    }
  }
  return assignment;
}

}  // namespace deformable_contact_monitor
