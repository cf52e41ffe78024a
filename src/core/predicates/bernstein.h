// Cubics and quadratics on [0, 1] in Bernstein form, with a bound on the error of their
// coefficients: signs that are certain, and halving.
//
// A polynomial lies between the least and the greatest of its Bernstein coefficients, and its
// coefficients on half the interval are means of them (de Casteljau). Real is float or double.
#pragma once

#include "core/vector3.h"

namespace deformable_contact_monitor {

// What bounds errors in Real: half the distance of 1 to the next number, and what covers products
// that underflow. In double none does: terms are multiples of 2^-447 and at most 2^400.
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

// 1 or -1: certainly of that sign; 0: open. Infinite and NaN errors leave it open.
template <class Real>
DCM_HD inline int certainSign(Real value, Real error) {
  return (value > error) - (value < -error);
}

// kDegree + 1 coefficients, all off by at most `error`.
template <class Real, int kDegree>
struct Bernstein {
  Real c[kDegree + 1];
  Real error;

  // 1 or -1: certainly of that sign on the whole closed interval; 0: open.
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

  // What one halving adds to the error, at most, of this polynomial's part on any interval: each of
  // the degree's levels rounds sums, of numbers that are no larger than the largest coefficient.
  DCM_HD Real errorOfHalving() const {
    Real largest = 0;
    for (int i = 0; i <= kDegree; ++i) largest = most(largest, sizeOf(c[i]));
    return (kDegree + 1) * Rounding<Real>::kUnit * largest;
  }

  // Its two parts, one of which may be itself; `more` is errorOfHalving of what halving began with.
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
};

template <class Real>
using Cubic = Bernstein<Real, 3>;
template <class Real>
using Quadratic = Bernstein<Real, 2>;

}  // namespace deformable_contact_monitor
