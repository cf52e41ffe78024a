// Decides whether moving triangles of one body that share vertices meet beyond the shared points at
// some time in the interval.
//
// Two triangles on one edge do iff they are folded onto each other at some time. Two on one vertex
// do iff the opposite edge of one meets the other triangle in another point at some time. That set
// of times need not be closed: two triangles may open up from a state in which one was folded into
// the shared point. Then their first time is the infimum. Floating point cannot decide such cases,
// because the edge meets the shared point there, so that they are left open.
#pragma once

#include "core/predicates/swept_intersection.h"

namespace deformable_contact_monitor {

// The vertices of two triangles that share some: each shared trajectory once, then the others.
struct SharedSplit {
  MovingPoint common[3], rest_a[3], rest_b[3];
  int common_count = 0, a_count = 0, b_count = 0;

  DCM_HD SharedSplit(const MovingTriangle& a, const MovingTriangle& b,
                     const SharedVertices& shared) {
    for (int i = 0; i < 3; ++i) {
      if (!shared.in_b[i]) rest_b[b_count++] = b.point(i);
      if (!shared.in_a[i]) {
        rest_a[a_count++] = a.point(i);
        continue;
      }
      bool known = false;
      for (int k = 0; k < common_count; ++k) known = known || common[k] == a.point(i);
      if (!known) common[common_count++] = a.point(i);
    }
  }
};

namespace detail {

// The number of features in which two triangles on the vertex p can meet beyond it. In
// featureAround() x and y are their other vertices.
constexpr int kFeaturesAroundVertex = 9;
DCM_HD inline Feature featureAround(const MovingPoint& p, const MovingPoint x[2],
                                    const MovingPoint y[2], int index) {
  switch (index) {
    case 0:
    case 1:
      return {FeatureKind::kVertexFace, {p, y[0], y[1], x[index]}};
    case 2:
    case 3:
      return {FeatureKind::kVertexFace, {p, x[0], x[1], y[index - 2]}};
    case 4:
    case 5:
      return {FeatureKind::kEdgeEdge, {x[0], x[1], p, y[index - 4]}};
    case 6:
    case 7:
      return {FeatureKind::kEdgeEdge, {y[0], y[1], p, x[index - 6]}};
    default:
      return {FeatureKind::kEdgeEdge, {x[0], x[1], y[0], y[1]}};
  }
}

// Returns whether p is certainly never on the line xy.
template <class Real>
DCM_HD inline bool neverOnLine(const MovingPoint& p, const MovingPoint x[2]) {
  const MovingVector<Real> u(p, x[0]), v(p, x[1]);
  const int axis = longestAxis(MovingNormal<Real>(u, v).middle());
  return projectedDeterminant(u, v, axis).sign() != 0;
}

template <class Real, unsigned kFilters>
DCM_HD inline bool certainlyApartAround(const MovingPoint& p, const MovingPoint a[2],
                                        const MovingPoint b[2]) {
  if ((kFilters & kMovingPlanes) != 0) {
    const MovingNormal<Real> normal_a(MovingVector<Real>(p, a[0]), MovingVector<Real>(p, a[1]));
    const int side_b0 = determinantOf(normal_a, MovingVector<Real>(p, b[0])).sign();
    const int side_b1 = determinantOf(normal_a, MovingVector<Real>(p, b[1])).sign();
    if (side_b0 * side_b1 > 0) return true;
    const MovingNormal<Real> normal_b(MovingVector<Real>(p, b[0]), MovingVector<Real>(p, b[1]));
    const int side_a0 = determinantOf(normal_b, MovingVector<Real>(p, a[0])).sign();
    const int side_a1 = determinantOf(normal_b, MovingVector<Real>(p, a[1])).sign();
    if (side_a0 * side_a1 > 0) return true;
  }
  return (kFilters & kFixedDirections) != 0 && areApartAround<Real>(p, a, b);
}

template <class Real, unsigned kFilters>
DCM_HD inline void addFeaturesAround(const SharedSplit& split, bool wants_time, Predicates mode,
                                     FirstMeeting& first) {
  const MovingPoint& p = split.common[0];
  const bool beyond = neverOnLine<Real>(p, split.rest_a) || neverOnLine<Real>(p, split.rest_b);
  for (int i = 0; i < kFeaturesAroundVertex; ++i) {
    const Feature feature = featureAround(p, split.rest_a, split.rest_b, i);
    if ((kFilters & kFeatureBoxes) != 0 && areApart(feature)) continue;
    const Cubic<Real> d = coplanarity<Real>(feature);
    if ((kFilters & kHalving) != 0 && d.sign() != 0) continue;
    FeatureVerdict verdict =
        featureVerdict<Real, kFilters>(feature, d, &p, wants_time, first.high, mode);
    // The opposite edges may cross in p, which is no contact beyond p.
    if (i == kFeaturesAroundVertex - 1 && verdict.part == PartVerdict::kMeet && !beyond) {
      verdict.part = PartVerdict::kOpen;
    }
    first.add(verdict, kWholePair);
    if (!wants_time && first.high <= 1) return;
  }
}

}  // namespace detail

// Decides two triangles with finite vertices that share some, as sharedTrajectories() says. If they
// do not move, it returns the static verdict. Apart from that it does what quickSweptVerdict()
// does.
template <class Real, unsigned kFilters = kAllSweptFilters>
DCM_HD inline SweptVerdict quickSweptBeyondShared(const MovingTriangle& a, const MovingTriangle& b,
                                                  const SharedVertices& shared, bool wants_time,
                                                  PredicateState& state) {
  const SharedSplit split(a, b, shared);
  if (split.a_count == 0 || split.b_count == 0) return {};
  const bool moves = !isStill(a) || !isStill(b);
  const bool around_vertex = split.common_count == 1 && split.a_count == 2 && split.b_count == 2;
  const Feature fold{FeatureKind::kFold,
                     {split.common[0], split.common[1], split.rest_a[0], split.rest_b[0]}};
  detail::FirstMeeting first;
  if (moves && around_vertex &&
      detail::certainlyApartAround<Real, kFilters>(split.common[0], split.rest_a, split.rest_b)) {
    return {};
  }
  if (moves && split.common_count == 2) {
    FeatureVerdict verdict{PartVerdict::kOpen, 0, 1};
    if ((kFilters & kHalving) != 0) {
      verdict = halvedVerdict<Real, (kFilters & kShortcuts) != 0>(fold, coplanarity<Real>(fold),
                                                                  wants_time, 1.0F);
    }
    if (verdict.part == PartVerdict::kApart) return {};
    first.add(verdict, kWholePair);
  }
  if (detail::meetInState(a.from, b.from, shared, state)) return detail::meetsAtStart(state);
  if (!moves) return {};
  const bool meets_at_end = detail::meetInState(a.to, b.to, shared, state);
  if (meets_at_end && !wants_time) return detail::meetsAt(0, 1);
  if (around_vertex) {
    detail::addFeaturesAround<Real, kFilters>(split, wants_time, state.mode, first);
    if (!wants_time && first.high <= 1) return detail::meetsAt(first.low, first.high);
  } else if (split.common_count == 1) {
    first.add({PartVerdict::kOpen, 0, 1}, kWholePair);
  } else if (first.open != 0 && (kFilters & kIntegerSigns) != 0 &&
             state.mode == Predicates::kExact && !meets_at_end &&
             integerSigns(fold) == IntegerSigns::kNoRootWithin) {
    return {};  // where they meet the points lie in one plane
  }
  return first.verdict(meets_at_end, state);
}

}  // namespace deformable_contact_monitor
