// Polynomials with integer coefficients of degree 3 at most, their real roots in [0, 1], and exact
// signs of other such polynomials there. Host only; a root may not be used by two threads at once.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "core/predicates/growing_integer.h"

namespace deformable_contact_monitor {

struct Polynomial {
  int degree = -1;                  // of zero
  std::array<GrowingInteger, 4> c;  // c[i] of t^i; c[degree] is not zero

  static Polynomial linear(const GrowingInteger& at_zero, const GrowingInteger& slope);
  bool isZero() const { return degree < 0; }
};

// Of degree 3 at most.
Polynomial operator+(const Polynomial& p, const Polynomial& q);
Polynomial operator-(const Polynomial& p, const Polynomial& q);
Polynomial operator*(const Polynomial& p, const Polynomial& q);

// k / 2^m.
struct Dyadic {
  GrowingInteger k;
  int m = 0;
};

// -1, 0 or 1: a less than, equal to, or greater than b.
int compare(const Dyadic& a, const Dyadic& b);

// A number in [0, 1]: a dyadic one, or the only root of a polynomial in (k / 2^m, (k + 1) / 2^m),
// a simple one. Asking it narrows that interval.
class RealRoot {
 public:
  explicit RealRoot(Dyadic value) : low_(std::move(value)), exact_(true) {}
  RealRoot(const Polynomial& f, const Dyadic& low, int sign_after_low)
      : f_(f), low_(low), sign_after_low_(sign_after_low) {}

  // Sign of q here. Intervals of certain sign decide; where they have not by 2^-20, a common
  // divisor tells whether q vanishes here, and if not they do in the end.
  int signOf(const Polynomial& q);

  // Bounds that are multiples of 2^-24, at most 2^-20 apart; equal only if it is such a multiple.
  float floatLow();
  float floatHigh();

  // Whether a < b; -1, 0 or 1.
  static int compare(RealRoot& a, RealRoot& b);

  // A number strictly between two, a < b.
  static Dyadic numberBetween(RealRoot& a, RealRoot& b);

 private:
  Dyadic high() const;
  void refine();
  bool isRootOf(const Polynomial& q) const;

  Polynomial f_;
  Dyadic low_;
  bool exact_ = false;
  int sign_after_low_ = 0;
};

// All roots in [0, 1] of a polynomial that is not zero, each once; in any order.
std::vector<RealRoot> rootsInUnitInterval(const Polynomial& f);

}  // namespace deformable_contact_monitor
