// Polynomials with integer coefficients, of degree 3 at most: their real roots in [0, 1], and exact
// signs of other such polynomials at a root.
//
// A root that is not a dyadic number is kept as an interval that contains it alone, and is narrowed
// on demand. Host only. A root must not be used by two threads at once.
#pragma once

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cstdint>
#include <utility>
#include <vector>

namespace deformable_contact_monitor {

// Holds an integer of any size. Values of at most 512 bits need no memory beside it.
using GrowingInteger = boost::multiprecision::number<boost::multiprecision::cpp_int_backend<512>,
                                                     boost::multiprecision::et_off>;

struct Polynomial {
  int degree = -1;                  // the degree of zero
  std::array<GrowingInteger, 4> c;  // c[i] of t^i; c[degree] is not zero

  static Polynomial linear(const GrowingInteger& at_zero, const GrowingInteger& slope);
  bool isZero() const { return degree < 0; }
};

// Sum, difference and product; the result must be of degree 3 at most.
Polynomial operator+(const Polynomial& p, const Polynomial& q);
Polynomial operator-(const Polynomial& p, const Polynomial& q);
Polynomial operator*(const Polynomial& p, const Polynomial& q);

// The number k / 2^m.
struct Dyadic {
  GrowingInteger k;
  int m = 0;
};

// Returns -1, 0 or 1: a is less than, equal to, or greater than b.
int compare(const Dyadic& a, const Dyadic& b);

// A number in [0, 1]: a dyadic one, or the only root, a simple one, of a polynomial in (k / 2^m, (k
// + 1) / 2^m). Queries may narrow that interval.
class RealRoot {
 public:
  explicit RealRoot(Dyadic value) : low_(std::move(value)), exact_(true) {}
  RealRoot(const Polynomial& f, const Dyadic& low, int sign_after_low)
      : f_(f), low_(low), sign_after_low_(sign_after_low) {}

  // Returns the sign of q at this number. Intervals on which the sign of q is certain decide first.
  // If they have not decided at a width of 2^-20, a common divisor tells whether q vanishes here;
  // if it does not, narrower intervals will decide.
  int signOf(const Polynomial& q);

  // Bounds of the number: multiples of 2^-24, at most 2^-20 apart. They are equal only if the
  // number is such a multiple.
  float floatLow();
  float floatHigh();

  // Returns -1, 0 or 1: a is less than, equal to, or greater than b.
  static int compare(RealRoot& a, RealRoot& b);

  // Returns a number strictly between a and b, where a < b.
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

// Returns all roots in [0, 1] of a polynomial that is not zero, each once, in any order.
std::vector<RealRoot> rootsInUnitInterval(const Polynomial& f);

}  // namespace deformable_contact_monitor
