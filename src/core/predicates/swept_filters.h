// Filters of continuous collision detection: planes that move with one triangle, and fixed
// directions along which two triangles are apart at both ends of the time interval. What they say
// is certain for the whole interval.
#pragma once

#include "core/predicates/swept_polynomials.h"

namespace deformable_contact_monitor {

// The plane of a triangle, moving with it. A point is strictly above it at all times if the
// determinant of the triangle's edges and the point is always positive, and below if it is always
// negative.
template <class Real>
struct MovingPlane {
  MovingPoint origin;
  MovingNormal<Real> normal;

  DCM_HD explicit MovingPlane(const MovingTriangle& t)
      : origin(t.point(0)),
        normal(MovingVector<Real>(t.point(0), t.point(1)),
               MovingVector<Real>(t.point(0), t.point(2))) {}
};

// The vertices of one triangle against the moving plane of the other.
template <class Real>
struct MovingSides {
  Cubic<Real> of[3];

  DCM_HD MovingSides(const MovingPlane<Real>& plane, const MovingTriangle& t) {
    const MovingVector<Real> w[3] = {
        {plane.origin, t.point(0)}, {plane.origin, t.point(1)}, {plane.origin, t.point(2)}};
    determinantsOf(plane.normal, w, of);
  }

  // Returns whether they are certainly strictly on one side of the plane at all times.
  DCM_HD bool areApart() const {
    const int side = of[0].sign();
    return side != 0 && of[1].sign() == side && of[2].sign() == side;
  }

  // Returns the certain sides at the start, in the form of KnownSides.
  DCM_HD void atStart(int side[3]) const {
    for (int i = 0; i < 3; ++i) side[i] = of[i].signAtStart();
  }
  DCM_HD void atEnd(int side[3]) const {
    for (int i = 0; i < 3; ++i) side[i] = of[i].signAtEnd();
  }
};

// Two sets of points of one state, relative to one point, and how far they reach from it.
template <class Real, int kCount>
struct Recentred {
  Vector<Real> a[kCount], b[kCount];
  Vector<Real> reach;

  DCM_HD Recentred(const Vec3f& centre, const Vec3f* points_a, const Vec3f* points_b) {
    for (int k = 0; k < 3; ++k) reach.x[k] = 0;
    for (int i = 0; i < kCount; ++i) {
      a[i] = between<Real>(centre, points_a[i]);
      b[i] = between<Real>(centre, points_b[i]);
      for (int k = 0; k < 3; ++k) {
        reach.x[k] = most(reach.x[k], most(sizeOf(a[i].x[k]), sizeOf(b[i].x[k])));
      }
    }
  }

  // Returns 1 if all of b certainly lies strictly beyond all of a along n, -1 if a lies beyond b, 0
  // if it is open. A projection is off by 4 u of the projection of `reach`; the bound has room for
  // two of them.
  DCM_HD int order(const Vector<Real>& n) const {
    Real low_a = dotOf(n, a[0]), low_b = dotOf(n, b[0]), high_a = low_a, high_b = low_b;
    for (int i = 1; i < kCount; ++i) {
      const Real x = dotOf(n, a[i]), y = dotOf(n, b[i]);
      low_a = least(low_a, x);
      high_a = most(high_a, x);
      low_b = least(low_b, y);
      high_b = most(high_b, y);
    }
    const Real error = bound(n);
    return (low_b - high_a > error) - (low_a - high_b > error);
  }

  // Returns 1 if b is certainly strictly beyond the centre along n and a strictly before it, -1 for
  // the opposite, 0 if it is open.
  DCM_HD int sidesOfCentre(const Vector<Real>& n) const {
    const Real error = bound(n);
    bool a_before = true, a_beyond = true, b_before = true, b_beyond = true;
    for (int i = 0; i < kCount; ++i) {
      const Real x = dotOf(n, a[i]), y = dotOf(n, b[i]);
      a_before = a_before && x < -error;
      a_beyond = a_beyond && x > error;
      b_before = b_before && y < -error;
      b_beyond = b_beyond && y > error;
    }
    return (a_before && b_beyond) - (a_beyond && b_before);
  }

 private:
  DCM_HD Real bound(const Vector<Real>& n) const {
    const Real size = sizeOfDot(reach, n);
    return 12 * Rounding<Real>::kUnit * greatest(size, Real(0), Real(0), Real(0)) +
           Rounding<Real>::kSum;
  }
};

// Two triangles in both states, each relative to a's first vertex.
template <class Real>
class FixedDirections {
 public:
  DCM_HD FixedDirections(const MovingTriangle& a, const MovingTriangle& b)
      : from_(a.from.v[0], a.from.v, b.from.v), to_(a.to.v[0], a.to.v, b.to.v) {
    for (int i = 0; i < 3; ++i) {
      const int j = i == 2 ? 0 : i + 1;
      edge_a_[i] = sumOf(difference(from_.a[i], from_.a[j]), difference(to_.a[i], to_.a[j]));
      edge_b_[i] = sumOf(difference(from_.b[i], from_.b[j]), difference(to_.b[i], to_.b[j]));
    }
  }

  // Returns whether they are certainly apart along one of twelve directions: the two normals
  // halfway through the interval through the interval, the line of centres there, and the nine
  // cross products of edges there.
  DCM_HD bool areApart() const {
    if (areApartAlong(crossOf(edge_a_[0], edge_a_[1])) ||
        areApartAlong(crossOf(edge_b_[0], edge_b_[1])) || areApartAlong(centres())) {
      return true;
    }
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        if (areApartAlong(crossOf(edge_a_[i], edge_b_[j]))) return true;
      }
    }
    return false;
  }

 private:
  DCM_HD static Vector<Real> difference(const Vector<Real>& p, const Vector<Real>& q) {
    return {{q.x[0] - p.x[0], q.x[1] - p.x[1], q.x[2] - p.x[2]}};
  }

  DCM_HD Vector<Real> centres() const {
    Vector<Real> n{{0, 0, 0}};
    for (int i = 0; i < 3; ++i) {
      n = sumOf(n, sumOf(difference(from_.a[i], from_.b[i]), difference(to_.a[i], to_.b[i])));
    }
    return n;
  }

  // Tests one direction: apart at both ends, on the same side, means apart at all times, because
  // differences of projections are linear in time.
  DCM_HD bool areApartAlong(const Vector<Real>& n) const {
    const int order = from_.order(n);
    return order != 0 && to_.order(n) == order;
  }

  Recentred<Real, 3> from_, to_;
  Vector<Real> edge_a_[3], edge_b_[3];
};

// Decides for two triangles that share the vertex p; `a` and `b` are their other vertices. Returns
// true if a plane through p certainly has a and b strictly on its two sides at both ends of the
// interval. Moving with p, it then separates them at all times.
template <class Real>
DCM_HD inline bool areApartAround(const MovingPoint& p, const MovingPoint a[2],
                                  const MovingPoint b[2]) {
  const Vec3f from_a[2] = {a[0].from, a[1].from}, from_b[2] = {b[0].from, b[1].from};
  const Vec3f to_a[2] = {a[0].to, a[1].to}, to_b[2] = {b[0].to, b[1].to};
  const Recentred<Real, 2> from(p.from, from_a, from_b), to(p.to, to_a, to_b);
  Vector<Real> unit_a[2], unit_b[2];  // halfway through the interval
  for (int i = 0; i < 2; ++i) {
    unit_a[i] = sumOf(from.a[i], to.a[i]);
    unit_b[i] = sumOf(from.b[i], to.b[i]);
    const Real length_a = std::sqrt(dotOf(unit_a[i], unit_a[i]));
    const Real length_b = std::sqrt(dotOf(unit_b[i], unit_b[i]));
    for (int k = 0; k < 3; ++k) {
      unit_a[i].x[k] /= length_a;
      unit_b[i].x[k] /= length_b;
    }
  }
  // Tries the planes halfway between an edge of a and an edge of b, and the one between all four.
  for (int i = 0; i < 5; ++i) {
    Vector<Real> n;
    for (int k = 0; k < 3; ++k) {
      n.x[k] = i < 4 ? unit_b[i % 2].x[k] - unit_a[i / 2].x[k]
                     : unit_b[0].x[k] + unit_b[1].x[k] - unit_a[0].x[k] - unit_a[1].x[k];
    }
    const int sides = from.sidesOfCentre(n);
    if (sides != 0 && to.sidesOfCentre(n) == sides) return true;
  }
  return false;
}

}  // namespace deformable_contact_monitor
