// Exact times in [0, 1]: roots of integer polynomials, isolated by Sturm's theorem.
#pragma once

#include <vector>

#include "integer_polynomial.h"

namespace deformable_contact_monitor {

// A dyadic number, or the only root of a polynomial within an open dyadic interval
// (k / 2^m, (k + 1) / 2^m). Its value never changes; the interval shrinks as questions need it.
class AlgebraicTime {
 public:
  explicit AlgebraicTime(DyadicRational value);
  // The only root of a polynomial without multiple roots in the open interval from `low` to
  // (numerator + 1) / 2^exponent. The polynomial may be 0 at the ends.
  AlgebraicTime(IntegerPolynomial polynomial, DyadicRational low);

  bool isDyadic() const { return polynomial_.isZero(); }
  // The interval's ends; both are the value where that is known to be dyadic.
  const DyadicRational& low() const { return low_; }
  DyadicRational high() const;

  // The sign of p at this time.
  int signOf(const IntegerPolynomial& p);

  // Halves the interval until it is at most 2^-exponent long.
  void refineTo(unsigned long exponent);

  // -1, 0, 1: before, equal, after.
  friend int compare(AlgebraicTime& a, AlgebraicTime& b);

 private:
  void halve();
  bool isRootOf(const IntegerPolynomial& p);

  IntegerPolynomial polynomial_;  // zero: the value is low_
  DyadicRational low_;
  int sign_after_low_ = 0;
};

// The distinct roots of p in [0, 1], ascending. p is not zero.
std::vector<AlgebraicTime> rootsInStep(const IntegerPolynomial& p);

// Some number strictly between a and b, where a is before b.
DyadicRational between(AlgebraicTime& a, AlgebraicTime& b);

}  // namespace deformable_contact_monitor
