// Do two triangles, as closed sets, intersect? The narrow phase.
#pragma once

#include "core/segment_intersection.h"

namespace deformable_contact_monitor {

// True iff some edge of one meets the other: for closed triangles of any shape that is the same as
// intersecting.
DCM_HD inline bool edgesMeetTriangles(const Triangle& a, const Triangle& b, PredicateState& state) {
  for (int i = 0; i < 3; ++i) {
    const int j = i == 2 ? 0 : i + 1;
    if (segmentIntersectsTriangle(a.v[i], a.v[j], b, state) ||
        segmentIntersectsTriangle(b.v[i], b.v[j], a, state)) {
      return true;
    }
  }
  return false;
}

// Turns a triangle with the given sides (none zero, not all alike) of the other's plane so that its
// first vertex is the one alone on its side; returns that side.
DCM_HD inline int loneVertexFirst(Triangle& t, const int side[3]) {
  if (side[0] == side[1]) {
    t = {{t.v[2], t.v[0], t.v[1]}};
    return side[2];
  }
  if (side[0] == side[2]) {
    t = {{t.v[1], t.v[2], t.v[0]}};
    return side[1];
  }
  return side[0];
}

// Both triangles cross the other's plane with no vertex on it: their intervals on the common line
// overlap iff two determinants say so (Guigue and Devillers, "Fast and Robust Triangle-Triangle
// Overlap Test Using Orientation Predicates", 2003).
DCM_HD inline bool crossingIntervalsOverlap(Triangle a, const int side_a[3], Triangle b,
                                            const int side_b[3], PredicateState& state) {
  const bool flip_b = loneVertexFirst(a, side_a) < 0;
  const bool flip_a = loneVertexFirst(b, side_b) < 0;
  if (flip_a) a = {{a.v[0], a.v[2], a.v[1]}};
  if (flip_b) b = {{b.v[0], b.v[2], b.v[1]}};
  return orient3d(a.v[0], a.v[1], b.v[0], b.v[1], state) <= 0 &&
         orient3d(a.v[0], a.v[2], b.v[2], b.v[0], state) <= 0;
}

// Sides of a plane that are known already: 1, -1, or 0 for those that are not.
struct KnownSides {
  int a[3] = {0, 0, 0};  // of a's vertices, of b's plane
  int b[3] = {0, 0, 0};  // of b's vertices, of a's plane
};

// Fills in the sides of `points` of the plane of t; true if all are strictly on one.
DCM_HD inline bool onOneSide(const Triangle& t, const Triangle& points, int side[3],
                             PredicateState& state) {
  for (int i = 0; i < 3; ++i) {
    if (side[i] == 0) side[i] = orient3d(t.v[0], t.v[1], t.v[2], points.v[i], state);
  }
  return side[0] != 0 && side[0] == side[1] && side[0] == side[2];
}

// Closed-set intersection of any two triangles with finite vertices. In conservative mode an
// undecided sign makes it true.
DCM_HD inline bool trianglesIntersect(const Triangle& a, const Triangle& b, KnownSides side,
                                      PredicateState& state) {
  if (onOneSide(b, a, side.a, state) || onOneSide(a, b, side.b, state)) return false;
  if (state.undecided) return true;
  const bool general = side.a[0] * side.a[1] * side.a[2] * side.b[0] * side.b[1] * side.b[2] != 0;
  const bool meet = general ? crossingIntervalsOverlap(a, side.a, b, side.b, state)
                            : edgesMeetTriangles(a, b, state);
  return meet || state.undecided;
}

DCM_HD inline bool trianglesIntersect(const Triangle& a, const Triangle& b, PredicateState& state) {
  return trianglesIntersect(a, b, KnownSides(), state);
}

}  // namespace deformable_contact_monitor
