// Decides whether two triangles, as closed sets, intersect.
//
// quickIntersection() decides with filters alone; robustIntersection() decides all pairs. Triangles
// in general position follow Guigue and Devillers; special positions are reduced to tests of edges.
#pragma once

#include "core/predicates/flat_triangle.h"
#include "core/predicates/segment_intersection.h"

namespace deformable_contact_monitor {

// Returns whether some edge of one triangle meets the other. For closed triangles of any shape this
// is the same as intersecting.
DCM_HD DCM_RARE inline bool edgesMeetTriangles(const Triangle& a, const Triangle& b,
                                               PredicateState& state) {
  for (int i = 0; i < 3; ++i) {
    const int j = i == 2 ? 0 : i + 1;
    if (segmentIntersectsTriangle(a.v[i], a.v[j], b, state) ||
        segmentIntersectsTriangle(b.v[i], b.v[j], a, state)) {
      return true;
    }
  }
  return false;
}

// Rotates the vertices of a triangle so that the first one is alone on its side of the other's
// plane, and returns that side. No side may be zero, and not all may be equal.
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

// Sides of planes that are already known: 1, -1, or 0 if not known.
struct KnownSides {
  int a[3] = {0, 0, 0};  // of a's vertices, of b's plane
  int b[3] = {0, 0, 0};  // of b's vertices, of a's plane
};

namespace detail {

// Fills in the unknown sides of `points` of the plane of t, by orient(a, b, c, d).
template <class Orient>
DCM_HD inline void fillSides(const Triangle& t, const Triangle& points, int side[3],
                             const Orient& orient) {
  for (int i = 0; i < 3; ++i) {
    if (side[i] == 0) side[i] = orient(t.v[0], t.v[1], t.v[2], points.v[i]);
  }
}

DCM_HD inline bool allStrict(const int side[3]) {
  return isStrict(side[0]) && isStrict(side[1]) && isStrict(side[2]);
}

DCM_HD inline bool allZero(const int side[3]) {
  return side[0] == 0 && side[1] == 0 && side[2] == 0;
}

DCM_HD inline bool strictlyOnOneSide(const int side[3]) {
  return isStrict(side[0]) && side[0] == side[1] && side[0] == side[2];
}

// Decides two triangles that cross each other's planes with no vertex on them. Their intervals on
// the common line overlap iff two determinants say so (Guigue and Devillers, "Fast and Robust
// Triangle-Triangle Overlap Test Using Orientation Predicates", 2003).
template <class Orient>
DCM_HD inline PartVerdict crossingVerdict(Triangle a, const int side_a[3], Triangle b,
                                          const int side_b[3], const Orient& orient) {
  const bool flip_b = loneVertexFirst(a, side_a) < 0;
  const bool flip_a = loneVertexFirst(b, side_b) < 0;
  if (flip_a) a = {{a.v[0], a.v[2], a.v[1]}};
  if (flip_b) b = {{b.v[0], b.v[2], b.v[1]}};
  const int first = orient(a.v[0], a.v[1], b.v[0], b.v[1]);
  if (first == 1) return PartVerdict::kApart;
  const int second = orient(a.v[0], a.v[2], b.v[2], b.v[0]);
  if (second == 1) return PartVerdict::kApart;
  return first == kUncertain || second == kUncertain ? PartVerdict::kOpen : PartVerdict::kMeet;
}

// Decides by an orientation that may be kUncertain. The answer is open too if a vertex is on the
// other's plane.
template <class Orient>
DCM_HD inline PartVerdict generalVerdict(const Triangle& a, const Triangle& b, KnownSides& side,
                                         const Orient& orient) {
  fillSides(b, a, side.a, orient);
  if (strictlyOnOneSide(side.a)) return PartVerdict::kApart;
  fillSides(a, b, side.b, orient);
  if (strictlyOnOneSide(side.b)) return PartVerdict::kApart;
  if (!allStrict(side.a) || !allStrict(side.b)) return PartVerdict::kOpen;
  return crossingVerdict(a, side.a, b, side.b, orient);
}

}  // namespace detail

// The usual cases, by the floating-point filters alone.
DCM_HD inline PartVerdict quickIntersection(const Triangle& a, const Triangle& b, KnownSides side) {
  return detail::generalVerdict(a, b, side, orient3dFiltered);
}

namespace detail {

// In a common plane, projected along `axis`: is some edge line of t, which has area there, one that
// has all of `points` strictly on its outer side?
DCM_HD DCM_RARE inline bool edgeLineSeparates(const Triangle& t, const Vec3f* points, int count,
                                              int axis, PredicateState& state) {
  const int inner = orient2d(t.v[0], t.v[1], t.v[2], axis, state);
  for (int i = 0; i < 3; ++i) {
    bool outside = true;
    for (int k = 0; k < count && outside; ++k) {
      outside = orient2d(t.v[i], t.v[i == 2 ? 0 : i + 1], points[k], axis, state) == -inner;
    }
    if (outside) return true;
  }
  return false;
}

// Decides for a segment in the plane of t. They are disjoint iff a line along the segment or along
// an edge separates them, because the edges of their Minkowski difference are parallel to these.
DCM_HD inline bool coplanarSegmentMeets(const Vec3f& p, const Vec3f& q, const Triangle& t, int axis,
                                        PredicateState& state) {
  const Vec3f ends[2] = {p, q};
  if (edgeLineSeparates(t, ends, 2, axis, state)) return false;
  const int side = orient2d(p, q, t.v[0], axis, state);
  return side == 0 || orient2d(p, q, t.v[1], axis, state) != side ||
         orient2d(p, q, t.v[2], axis, state) != side;
}

// Returns whether some edge of t meets u, which has area along `axis`. `side` has the sides of t's
// vertices of u's plane; not all are zero.
DCM_HD DCM_RARE inline bool edgesMeet(const Triangle& t, const int side[3], const Triangle& u,
                                      int axis, PredicateState& state) {
  for (int i = 0; i < 3; ++i) {
    const int j = i == 2 ? 0 : i + 1;
    if (side[i] * side[j] > 0) continue;
    const Vec3f &p = t.v[i], &q = t.v[j];
    bool meets;
    if (side[i] == 0 && side[j] == 0) {
      meets = coplanarSegmentMeets(p, q, u, axis, state);
    } else if (side[i] == 0) {
      meets = pointInTriangle(p, u, axis, state);
    } else if (side[j] == 0) {
      meets = false;  // the next edge tests this vertex
    } else {
      meets = sameSide(orient3d(p, q, u.v[0], u.v[1], state), orient3d(p, q, u.v[1], u.v[2], state),
                       orient3d(p, q, u.v[2], u.v[0], state));
    }
    if (meets) return true;
  }
  return false;
}

}  // namespace detail

// Decides any two triangles with finite vertices. In conservative mode an undecided sign makes the
// result true.
DCM_HD DCM_RARE inline bool robustIntersection(const Triangle& a, const Triangle& b,
                                               KnownSides side, PredicateState& state) {
  const auto orient = [&state](const Vec3f& p, const Vec3f& q, const Vec3f& r, const Vec3f& s) {
    return orient3d(p, q, r, s, state);
  };
  const ErrorFreePlane plane_b(b.v[0], b.v[1], b.v[2]);
  detail::fillSides(
      b, a, side.a,
      [&plane_b, &state](const Vec3f& p, const Vec3f& q, const Vec3f& r, const Vec3f& s) {
        return sideOfPlane(plane_b, p, q, r, s, state);
      });
  if (detail::strictlyOnOneSide(side.a)) return false;  // certain, whatever was left open
  if (detail::allZero(side.a) && !state.undecided) {
    const PartVerdict flat = projectedVerdict(a, b, plane_b.broadAxis(), detail::exactTurn);
    if (flat != PartVerdict::kOpen) return flat == PartVerdict::kMeet;
  }
  // If a lies in b's plane and both have area, then b lies in a's plane: no sign need be zero
  // twice. If one has none, its edges decide below.
  const bool share_plane = detail::allZero(side.a) && !state.undecided;
  if (!share_plane) {
    detail::fillSides(a, b, side.b, orient);
    if (detail::strictlyOnOneSide(side.b)) return false;
    if (detail::allStrict(side.a) && detail::allStrict(side.b)) {
      return detail::crossingVerdict(a, side.a, b, side.b, orient) == PartVerdict::kMeet;
    }
    if (state.undecided) return true;
  }
  const int axis_a = projectionAxis(a.v[0], a.v[1], a.v[2], state);
  const int axis_b = projectionAxis(b.v[0], b.v[1], b.v[2], state);
  bool meet;
  if (axis_a < 0 || axis_b < 0) {
    meet = edgesMeetTriangles(a, b, state);  // one is a segment or a point
  } else if (detail::allZero(side.a)) {
    meet = !detail::edgeLineSeparates(a, b.v, 3, axis_a, state) &&
           !detail::edgeLineSeparates(b, a.v, 3, axis_a, state);
  } else {
    meet = detail::edgesMeet(a, side.a, b, axis_b, state) ||
           detail::edgesMeet(b, side.b, a, axis_a, state);
  }
  return meet || state.undecided;
}

// Returns whether two triangles with finite vertices intersect, as closed sets.
DCM_HD inline bool trianglesIntersect(const Triangle& a, const Triangle& b, const KnownSides& side,
                                      PredicateState& state) {
  const PartVerdict quick = quickIntersection(a, b, side);
  if (quick != PartVerdict::kOpen) return quick == PartVerdict::kMeet;
  return robustIntersection(a, b, side, state);
}

DCM_HD inline bool trianglesIntersect(const Triangle& a, const Triangle& b, PredicateState& state) {
  return trianglesIntersect(a, b, KnownSides(), state);
}

}  // namespace deformable_contact_monitor
