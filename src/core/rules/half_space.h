// The half-space rule: which clusters a triangle belongs to.
//
// Theorem: give each prototype p_g its closed Voronoi cell. Put a triangle T into cluster g, unless
// for some competitor k every point of T is strictly nearer to p_k than to p_g. If two triangles
// meet in a point x, then they share a cluster.
//
// Proof: let x lie in the cell of g, so that no prototype is strictly nearer to x than p_g. Both
// triangles contain x, so no competitor can keep either of them out of g.
//
// This holds for any prototypes and any choice of competitors; more competitors only keep more
// triangles out. |x - p_g|^2 - |x - p_k|^2 is affine in x, so that the three vertices of T decide.
// For a moving triangle its six vertices of both states decide, as it lies in their convex hull at
// all times.
//
// The rule gets scaled and rounded coordinates. Let v' be such a vertex, at most d away from the
// true vertex v. If |v - p_g| <= |v - p_k|, then |v' - p_g| <= |v' - p_k| + 2 d, so the rule
// compares with a slack of 2 d. A margin m moves a vertex by m more, so the slack is then 2 (d +
// m).
#pragma once

#include <cmath>
#include <cstdint>

#include "core/host_device.h"
#include "core/predicates/triangle.h"
#include "core/rules/scene_scale.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

DCM_HD inline float squaredDistance(const Vec3f& a, const Vec3f& b) {
  const Vec3f d = a - b;
  return d.x * d.x + d.y * d.y + d.z * d.z;
}

// Returns the largest squared distance to p_g at which a vertex `v`, at squared distance `d2` from
// a competitor, may still be on the side of p_g. `slack` is twice the margin [scaled].
DCM_HD inline float reach2(const Vec3f& v, float d2, float slack) {
  const float error = (fabsf(v.x) + fabsf(v.y) + fabsf(v.z)) * (2 * kScaledError);
  const float reach = sqrtf(d2) + error + slack;
  constexpr float kRounding = 1 + 4e-6F;  // both squared distances, the root and this line
  return reach * reach * kRounding + 1e-37F;
}

// The rule for one triangle: its scaled vertices, and how far each vertex reaches for each
// competitor. A moving triangle has six points, its vertices at both ends of the time interval.
template <int kPoints>
struct HalfSpaceRuleOf {
  static constexpr int kCompetitors = 4;
  Vec3f v[kPoints];
  float reach2[kCompetitors][kPoints] = {};
  int competitors = 0;

  // The loops in these two functions have constant array indices, so that the arrays can live in
  // registers.
  DCM_HD void addCompetitor(const Vec3f& prototype, float slack) {
    for (int k = 0; k < kCompetitors; ++k) {
      if (k != competitors) continue;
      for (int i = 0; i < kPoints; ++i) {
        reach2[k][i] =
            deformable_contact_monitor::reach2(v[i], squaredDistance(v[i], prototype), slack);
      }
    }
    ++competitors;
  }

  DCM_HD bool admits(const Vec3f& prototype) const {
    float d2[kPoints];
    for (int i = 0; i < kPoints; ++i) d2[i] = squaredDistance(v[i], prototype);
    bool admitted = true;
    for (int k = 0; k < kCompetitors; ++k) {
      bool beyond = true;
      for (int i = 0; i < kPoints; ++i) beyond = beyond && d2[i] > reach2[k][i];  // NaN admits
      admitted = admitted && (k >= competitors || !beyond);
    }
    return admitted;
  }

  // Returns a distance from the first competitor, `prototype`, within which all admitted prototypes
  // lie.
  DCM_HD float searchRadius(const Vec3f& prototype) const {
    float radius = 0;
    for (int i = 0; i < kPoints; ++i) {
      radius = most(radius, sqrtf(reach2[0][i]) + sqrtf(squaredDistance(v[i], prototype)));
    }
    return radius * (1 + 1e-5F);
  }
};

using HalfSpaceRule = HalfSpaceRuleOf<3>;

// One entry of a prototype's list of neighbours, the nearest first.
struct alignas(16) Neighbour {
  Vec3f prototype;
  float distance = NAN;  // between the two prototypes; NaN: the list has ended
};

constexpr std::uint32_t kMostNeighbours = 128;

// A squared distance. Two prototypes closer than this, in a scene of size 2, would only share all
// their triangles.
constexpr float kCoincident2 = 1e-12F;

// Prototypes, each with a list of those nearest to it. A list need not reach far enough: then the
// search goes on over all prototypes.
struct PrototypesView {
  const Vec3f* prototypes;
  const float* list_reach;  // per prototype: all others that are nearer than this are on its list
  const Neighbour* neighbours;             // kMostNeighbours per prototype
  const std::uint32_t* neighbour_cluster;  // kMostNeighbours per prototype: whose they are
  std::uint32_t count;

  DCM_HD std::size_t listBegin(std::uint32_t g) const { return std::size_t{g} * kMostNeighbours; }
};

// The nearest prototype of a point, and whether another one is equally near within rounding. Then
// the point may lie in either cell.
struct NearestPrototype {
  std::uint32_t cluster = 0;
  bool tied = false;
};

// Returns whether a triangle, given the nearest prototypes of its points, lies inside one cell:
// then it belongs to that cluster alone, and needs no rule.
template <int kPoints = 3>
DCM_HD inline bool isInterior(const NearestPrototype nearest[kPoints]) {
  bool interior = !nearest[0].tied;
  for (int k = 1; k < kPoints; ++k) {
    interior = interior && nearest[k].cluster == nearest[0].cluster && !nearest[k].tied;
  }
  return interior;
}

// The least and the second least squared distance of a point to a prototype, and which prototype is
// the nearest.
struct NearestSearch {
  std::uint32_t cluster = 0;
  float least2 = 3e38F, second2 = 3e38F;

  DCM_HD void consider(std::uint32_t g, float d2) {
    if (d2 < least2) {
      second2 = least2;
      least2 = d2;
      cluster = g;
    } else {
      second2 = least(second2, d2);
    }
  }
  DCM_HD NearestPrototype result(const Vec3f& v, float slack) const {
    return {cluster, !(second2 > reach2(v, least2, slack))};
  }
};

// Calls visit(place, neighbour) along the list of prototype g as long as neighbours are no farther
// from it than limit(), which may fall meanwhile. It reads some at a time, so that they are loaded
// together.
template <class Limit, class Visit>
DCM_HD inline void walkList(const PrototypesView& view, std::uint32_t g, const Limit& limit,
                            const Visit& visit) {
  constexpr std::uint32_t kAtATime = 8;
  const std::size_t begin = view.listBegin(g);
  for (std::uint32_t i = 0; i < kMostNeighbours; i += kAtATime) {
    Neighbour n[kAtATime];
    for (std::uint32_t k = 0; k < kAtATime; ++k) n[k] = view.neighbours[begin + i + k];
    for (std::uint32_t k = 0; k < kAtATime; ++k) {
      if (!(n[k].distance <= limit())) return;
      visit(i + k, n[k].prototype);
    }
  }
}

// Walks from the list of `start` to the list of the nearest prototype on it, and so on, until a
// list reaches far enough to be sure. Returns false if none does; then `nearest` is a good guess.
DCM_HD inline bool nearestListed(const PrototypesView& view, const Vec3f& v, std::uint32_t start,
                                 float slack, NearestSearch& nearest) {
  constexpr std::uint32_t kAtStart = ~std::uint32_t{0};
  float least2_before = INFINITY;
  while (true) {
    nearest = {start, squaredDistance(v, view.prototypes[start])};
    const float start_distance = sqrtf(nearest.least2);
    if (!(start_distance < view.list_reach[start])) return false;  // all of it would not do
    nearest.cluster = kAtStart;
    // A prototype that is the nearest, or equally near, is at most this far from the starting one.
    const auto bound = [&] {
      return (start_distance + sqrtf(reach2(v, nearest.least2, slack))) * (1 + 1e-5F);
    };
    float limit = bound();
    walkList(
        view, start, [&limit] { return limit; },
        [&](std::uint32_t place, const Vec3f& prototype) {
          const float d2 = squaredDistance(v, prototype);
          const bool nearer = d2 < nearest.least2;
          nearest.consider(place, d2);
          if (nearer) limit = bound();
        });
    const bool moved = nearest.cluster != kAtStart;
    nearest.cluster =
        moved ? view.neighbour_cluster[view.listBegin(start) + nearest.cluster] : start;
    if (view.list_reach[start] > limit) return true;
    // The walk must end, so that each step must get nearer by numbers of the same kind: a rounded
    // distance may differ between places where it is computed.
    if (!moved || !(nearest.least2 < least2_before)) return false;
    least2_before = nearest.least2;
    start = nearest.cluster;
  }
}

DCM_HD inline NearestSearch nearestOfAll(const PrototypesView& view, const Vec3f& v) {
  NearestSearch nearest;
  for (std::uint32_t g = 0; g < view.count; ++g) {
    nearest.consider(g, squaredDistance(v, view.prototypes[g]));
  }
  return nearest;
}

// Returns the nearest prototype. A good guess `start` makes it fast; any is right.
DCM_HD inline NearestPrototype nearestPrototype(const PrototypesView& view, const Vec3f& v,
                                                std::uint32_t start, float slack) {
  NearestSearch nearest;
  if (!nearestListed(view, v, start, slack, nearest)) nearest = nearestOfAll(view, v);
  return nearest.result(v, slack);
}

// Returns the rule for a triangle with scaled points `v`, three per state, whose nearest prototypes
// are `nearest`. `overlap` in [0, 1] is the part of the triangle, about the centroid of each state,
// that decides. `first` becomes the first competitor.
template <int kPoints = 3>
DCM_HD inline HalfSpaceRuleOf<kPoints> ruleFor(const PrototypesView& view, const Vec3f v[kPoints],
                                               const NearestPrototype nearest[kPoints],
                                               float overlap, float slack, std::uint32_t& first) {
  HalfSpaceRuleOf<kPoints> rule;
  std::uint32_t competitor[kPoints];
  for (int k = 0; k < kPoints; ++k) {
    rule.v[k] = v[k];
    competitor[k] = nearest[k].cluster;
  }
  if (overlap < 1) {
    for (int state = 0; state < kPoints; state += 3) {
      const Vec3f centroid = centroidOf(v + state);
      for (int k = state; k < state + 3; ++k) {
        rule.v[k] = centroid + (rule.v[k] - centroid) * overlap;
      }
      const std::uint32_t its = nearestPrototype(view, centroid, competitor[state], slack).cluster;
      if (state == 0) first = its;
      if (state > 0) competitor[0] = its;
    }
    rule.addCompetitor(view.prototypes[first], slack);
  } else {
    // Compares, for each competitor, the farthest of the triangle's points from it, and begins with
    // the competitor for which that is least, because the search around it is the shortest.
    float least2 = INFINITY;
    for (int k = 0; k < kPoints; ++k) {
      const Vec3f p = view.prototypes[competitor[k]];
      float farthest2 = squaredDistance(v[0], p);
      for (int i = 1; i < kPoints; ++i) farthest2 = most(farthest2, squaredDistance(v[i], p));
      if (k > 0 && farthest2 < least2) {
        const std::uint32_t former = competitor[0];
        competitor[0] = competitor[k];
        competitor[k] = former;
      }
      least2 = least(least2, farthest2);
    }
    first = competitor[0];
  }
  for (int k = 0; k < kPoints; ++k) {
    // For six points, the first competitors that differ are enough.
    bool is_new = kPoints == 3 || overlap == 1 || competitor[k] != first;
    for (int i = 0; kPoints > 3 && i < k; ++i) is_new = is_new && competitor[i] != competitor[k];
    if (is_new) rule.addCompetitor(view.prototypes[competitor[k]], slack);
  }
  return rule;
}

// Returns whether the list of the first competitor holds all clusters that the rule may admit.
template <int kPoints>
DCM_HD inline bool listSuffices(const PrototypesView& view, const HalfSpaceRuleOf<kPoints>& rule,
                                std::uint32_t first, float& radius) {
  radius = rule.searchRadius(view.prototypes[first]);
  return view.list_reach[first] > radius;
}

// Calls add(place) for each of the neighbours of the first competitor that the rule admits.
template <int kPoints, class Add>
DCM_HD inline void forEachListed(const PrototypesView& view, const HalfSpaceRuleOf<kPoints>& rule,
                                 std::uint32_t first, float radius, const Add& add) {
  walkList(
      view, first, [radius] { return radius; },
      [&](std::uint32_t place, const Vec3f& prototype) {
        if (rule.admits(prototype)) add(place);
      });
}

// Calls add(g) once for every cluster g that the rule admits, in no particular order.
template <int kPoints, class Add>
DCM_HD inline void forEachAdmitted(const PrototypesView& view, const HalfSpaceRuleOf<kPoints>& rule,
                                   std::uint32_t first, const Add& add) {
  float radius;
  if (listSuffices(view, rule, first, radius)) {
    if (rule.admits(view.prototypes[first])) add(first);
    forEachListed(view, rule, first, radius, [&](std::uint32_t place) {
      add(view.neighbour_cluster[view.listBegin(first) + place]);
    });
    return;
  }
  for (std::uint32_t g = 0; g < view.count; ++g) {
    if (rule.admits(view.prototypes[g])) add(g);
  }
}

}  // namespace deformable_contact_monitor
