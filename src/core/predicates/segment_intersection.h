// Tests whether points, segments and triangles, as closed sets, intersect; degenerate ones
// included. Only signs of orientation determinants and comparisons of coordinates decide; no point
// is constructed.
//
// A point is a Vec3f, or any type with orient2d(), orient3d(), inBox() and equality; a triangle has
// three of them, v. `state` is what orient2d() and orient3d() take.
#pragma once

#include "core/predicates/orientation.h"
#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

// Returns the first coordinate axis along which a, b, c project to a triangle with area, or -1 if
// they are collinear.
template <class Point>
DCM_HD inline int projectionAxis(const Point& a, const Point& b, const Point& c,
                                 PredicateState& state) {
  for (int axis = 0; axis < 3; ++axis) {
    if (orient2d(a, b, c, axis, state) != 0) return axis;
  }
  return -1;
}

// Returns whether p lies in the box of the segment ab.
DCM_HD inline bool inBox(const Vec3f& p, const Vec3f& a, const Vec3f& b) {
  for (int k = 0; k < 3; ++k) {
    if (p[k] < least(a[k], b[k]) || p[k] > most(a[k], b[k])) return false;
  }
  return true;
}

template <class Point>
DCM_HD inline bool pointOnSegment(const Point& p, const Point& a, const Point& b,
                                  PredicateState& state) {
  return inBox(p, a, b) && projectionAxis(a, b, p, state) < 0;
}

template <class Point>
DCM_HD DCM_RARE inline bool segmentsIntersect(const Point& p, const Point& q, const Point& a,
                                              const Point& b, PredicateState& state) {
  if (pointOnSegment(p, a, b, state) || pointOnSegment(q, a, b, state) ||
      pointOnSegment(a, p, q, state) || pointOnSegment(b, p, q, state)) {
    return true;
  }
  // No end point lies on the other segment. So they can only cross at inner points, in a common
  // plane.
  if (orient3d(p, q, a, b, state) != 0) return false;
  int axis = projectionAxis(p, q, a, state);
  if (axis < 0) axis = projectionAxis(p, q, b, state);
  if (axis < 0) return false;
  return orient2d(p, q, a, axis, state) * orient2d(p, q, b, axis, state) < 0 &&
         orient2d(a, b, p, axis, state) * orient2d(a, b, q, axis, state) < 0;
}

// Returns whether the signs do not contain both a positive and a negative one.
DCM_HD inline bool sameSide(int a, int b, int c) {
  return !((a > 0 || b > 0 || c > 0) && (a < 0 || b < 0 || c < 0));
}

// Returns whether p, in the plane of the triangle, lies in it. The triangle has area along `axis`.
template <class Point, class TriangleType>
DCM_HD inline bool pointInTriangle(const Point& p, const TriangleType& t, int axis,
                                   PredicateState& state) {
  return sameSide(orient2d(t.v[0], t.v[1], p, axis, state),
                  orient2d(t.v[1], t.v[2], p, axis, state),
                  orient2d(t.v[2], t.v[0], p, axis, state));
}

template <class Point, class TriangleType>
DCM_HD inline bool segmentMeetsEdges(const Point& p, const Point& q, const TriangleType& t,
                                     PredicateState& state) {
  return segmentsIntersect(p, q, t.v[0], t.v[1], state) ||
         segmentsIntersect(p, q, t.v[1], t.v[2], state) ||
         segmentsIntersect(p, q, t.v[2], t.v[0], state);
}

template <class Point, class TriangleType>
DCM_HD DCM_RARE inline bool segmentIntersectsTriangle(const Point& p, const Point& q,
                                                      const TriangleType& t,
                                                      PredicateState& state) {
  const int axis = projectionAxis(t.v[0], t.v[1], t.v[2], state);
  if (axis < 0) return segmentMeetsEdges(p, q, t, state);  // the triangle is its edges
  const int side_p = orient3d(t.v[0], t.v[1], t.v[2], p, state);
  const int side_q = orient3d(t.v[0], t.v[1], t.v[2], q, state);
  if (side_p * side_q > 0) return false;
  if (side_p == 0 && pointInTriangle(p, t, axis, state)) return true;
  if (side_q == 0 && pointInTriangle(q, t, axis, state)) return true;
  if (side_p == 0 && side_q == 0) return segmentMeetsEdges(p, q, t, state);
  if (side_p == 0 || side_q == 0) return false;
  return sameSide(orient3d(p, q, t.v[0], t.v[1], state), orient3d(p, q, t.v[1], t.v[2], state),
                  orient3d(p, q, t.v[2], t.v[0], state));
}

}  // namespace deformable_contact_monitor
