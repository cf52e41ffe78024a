// The narrow phase: decides which pairs of triangles are candidates, and which candidates are
// contacts.
//
// A pair goes through tests from cheap to expensive: float32 plane filters (isCandidate), float32
// determinants with an error bound (certainVerdict), double with an error bound (quickVerdict),
// exact arithmetic (fullVerdict), and, if a margin applies, the distance (nearVerdict). Backends
// call these parts at different places, but all get the same verdict.
#pragma once

#include "core/predicates/aabb.h"
#include "core/predicates/adjacency.h"
#include "core/predicates/float32_filters.h"
#include "core/predicates/triangle_distance.h"

namespace deformable_contact_monitor {

// The decision on a pair.
struct Verdict {
  bool contact = false;
  float separation_m = 0;  // 0: they intersect
};

// Decides whether two triangles that do not intersect are within the margin. `margin_m` is the
// larger of their bodies' margins [m]. They are near iff their boxes are at most that far apart
// along each axis, in real numbers, and their distance, rounded to float32, is at most that much.
// Boxes and planes decide first, so that most pairs need no distance.
DCM_HD inline Verdict nearVerdict(const Triangle& a, const Triangle& b, float margin_m) {
  if (margin_m == 0) return {};
  // The distance may be rounded down by half a step, which is most of a margin near 2^-149.
  constexpr double kSlack = 1 + 1e-6, kLeastStep = 0x1p-149;
  const double most_m = margin_m * kSlack + kLeastStep;
  const Aabb box_a = boxOf(a), box_b = boxOf(b);
  if (areApart(box_a, box_b, margin_m) || squaredGap(box_a, box_b) > most_m * most_m ||
      arePlanesApart(a, b, most_m)) {
    return {};
  }
  const double distance = separation(a, b);
  if (distance > most_m) return {};
  constexpr float kLeast = 1.4e-45F;  // 0 is for those that intersect
  const float rounded = most(kLeast, toFloat(least<double>(distance, FLT_MAX)));
  if (rounded > margin_m) return {};
  return {true, rounded};
}

// Applies the plane filters to two triangles that share no vertex. Returns true if one certainly
// lies strictly on one side of the other's plane. Fills in the sides that are certain.
DCM_HD inline bool certainlyApart(const Triangle& a, const PlaneFilter& plane_a, const Triangle& b,
                                  const PlaneFilter& plane_b, KnownSides& sides) {
  int sum_a = 0, sum_b = 0;
  for (int i = 0; i < 3; ++i) {
    sum_a += sides.a[i] = plane_b.side(a.v[i]);
    sum_b += sides.b[i] = plane_a.side(b.v[i]);
  }
  return sum_a == 3 || sum_a == -3 || sum_b == 3 || sum_b == -3;
}

// Fills in the missing sides of vertices that are not shared. The functions return a point's side
// of the plane of a, and of b: 1, -1, or anything else if it is open.
template <class SideOfA, class SideOfB>
DCM_HD inline void fillRestSides(const Triangle& a, const Triangle& b, const SharedVertices& shared,
                                 const SideOfA& side_of_a, const SideOfB& side_of_b,
                                 KnownSides& sides) {
  for (int i = 0; i < 3; ++i) {
    if (!shared.in_a[i] && sides.a[i] == 0) sides.a[i] = side_of_b(a.v[i]);
    if (!shared.in_b[i] && sides.b[i] == 0) sides.b[i] = side_of_a(b.v[i]);
  }
}

namespace detail {

// Returns on which side of the plane of t a point lies by double arithmetic, or kUncertain.
DCM_HD DCM_RARE inline int filteredSide(const Triangle& t, const Vec3f& p) {
  return orient3dFiltered(t.v[0], t.v[1], t.v[2], p);
}

// Returns whether the vertices that are not shared lie strictly on one side; true too if there are
// none.
DCM_HD inline bool restOnOneSide(const int side[3], const bool shared[3]) {
  bool plus = true, minus = true;
  for (int i = 0; i < 3; ++i) {
    plus = plus && (shared[i] || side[i] == 1);
    minus = minus && (shared[i] || side[i] == -1);
  }
  return plus || minus;
}

// For a triangle with one shared vertex: if the sides of the other two are strict, returns the side
// of the vertex that precedes the shared one; otherwise 0.
DCM_HD inline int sideAheadOfShared(const int side[3], const bool shared[3]) {
  int ahead = 0;
  bool strict = true;
  for (int i = 0; i < 3; ++i) {
    strict = strict && (shared[i] || isStrict(side[i]));
    if (shared[i]) ahead = side[i == 0 ? 2 : i - 1];
  }
  return strict ? ahead : 0;
}

}  // namespace detail

// Decides whether two triangles that share vertices meet beyond them, as far as signs of sides can.
//
// If the other vertices of one triangle lie strictly on one side of the other's plane, they do not
// meet. Otherwise let p be the only shared vertex, x and y the vertices that follow it in a, z and
// w those in b, and let each of these pairs lie on different sides of the other's plane. As vectors
// from p,
//
//   det(y, z, w) x - det(x, z, w) y + det(x, y, w) z - det(x, y, z) w = 0.
//
// det(z, w, .) says on which side of b's plane a point lies, and det(x, y, .) on which side of a's
// plane. The first two terms add up to s P: P is the point where the edge xy crosses b's plane, and
// the number s has the sign of y's side. The last two add up to t Q: Q is the point where the edge
// zw crosses a's plane, and t has the sign of w's side. Since s P + t Q = 0, P and Q lie on one ray
// from p, and the triangles meet there, iff s and t have different signs.
DCM_HD inline PartVerdict beyondSharedVerdict(const SharedVertices& shared,
                                              const KnownSides& sides) {
  if (detail::restOnOneSide(sides.a, shared.in_a) || detail::restOnOneSide(sides.b, shared.in_b)) {
    return PartVerdict::kApart;
  }
  const int y = detail::sideAheadOfShared(sides.a, shared.in_a);
  const int w = detail::sideAheadOfShared(sides.b, shared.in_b);
  if (y == 0 || w == 0) return PartVerdict::kOpen;
  return y != w ? PartVerdict::kMeet : PartVerdict::kApart;
}

// Facts about a pair that are known before its verdict: the vertices that the triangles share, the
// sides that the plane filters found, and the larger of their bodies' margins [m].
struct PairFacts {
  SharedVertices shared;
  KnownSides sides;
  float margin_m = 0;
};

// Decides, as far as float32 is certain, whether two triangles intersect, or meet beyond what they
// share. The known sides must not part them: isCandidate() holds without a margin.
DCM_HD inline PartVerdict certainVerdict(const Triangle& a, const Triangle& b,
                                         const PairFacts& facts) {
  if (facts.shared.any) return beyondSharedVerdict(facts.shared, facts.sides);
  if (detail::allStrict(facts.sides.a) && detail::allStrict(facts.sides.b)) {
    // The orientation is the side of the fourth point of the plane through the first three.
    const PartVerdict verdict =
        detail::crossingVerdict(a, facts.sides.a, b, facts.sides.b,
                                [](const Vec3f& p, const Vec3f& q, const Vec3f& r, const Vec3f& s) {
                                  const int side = PlaneFilter(Triangle{{p, q, r}}).side(s);
                                  return side == 0 ? kUncertain : side;
                                });
    if (verdict != PartVerdict::kOpen) return verdict;
  }
  return touchVerdict(a, b);
}

// Decides a candidate as far as the floating-point filters alone can. For triangles that share
// vertices it decides whether they meet beyond them. kApart says nothing about margins.
DCM_HD inline PartVerdict quickVerdict(const Triangle& a, const Triangle& b,
                                       const PairFacts& facts) {
  if (!facts.shared.any) {
    const PartVerdict verdict = quickIntersection(a, b, facts.sides);
    return verdict != PartVerdict::kOpen ? verdict : touchVerdict(a, b);
  }
  if (certainlyApartInProjection(a, b, facts.shared)) {
    return PartVerdict::kApart;
  }
  KnownSides sides = facts.sides;
  fillRestSides(
      a, b, facts.shared, [&a](const Vec3f& p) { return detail::filteredSide(a, p); },
      [&b](const Vec3f& p) { return detail::filteredSide(b, p); }, sides);
  return beyondSharedVerdict(facts.shared, sides);
}

// Decides any candidate exactly. It does not try the whole filters of quickVerdict() first; each
// sign of an orientation still tries double arithmetic before exact arithmetic. Margins do not
// apply to triangles that share vertices, because adjacent triangles of a mesh are always near.
DCM_HD inline Verdict fullVerdict(const Triangle& a, const Triangle& b, const PairFacts& facts,
                                  PredicateState& state) {
  if (facts.shared.any) return {meetBeyondShared(a, b, facts.shared, state), 0};
  if (robustIntersection(a, b, facts.sides, state)) return {true, 0};
  return nearVerdict(a, b, facts.margin_m);
}

// Decides any candidate: the filters first, then exact arithmetic for what they leave open.
DCM_HD inline Verdict candidateVerdict(const Triangle& a, const Triangle& b, const PairFacts& facts,
                                       PredicateState& state) {
  const PartVerdict quick = quickVerdict(a, b, facts);
  if (quick == PartVerdict::kOpen) return fullVerdict(a, b, facts, state);
  if (quick == PartVerdict::kMeet) return {true, 0};
  return facts.shared.any ? Verdict{} : nearVerdict(a, b, facts.margin_m);
}

// Returns whether the float32 plane filters leave the pair undecided: then it is a candidate. Fills
// in the sides that they found.
DCM_HD inline bool isCandidate(const Triangle& a, const Triangle& b, PairFacts& facts) {
  const PlaneFilter plane_a(a), plane_b(b);
  if (facts.shared.any) {
    fillRestSides(
        a, b, facts.shared, [&plane_a](const Vec3f& p) { return plane_a.side(p); },
        [&plane_b](const Vec3f& p) { return plane_b.side(p); }, facts.sides);
    return !detail::restOnOneSide(facts.sides.a, facts.shared.in_a) &&
           !detail::restOnOneSide(facts.sides.b, facts.shared.in_b);
  }
  return !certainlyApart(a, plane_a, b, plane_b, facts.sides) || facts.margin_m > 0;
}

}  // namespace deformable_contact_monitor
