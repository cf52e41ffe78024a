// Which clusters a triangle belongs to: the half-space rule.
//
// Theorem: give each prototype p_g its closed Voronoi cell. A triangle T is put into cluster g
// unless for some competitor k every point of T is strictly nearer to p_k than to p_g. Since
// |x - p_g|^2 - |x - p_k|^2 is affine in x, its three vertices decide. If two triangles meet in x,
// and x lies in the cell of g, then neither can have been kept out of g: they share a cluster. That
// holds for any prototypes and any choice of competitors; more competitors only make it tighter.
//
// Here distances are of scaled, rounded coordinates. With |v' - v| <= d, |v - p_g| <= |v - p_k|
// implies |v' - p_g| <= |v' - p_k| + 2 d; a margin m enters likewise, as d + m.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/host_device.h"
#include "core/scene_scale.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

DCM_HD inline float squaredDistance(const Vec3f& a, const Vec3f& b) {
  const Vec3f d = a - b;
  return d.x * d.x + d.y * d.y + d.z * d.z;
}

// The largest squared distance to p_g at which a vertex `v` at squared distance `d2` from a
// competitor may still be on the side of p_g. `slack` is twice the margin [scaled].
DCM_HD inline float reach2(const Vec3f& v, float d2, float slack) {
  const float error = (fabsf(v.x) + fabsf(v.y) + fabsf(v.z)) * (2 * kScaledError);
  const float reach = sqrtf(d2) + error + slack;
  constexpr float kRounding = 1 + 4e-6F;  // both squared distances, the root and this line
  return reach * reach * kRounding + 1e-37F;
}

// A triangle before the rule: its scaled vertices and, for each competitor, how far each vertex
// reaches.
struct HalfSpaceRule {
  static constexpr int kCompetitors = 4;
  Vec3f v[3];
  float reach2[kCompetitors][3];
  int competitors = 0;

  DCM_HD void addCompetitor(const Vec3f& prototype, float slack) {
    for (int i = 0; i < 3; ++i) {
      reach2[competitors][i] =
          deformable_contact_monitor::reach2(v[i], squaredDistance(v[i], prototype), slack);
    }
    ++competitors;
  }

  DCM_HD bool admits(const Vec3f& prototype) const {
    float d2[3];
    for (int i = 0; i < 3; ++i) d2[i] = squaredDistance(v[i], prototype);
    for (int k = 0; k < competitors; ++k) {
      // Written so that NaN admits.
      if (d2[0] > reach2[k][0] && d2[1] > reach2[k][1] && d2[2] > reach2[k][2]) return false;
    }
    return true;
  }

  // No admitted prototype is farther than this from the first competitor, `prototype`.
  DCM_HD float searchRadius(const Vec3f& prototype) const {
    float radius = 0;
    for (int i = 0; i < 3; ++i) {
      radius = most(radius, sqrtf(reach2[0][i]) + sqrtf(squaredDistance(v[i], prototype)));
    }
    return radius * (1 + 1e-5F);
  }
};

// One entry of a prototype's list of neighbours, nearest first.
struct Neighbour {
  Vec3f prototype;
  float distance = 0;  // between the two prototypes
  std::uint32_t cluster = 0;
};

// Prototypes and, for each, its nearest others. A list that does not reach far enough is no error:
// the search then goes over all prototypes.
struct PrototypesView {
  const Vec3f* prototypes;
  const Neighbour* neighbours;  // `neighbour_count` per prototype
  std::uint32_t count;
  std::uint32_t neighbour_count;
};

// The nearest prototype of a point, and whether another one is as near, for all that rounding can
// tell: then the point may lie in either cell.
struct Winner {
  std::uint32_t cluster = 0;
  bool tied = false;
};

DCM_HD inline Winner nearestPrototype(const PrototypesView& view, const Vec3f& v,
                                      std::uint32_t start, float slack) {
  std::uint32_t best = start;
  float best2 = squaredDistance(v, view.prototypes[start]), second2 = 3e38F;
  const float start_distance = sqrtf(best2);
  const auto consider = [&](std::uint32_t g, const Vec3f& prototype) {
    const float d2 = squaredDistance(v, prototype);
    if (d2 < best2) {
      second2 = best2;
      best2 = d2;
      best = g;
    } else {
      second2 = least(second2, d2);
    }
  };
  // A prototype that wins or ties is at most this far from the starting one.
  const auto bound = [&] {
    return (start_distance + sqrtf(reach2(v, best2, slack))) * (1 + 1e-5F);
  };
  const Neighbour* list = view.neighbours + std::size_t{start} * view.neighbour_count;
  float limit = bound();
  bool exhausted = true;
  for (std::uint32_t i = 0; i < view.neighbour_count; ++i) {
    if (list[i].distance > limit) {
      exhausted = false;
      break;
    }
    const std::uint32_t before = best;
    consider(list[i].cluster, list[i].prototype);
    if (best != before) limit = bound();
  }
  if (exhausted && view.neighbour_count + 1 < view.count) {
    best = start;
    best2 = squaredDistance(v, view.prototypes[start]);
    second2 = 3e38F;
    for (std::uint32_t g = 0; g < view.count; ++g) {
      if (g != start) consider(g, view.prototypes[g]);
    }
  }
  return {best, !(second2 > reach2(v, best2, slack))};
}

// Calls add(g) for every cluster g that the rule admits; the rule's first competitor is the cluster
// `first`. In no particular order, each once.
template <class Add>
DCM_HD inline void forEachAdmitted(const PrototypesView& view, const HalfSpaceRule& rule,
                                   std::uint32_t first, const Add& add) {
  const float radius = rule.searchRadius(view.prototypes[first]);
  const Neighbour* list = view.neighbours + std::size_t{first} * view.neighbour_count;
  const bool all =
      view.neighbour_count + 1 < view.count && !(list[view.neighbour_count - 1].distance > radius);
  if (all) {
    for (std::uint32_t g = 0; g < view.count; ++g) {
      if (rule.admits(view.prototypes[g])) add(g);
    }
    return;
  }
  if (rule.admits(view.prototypes[first])) add(first);
  for (std::uint32_t i = 0; i < view.neighbour_count && !(list[i].distance > radius); ++i) {
    if (rule.admits(list[i].prototype)) add(list[i].cluster);
  }
}

}  // namespace deformable_contact_monitor
