// From a pair of triangles to its verdict: which pairs are candidates, and which of them contacts.
#pragma once

#include "core/predicates/aabb.h"
#include "core/predicates/adjacency.h"
#include "core/predicates/plane_filter.h"
#include "core/predicates/triangle_distance.h"

namespace deformable_contact_monitor {

struct Verdict {
  bool contact = false;
  float separation_m = 0;  // 0: they intersect
};

// Two triangles that do not intersect. `margin_m` is the larger of their bodies' margins. They are
// near iff their boxes are at most that far apart along each axis, in real numbers, and their
// distance, rounded to float32, is at most that much.
DCM_HD inline Verdict nearVerdict(const Triangle& a, const Triangle& b, float margin_m) {
  if (margin_m == 0) return {};
  constexpr double kSlack = 1 + 1e-6;  // rounding
  const double most_m = margin_m * kSlack;
  const Aabb box_a = boxOf(a), box_b = boxOf(b);
  if (areApart(box_a, box_b, margin_m) || squaredGap(box_a, box_b) > most_m * most_m ||
      arePlanesApart(a, b, most_m)) {
    return {};
  }
  const double distance = separation(a, b);
  if (distance > most_m) return {};
  constexpr float kLeast = 1.4e-45F;  // 0 is for those that intersect
  const float rounded = most(kLeast, static_cast<float>(least<double>(distance, FLT_MAX)));
  if (rounded > margin_m) return {};
  return {true, rounded};
}

// The float32 filters of two triangles that share no vertex: true if one is certainly strictly on
// one side of the other's plane. Fills in the sides that they tell.
DCM_HD inline bool certainlyApart(const Triangle& a, const PlaneFilter& plane_a, const Triangle& b,
                                  const PlaneFilter& plane_b, KnownSides& sides) {
  int sum_a = 0, sum_b = 0;
  for (int i = 0; i < 3; ++i) {
    sum_a += sides.a[i] = plane_b.side(a.v[i]);
    sum_b += sides.b[i] = plane_a.side(b.v[i]);
  }
  return sum_a == 3 || sum_a == -3 || sum_b == 3 || sum_b == -3;
}

// The float32 filters of two triangles that share vertices: true if they certainly do not meet
// beyond them. Others strictly on one side of a plane through the shared vertices settle it. The
// functions tell a point's side of the plane of a and of b: 1, -1, or anything else where that is
// open.
template <class SideOfA, class SideOfB>
DCM_HD inline bool certainlyNotBeyondShared(const Triangle& a, const Triangle& b,
                                            const SharedVertices& shared, const SideOfA& side_of_a,
                                            const SideOfB& side_of_b) {
  int plus_a = 0, minus_a = 0, plus_b = 0, minus_b = 0, rest_a = 0, rest_b = 0;
  for (int i = 0; i < 3; ++i) {
    if (!shared.in_a[i]) {
      const int side = side_of_b(a.v[i]);
      plus_a += side == 1;
      minus_a += side == -1;
      ++rest_a;
    }
    if (!shared.in_b[i]) {
      const int side = side_of_a(b.v[i]);
      plus_b += side == 1;
      minus_b += side == -1;
      ++rest_b;
    }
  }
  return plus_a == rest_a || minus_a == rest_a || plus_b == rest_b || minus_b == rest_b;
}

DCM_HD inline bool certainlyNotBeyondShared(const Triangle& a, const PlaneFilter& plane_a,
                                            const Triangle& b, const PlaneFilter& plane_b,
                                            const SharedVertices& shared) {
  return certainlyNotBeyondShared(
      a, b, shared, [&plane_a](const Vec3f& p) { return plane_a.side(p); },
      [&plane_b](const Vec3f& p) { return plane_b.side(p); });
}

namespace detail {

// Projected along `axis`, is there a line through p, a vertex of both, along an edge from p, that
// has the rest of a and the rest of b strictly on different sides, but for the edge itself?
DCM_HD inline bool edgeLineSeparatesAngles(const Vec3f& p, const Vec3f a[2], const Vec3f b[2],
                                           int axis) {
  const int turn = orient2dFiltered(p, a[0], a[1], axis);
  if (turn != 1 && turn != -1) return false;
  const bool beyond_first = orient2dFiltered(p, a[0], b[0], axis) == -turn &&
                            orient2dFiltered(p, a[0], b[1], axis) == -turn;
  return beyond_first || (orient2dFiltered(p, a[1], b[0], axis) == turn &&
                          orient2dFiltered(p, a[1], b[1], axis) == turn);
}

// The axis along which a triangle's projection is about the largest.
DCM_HD inline int broadAxis(const Triangle& t) {
  const PlaneFilter plane(t);
  const float x = fabsf(plane.normal.x), y = fabsf(plane.normal.y), z = fabsf(plane.normal.z);
  return x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
}

}  // namespace detail

// By double arithmetic, and in a projection too: there neighbours in a flat surface, of which space
// says nothing, lie side by side. What does not meet in a projection does not meet.
DCM_HD inline bool certainlyNotBeyondShared(const Triangle& a, const Triangle& b,
                                            const SharedVertices& shared) {
  if (certainlyNotBeyondShared(
          a, b, shared,
          [&a](const Vec3f& p) { return orient3dFiltered(a.v[0], a.v[1], a.v[2], p); },
          [&b](const Vec3f& p) { return orient3dFiltered(b.v[0], b.v[1], b.v[2], p); })) {
    return true;
  }
  Vec3f common[2], rest_a[3], rest_b[3];
  int common_count = 0, a_count = 0, b_count = 0;
  for (int i = 0; i < 3; ++i) {
    if (!shared.in_a[i]) {
      rest_a[a_count < 2 ? a_count : 2] = a.v[i];
      ++a_count;
    } else {
      common[common_count < 1 ? 0 : 1] = a.v[i];
      ++common_count;
    }
    if (!shared.in_b[i]) {
      rest_b[b_count < 2 ? b_count : 2] = b.v[i];
      ++b_count;
    }
  }
  const int axis = detail::broadAxis(a);
  if (a_count == 1 && b_count == 1 && common_count == 2) {
    const int side_a = orient2dFiltered(common[0], common[1], rest_a[0], axis);
    const int side_b = orient2dFiltered(common[0], common[1], rest_b[0], axis);
    return side_a * side_b == -1;
  }
  if (a_count == 2 && b_count == 2) {
    return detail::edgeLineSeparatesAngles(common[0], rest_a, rest_b, axis) ||
           detail::edgeLineSeparatesAngles(common[0], rest_b, rest_a, axis);
  }
  return false;
}

// Of a triangle that shares one vertex with t: whether the edge opposite to it certainly crosses
// the inside of t.
DCM_HD inline bool certainlyCrosses(const Triangle& a, const bool shared[3], const Triangle& t) {
  if (shared[0] + shared[1] + shared[2] != 1) return false;
  const Vec3f p = shared[0] ? a.v[1] : a.v[0], q = shared[2] ? a.v[1] : a.v[2];
  if (orient3dFiltered(t.v[0], t.v[1], t.v[2], p) * orient3dFiltered(t.v[0], t.v[1], t.v[2], q) !=
      -1) {
    return false;
  }
  const int side = orient3dFiltered(p, q, t.v[0], t.v[1]);
  return (side == 1 || side == -1) && orient3dFiltered(p, q, t.v[1], t.v[2]) == side &&
         orient3dFiltered(p, q, t.v[2], t.v[0]) == side;
}

// What is known of a pair before its verdict: the vertices that they share, else the sides that the
// plane filters told, and the larger of their bodies' margins [m].
struct PairFacts {
  SharedVertices shared;
  KnownSides sides;
  float margin_m = 0;
};

// What float32 is certain of, of a pair that isCandidate(): whether two triangles that share no
// vertex, and of which the plane filters told all sides, cross each other.
DCM_HD inline PartVerdict certainVerdict(const Triangle& a, const Triangle& b,
                                         const PairFacts& facts) {
  if (facts.shared.any || !detail::allStrict(facts.sides.a) || !detail::allStrict(facts.sides.b)) {
    return PartVerdict::kOpen;
  }
  // The orientation is which side of the first three points' plane the fourth is on.
  return detail::crossingVerdict(
      a, facts.sides.a, b, facts.sides.b,
      [](const Vec3f& p, const Vec3f& q, const Vec3f& r, const Vec3f& s) {
        const int side = PlaneFilter(Triangle{{p, q, r}}).side(s);
        return side == 0 ? kUncertain : side;
      });
}

// The verdict on a candidate as far as the floating-point filters alone can tell; in fast mode
// float32 decides. Of triangles that share vertices: whether they meet beyond them. kApart says
// nothing about margins.
DCM_HD inline PartVerdict quickVerdict(const Triangle& a, const Triangle& b, const PairFacts& facts,
                                       Predicates mode) {
  if (!facts.shared.any) return quickIntersection(a, b, facts.sides, mode);
  if (mode == Predicates::kFast) return PartVerdict::kOpen;
  if (certainlyNotBeyondShared(a, b, facts.shared)) return PartVerdict::kApart;
  const bool meet =
      certainlyCrosses(a, facts.shared.in_a, b) || certainlyCrosses(b, facts.shared.in_b, a);
  return meet ? PartVerdict::kMeet : PartVerdict::kOpen;
}

// The verdict on any candidate, without asking the filters of quickVerdict again. Margins do not
// apply to triangles that share vertices: neighbours in a mesh are always near.
DCM_HD inline Verdict fullVerdict(const Triangle& a, const Triangle& b, const PairFacts& facts,
                                  PredicateState& state) {
  if (facts.shared.any) return {meetBeyondShared(a, b, facts.shared, state), 0};
  if (robustIntersection(a, b, facts.sides, state)) return {true, 0};
  return nearVerdict(a, b, facts.margin_m);
}

// The verdict on any candidate: the filters, then what they leave.
DCM_HD inline Verdict candidateVerdict(const Triangle& a, const Triangle& b, const PairFacts& facts,
                                       PredicateState& state) {
  const PartVerdict quick = quickVerdict(a, b, facts, state.mode);
  if (quick == PartVerdict::kOpen) return fullVerdict(a, b, facts, state);
  if (quick == PartVerdict::kMeet) return {true, 0};
  return facts.shared.any ? Verdict{} : nearVerdict(a, b, facts.margin_m);
}

// Whether the float32 plane filters leave a pair to the verdict: it is a candidate. Fills in the
// sides that they tell.
DCM_HD inline bool isCandidate(const Triangle& a, const Triangle& b, PairFacts& facts) {
  const PlaneFilter plane_a(a), plane_b(b);
  if (facts.shared.any) return !certainlyNotBeyondShared(a, plane_a, b, plane_b, facts.shared);
  return !certainlyApart(a, plane_a, b, plane_b, facts.sides) || facts.margin_m > 0;
}

}  // namespace deformable_contact_monitor
