// Polynomials in time, in Bernstein form, with a bound on the error of their coefficients; and the
// orientation determinants of moving points as such polynomials.
//
// A polynomial on [0, 1] lies between the least and the greatest of its Bernstein coefficients, so
// that its sign is certain if all coefficients have it. Its coefficients on half of the interval
// are means of them (de Casteljau's algorithm). Real is float or double; for what determinantsOf()
// takes it may also be a vector of floats.
//
// Error bounds, in units u of half an ulp: a difference of coordinates has 1 u; a term of a 3 x 3
// determinant has 3 u from differences, 3 u from products and from the difference of products, and
// 2 u from sums; sums of up to three determinants add 2 u. Together these are at most 10 u of the
// sum of the terms' sizes, and 12 u covers the terms of second order. A 2 x 2 determinant has 5 u,
// bounded by 6 u.
#pragma once

#include "core/predicates/swept_triangle.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// Constants that bound errors in Real: kUnit is half the distance from 1 to the next number;
// kProduct and kSum cover products that underflow. In double none does: terms are multiples of
// 2^-447 and at most 2^400.
template <class Real>
struct Rounding {
  static constexpr double kUnit = 1.0 / 9007199254740992;  // 2^-53
  static constexpr double kProduct = 0, kSum = 0;
};
template <>
struct Rounding<float> {
  static constexpr float kUnit = 1.0F / 16777216;  // 2^-24
  static constexpr float kProduct = 1e-37F, kSum = 1e-36F;
};

template <class Real>
DCM_HD inline Real sizeOf(Real x) {
  return most(x, -x);
}

// Returns 1 or -1 if the sign is certain, 0 if it is open. Infinite and NaN errors leave it open.
template <class Real>
DCM_HD inline int certainSign(Real value, Real error) {
  return (value > error) - (value < -error);
}

// A polynomial with kDegree + 1 Bernstein coefficients, each off by at most `error`.
template <class Real, int kDegree>
struct Bernstein {
  Real c[kDegree + 1];
  Real error;

  // Returns 1 or -1 if the polynomial certainly has that sign on the whole closed interval, 0 if it
  // is open.
  DCM_HD int sign() const {
    Real low = c[0], high = c[0];
    for (int i = 1; i <= kDegree; ++i) {
      low = least(low, c[i]);
      high = most(high, c[i]);
    }
    return (low > error) - (high < -error);
  }
  DCM_HD int signAtStart() const { return certainSign(c[0], error); }
  DCM_HD int signAtEnd() const { return certainSign(c[kDegree], error); }

  // Returns whether all coefficients are within the error, so that no part of the polynomial can
  // have a certain sign.
  DCM_HD bool isLost() const {
    bool lost = true;
    for (int i = 0; i <= kDegree; ++i) lost = lost && !(sizeOf(c[i]) > error);
    return lost;
  }

  // Returns what one halving adds to the error, at most, for the part of this polynomial on any
  // interval: each of the degree's levels rounds sums of numbers that are no larger than the
  // largest coefficient.
  DCM_HD Real errorOfHalving() const {
    Real largest = 0;
    for (int i = 0; i <= kDegree; ++i) largest = most(largest, sizeOf(c[i]));
    return (kDegree + 1) * Rounding<Real>::kUnit * largest;
  }

  // Computes the polynomials on both halves; `left` or `right` may be this object. `more` is
  // errorOfHalving() of the polynomial that halving began with.
  DCM_HD void halve(Real more, Bernstein& left, Bernstein& right) const {
    Real row[kDegree + 1];
    for (int i = 0; i <= kDegree; ++i) row[i] = c[i];
    const Real larger_error = error + more;
    for (int level = 0; level <= kDegree; ++level) {
      left.c[level] = row[0];
      right.c[kDegree - level] = row[kDegree - level];
      for (int i = 0; i < kDegree - level; ++i) row[i] = (row[i] + row[i + 1]) * Real(0.5);
    }
    left.error = right.error = larger_error;
  }

  // Computes the polynomial on [from, to], by de Casteljau's algorithm with other weights than
  // halves. These weights and 1 minus them must be exact in Real. Rounding adds at most twice what
  // a halving adds.
  DCM_HD void restrict(Real from, Real to, Real more, Bernstein& part) const {
    Real row[kDegree + 1];
    for (int i = 0; i <= kDegree; ++i) row[i] = c[i];
    for (int i = kDegree; i >= 0; --i) {
      Real rest[kDegree + 1];
      // More than are needed, because g++ 9 believes otherwise that some are read uninitialised.
      for (int j = 0; j <= kDegree; ++j) rest[j] = row[j];
      for (int level = i; level > 0; --level) {
        for (int j = 0; j < level; ++j) rest[j] = (1 - to) * rest[j] + to * rest[j + 1];
      }
      part.c[i] = rest[0];
      for (int j = 0; j < i; ++j) row[j] = (1 - from) * row[j] + from * row[j + 1];
    }
    part.error = error + 2 * more;
  }
};

template <class Real>
using Cubic = Bernstein<Real, 3>;
template <class Real>
using Quadratic = Bernstein<Real, 2>;

template <class Real>
struct Vector {
  Real x[3];
};

// b - a.
template <class Real>
DCM_HD inline Vector<Real> between(const Vec3f& a, const Vec3f& b) {
  return {{static_cast<Real>(b.x) - static_cast<Real>(a.x),
           static_cast<Real>(b.y) - static_cast<Real>(a.y),
           static_cast<Real>(b.z) - static_cast<Real>(a.z)}};
}

template <class Real>
DCM_HD inline Vector<Real> crossOf(const Vector<Real>& u, const Vector<Real>& v) {
  return {{u.x[1] * v.x[2] - u.x[2] * v.x[1], u.x[2] * v.x[0] - u.x[0] * v.x[2],
           u.x[0] * v.x[1] - u.x[1] * v.x[0]}};
}

// Returns the sum of two vectors. As a direction it is where they are halfway.
template <class Real>
DCM_HD inline Vector<Real> sumOf(const Vector<Real>& u, const Vector<Real>& v) {
  return {{u.x[0] + v.x[0], u.x[1] + v.x[1], u.x[2] + v.x[2]}};
}

// The difference of two moving points, at both ends of the time interval.
template <class Real>
struct MovingVector {
  Vector<Real> from, to;

  DCM_HD MovingVector(const Vector<Real>& at_start, const Vector<Real>& at_end)
      : from(at_start), to(at_end) {}
  DCM_HD MovingVector(const MovingPoint& a, const MovingPoint& b)
      : from(between<Real>(a.from, b.from)), to(between<Real>(a.to, b.to)) {}
};

// The cross product n of two moving vectors, which is quadratic in time: n(0), twice its middle
// Bernstein coefficient, n(1), and the sums of the sizes of their terms.
template <class Real>
struct MovingNormal {
  Vector<Real> n[3], size[3];

  DCM_HD MovingNormal(const MovingVector<Real>& u, const MovingVector<Real>& v) {
    for (int k = 0; k < 3; ++k) {
      const int i = k == 2 ? 0 : k + 1, j = k == 0 ? 2 : k - 1;
      const Real a = u.from.x[i] * v.from.x[j], b = u.from.x[j] * v.from.x[i];
      const Real c = u.from.x[i] * v.to.x[j], d = u.from.x[j] * v.to.x[i];
      const Real e = u.to.x[i] * v.from.x[j], f = u.to.x[j] * v.from.x[i];
      const Real g = u.to.x[i] * v.to.x[j], h = u.to.x[j] * v.to.x[i];
      n[0].x[k] = a - b;
      n[1].x[k] = (c - d) + (e - f);
      n[2].x[k] = g - h;
      constexpr auto kTiny = Rounding<Real>::kProduct;
      size[0].x[k] = sizeOf(a) + sizeOf(b) + kTiny;
      size[1].x[k] = (sizeOf(c) + sizeOf(d)) + (sizeOf(e) + sizeOf(f)) + kTiny;
      size[2].x[k] = sizeOf(g) + sizeOf(h) + kTiny;
    }
  }

  // Returns four times n(1/2).
  DCM_HD Vector<Real> middle() const {
    Vector<Real> m;
    for (int k = 0; k < 3; ++k) m.x[k] = n[0].x[k] + n[1].x[k] + n[2].x[k];
    return m;
  }
};

// Returns the coordinate axis along which a vector is longest.
template <class Real>
DCM_HD inline int longestAxis(const Vector<Real>& v) {
  const Real x = sizeOf(v.x[0]), y = sizeOf(v.x[1]), z = sizeOf(v.x[2]);
  return x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
}

template <class Real>
DCM_HD inline Real dotOf(const Vector<Real>& a, const Vector<Real>& b) {
  return a.x[0] * b.x[0] + a.x[1] * b.x[1] + a.x[2] * b.x[2];
}

template <class Real>
DCM_HD inline Real sizeOfDot(const Vector<Real>& size, const Vector<Real>& w) {
  return size.x[0] * sizeOf(w.x[0]) + size.x[1] * sizeOf(w.x[1]) + size.x[2] * sizeOf(w.x[2]);
}

// Returns the greatest of four numbers, or NaN if one of them is infinite or NaN: then nothing is
// certain.
template <class Real>
DCM_HD inline Real greatest(Real a, Real b, Real c, Real d) {
  const Real m = most(most(a, b), most(c, d));
  return Rounding<Real>::kSum > 0 ? m + (a + b + c + d) * 0 : m;
}

// Computes three times the determinant [u v w], where n = u x v, without its error.
template <class Real>
DCM_HD inline void setDeterminant(const MovingNormal<Real>& n, const MovingVector<Real>& w,
                                  Cubic<Real>& d) {
  d.c[0] = 3 * dotOf(n.n[0], w.from);
  d.c[1] = dotOf(n.n[1], w.from) + dotOf(n.n[0], w.to);
  d.c[2] = dotOf(n.n[1], w.to) + dotOf(n.n[2], w.from);
  d.c[3] = 3 * dotOf(n.n[2], w.to);
}

template <class Real>
DCM_HD inline Cubic<Real> determinantOf(const MovingNormal<Real>& n, const MovingVector<Real>& w) {
  Cubic<Real> d;
  setDeterminant(n, w, d);
  const Real s0 = 3 * sizeOfDot(n.size[0], w.from), s3 = 3 * sizeOfDot(n.size[2], w.to);
  const Real s1 = sizeOfDot(n.size[1], w.from) + sizeOfDot(n.size[0], w.to);
  const Real s2 = sizeOfDot(n.size[1], w.to) + sizeOfDot(n.size[2], w.from);
  d.error = 12 * Rounding<Real>::kUnit * greatest(s0, s1, s2, s3) + Rounding<Real>::kSum;
  return d;
}

// Computes the determinants for three vectors w, with one error for them all, from their largest
// components.
template <class Real>
DCM_HD inline void determinantsOf(const MovingNormal<Real>& n, const MovingVector<Real> (&w)[3],
                                  Cubic<Real> (&d)[3]) {
  Real size{};
  for (int k = 0; k < 3; ++k) {
    const Real reach_from =
        greatest(sizeOf(w[0].from.x[k]), sizeOf(w[1].from.x[k]), sizeOf(w[2].from.x[k]), Real{});
    const Real reach_to =
        greatest(sizeOf(w[0].to.x[k]), sizeOf(w[1].to.x[k]), sizeOf(w[2].to.x[k]), Real{});
    size += greatest(n.size[0].x[k], n.size[1].x[k], n.size[2].x[k], Real{}) *
            greatest(reach_from, reach_to, Real{}, Real{});
  }
  for (int i = 0; i < 3; ++i) {
    setDeterminant(n, w[i], d[i]);
    d[i].error = 12 * Rounding<Real>::kUnit * (3 * size) + Rounding<Real>::kSum;
  }
}

// Returns v.x[axis]. On a device it needs no array in memory.
template <class Real>
DCM_HD inline Real coordinate(const Vector<Real>& v, int axis) {
#ifdef __CUDA_ARCH__
  return axis == 0 ? v.x[0] : axis == 1 ? v.x[1] : v.x[2];
#else
  return v.x[axis];
#endif
}

// Returns twice the determinant of the projections of u and v along `axis`.
template <class Real>
DCM_HD inline Quadratic<Real> projectedDeterminant(const MovingVector<Real>& u,
                                                   const MovingVector<Real>& v, int axis) {
  const int i = axis == 2 ? 0 : axis + 1, j = axis == 0 ? 2 : axis - 1;
  const Real u0i = coordinate(u.from, i), u0j = coordinate(u.from, j);
  const Real u1i = coordinate(u.to, i), u1j = coordinate(u.to, j);
  const Real v0i = coordinate(v.from, i), v0j = coordinate(v.from, j);
  const Real v1i = coordinate(v.to, i), v1j = coordinate(v.to, j);
  const Real a = u0i * v0j, b = u0j * v0i, c = u0i * v1j, d = u0j * v1i;
  const Real e = u1i * v0j, f = u1j * v0i, g = u1i * v1j, h = u1j * v1i;
  Quadratic<Real> q;
  q.c[0] = 2 * (a - b);
  q.c[1] = (c - d) + (e - f);
  q.c[2] = 2 * (g - h);
  const Real s0 = 2 * (sizeOf(a) + sizeOf(b)), s2 = 2 * (sizeOf(g) + sizeOf(h));
  const Real s1 = (sizeOf(c) + sizeOf(d)) + (sizeOf(e) + sizeOf(f));
  q.error = 6 * Rounding<Real>::kUnit * greatest(s0, s1, s2, Real{}) + Rounding<Real>::kSum;
  return q;
}

}  // namespace deformable_contact_monitor
