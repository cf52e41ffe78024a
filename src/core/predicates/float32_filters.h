// The float32 filters of the narrow phase. They decide most pairs, and are always right when they
// decide.
//
// A plane filter tells whether a triangle certainly lies on one side of another's plane. A
// projection filter tells whether two triangles certainly do not meet when projected along a
// coordinate axis: triangles whose projections do not meet do not meet. It helps where planes tell
// nothing, for triangles in one plane. These mostly lie side by side, but in layers of cloth they
// overlap, or have the same vertices.
#pragma once

#include <cmath>

#include "core/host_device.h"
#include "core/predicates/adjacency.h"
#include "core/predicates/flat_triangle.h"
#include "core/predicates/orientation.h"
#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

// The plane of a triangle: its normal, and the sizes of the terms that bound the error of distances
// from it.
struct PlaneFilter {
  Vec3f origin, normal, permanent;

  PlaneFilter() = default;
  DCM_HD explicit PlaneFilter(const Triangle& t) : origin(t.v[0]) {
    const Vec3f u = t.v[1] - t.v[0], w = t.v[2] - t.v[0];
    const float m1 = u.y * w.z, m2 = u.z * w.y, m3 = u.z * w.x;
    const float m4 = u.x * w.z, m5 = u.x * w.y, m6 = u.y * w.x;
    normal = {m1 - m2, m3 - m4, m5 - m6};
    // The constant covers products that underflow.
    permanent = {fabsf(m1) + fabsf(m2) + 1e-37F, fabsf(m3) + fabsf(m4) + 1e-37F,
                 fabsf(m5) + fabsf(m6) + 1e-37F};
  }

  // Computes the distance of a point from the plane and the bound of its error, in units of the
  // normal. Real is float, or a vector of floats for several points at once.
  template <class Real>
  DCM_HD void distance(const Real& x, const Real& y, const Real& z, Real& value,
                       Real& error) const {
    const Real dx = x - origin.x, dy = y - origin.y, dz = z - origin.z;
    value = normal.x * dx + normal.y * dy + normal.z * dz;
    constexpr float kBound =
        4.3e-7F;  // (7 + 56 u) u, u = 2^-24, Shewchuk's for orient3d, and slack
    error = kBound * (permanent.x * most(dx, -dx) + permanent.y * most(dy, -dy) +
                      permanent.z * most(dz, -dz)) +
            1e-36F;
  }

  // Returns 1 or -1 if p is certainly strictly on that side, 0 if that is open, as it is after an
  // overflow.
  DCM_HD int side(const Vec3f& p) const {
    float value, error;
    distance(p.x, p.y, p.z, value, error);
    return (value > error) - (value < -error);
  }
};

namespace detail {

// Returns the axis along which a triangle's projection is about the largest.
DCM_HD inline int broadAxis(const Triangle& t) {
  const PlaneFilter plane(t);
  const float x = fabsf(plane.normal.x), y = fabsf(plane.normal.y), z = fabsf(plane.normal.z);
  return x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
}

// Returns the turn by double arithmetic, 0 if c is certainly on the line, or kUncertain.
DCM_HD inline int doubleTurn(const FlatPoint& a, const FlatPoint& b, const FlatPoint& c) {
  return orient2dErrorFree(a.x, a.y, b.x, b.y, c.x, c.y);
}

// Rotates t so that the vertex comes first that is the only shared one, or the only other one.
DCM_HD inline void oddVertexFirst(FlatTriangle& t, const bool shared[3]) {
  const FlatPoint first = t.v[0];
  if (shared[0] == shared[1]) {
    t.v[0] = t.v[2];
    t.v[2] = t.v[1];
    t.v[1] = first;
  } else if (shared[0] == shared[2]) {
    t.v[0] = t.v[1];
    t.v[1] = t.v[2];
    t.v[2] = first;
  }
}

// Returns whether p lies between the points a and b of a line through p.
DCM_HD inline bool isBetween(const FlatPoint& a, const FlatPoint& p, const FlatPoint& b) {
  return (a.x < p.x && p.x < b.x) || (a.x > p.x && p.x > b.x) || (a.y < p.y && p.y < b.y) ||
         (a.y > p.y && p.y > b.y);
}

// Returns whether the line of an edge of a that leaves the shared vertex v[0] certainly separates
// the rest of a from the rest of b. The other vertices of b may lie on the line too, if they are
// beyond the shared one.
DCM_HD inline bool edgeLineSeparatesAngles(const FlatTriangle& a, const FlatTriangle& b) {
  const int turn_a = doubleTurn(a.v[0], a.v[1], a.v[2]);
  if (!isStrict(turn_a)) return false;
  DCM_ROLLED for (int edge = 1; edge < 3; ++edge) {
    const FlatPoint end = edge == 1 ? a.v[1] : a.v[2];
    const int outer = edge == 1 ? -turn_a : turn_a;
    const int first = doubleTurn(a.v[0], end, b.v[1]), second = doubleTurn(a.v[0], end, b.v[2]);
    if ((first == outer || (first == 0 && isBetween(end, a.v[0], b.v[1]))) &&
        (second == outer || (second == 0 && isBetween(end, a.v[0], b.v[2])))) {
      return true;
    }
  }
  return false;
}

}  // namespace detail

// Decides two triangles that share no vertex, as far as float32 is certain without the sides of
// planes. They meet if they have a common point: a vertex of both, or a point of a plane across a
// coordinate axis in which both lie. They are apart if their projections are.
DCM_HD inline PartVerdict touchVerdict(const Triangle& a, const Triangle& b) {
  if (haveEqualVertices(a, b)) return PartVerdict::kMeet;
  const int axis = detail::broadAxis(a);
  const PartVerdict verdict = projectedVerdict(a, b, axis, detail::certainTurn);
  if (verdict != PartVerdict::kMeet) return verdict;
  return areLevel(a, b, axis) ? PartVerdict::kMeet : PartVerdict::kOpen;
}

// Two triangles that share vertices: do their projections show, by double arithmetic, that they
// certainly do not meet beyond them?
DCM_HD inline bool certainlyApartInProjection(const Triangle& a, const Triangle& b,
                                              const SharedVertices& shared) {
  const int count_a = shared.in_a[0] + shared.in_a[1] + shared.in_a[2];
  const int count_b = shared.in_b[0] + shared.in_b[1] + shared.in_b[2];
  if (count_a != count_b || count_a == 3) return false;
  const int axis = detail::broadAxis(a);
  detail::FlatTriangle flat_a(a, axis), flat_b(b, axis);
  detail::oddVertexFirst(flat_a, shared.in_a);
  detail::oddVertexFirst(flat_b, shared.in_b);
  if (count_a == 2) {
    const int side_a = detail::doubleTurn(flat_a.v[1], flat_a.v[2], flat_a.v[0]);
    return side_a * detail::doubleTurn(flat_a.v[1], flat_a.v[2], flat_b.v[0]) == -1;
  }
  return detail::edgeLineSeparatesAngles(flat_a, flat_b) ||
         detail::edgeLineSeparatesAngles(flat_b, flat_a);
}

}  // namespace deformable_contact_monitor
