// Polynomials in one unknown with integer coefficients of any size.
#pragma once

#include <gmpxx.h>

#include <vector>

namespace deformable_contact_monitor {

// numerator / 2^exponent.
struct DyadicRational {
  mpz_class numerator;
  unsigned long exponent = 0;
};

mpq_class toRational(const DyadicRational& x);

class IntegerPolynomial {
 public:
  IntegerPolynomial() = default;  // zero
  // The constant term first; leading zeros are dropped.
  explicit IntegerPolynomial(std::vector<mpz_class> coefficients);

  bool isZero() const { return coefficients_.empty(); }
  int degree() const { return static_cast<int>(coefficients_.size()) - 1; }  // of zero: -1
  const mpz_class& operator[](int i) const { return coefficients_[static_cast<std::size_t>(i)]; }

  int signAt(const DyadicRational& x) const;

  // Returns true only if the sign at (k + x) / 2^exponent is the same, and not 0, for all x from 0
  // to 1; k is the numerator of `low`. It compares the absolute values of the Taylor coefficients.
  // It returns true for every small enough interval without a root.
  bool hasOneSignFrom(const DyadicRational& low) const;

 private:
  std::vector<mpz_class> coefficients_;
};

IntegerPolynomial operator+(const IntegerPolynomial& p, const IntegerPolynomial& q);
IntegerPolynomial operator-(const IntegerPolynomial& p, const IntegerPolynomial& q);
IntegerPolynomial operator*(const IntegerPolynomial& p, const IntegerPolynomial& q);

IntegerPolynomial derivative(const IntegerPolynomial& p);

// The greatest common divisor over the rationals, with integer coefficients that share no factor;
// its sign is arbitrary. p is not zero.
IntegerPolynomial gcd(IntegerPolynomial p, IntegerPolynomial q);

// A polynomial with the roots of p, each once, and no others. p is not zero.
IntegerPolynomial squareFree(const IntegerPolynomial& p);

// p, its derivative, and remainders with their signs changed: Sturm's chain up to positive factors.
// The last is a greatest common divisor of p and its derivative: constant iff p, which is not zero,
// has no multiple roots.
std::vector<IntegerPolynomial> sturmChain(const IntegerPolynomial& p);

}  // namespace deformable_contact_monitor
