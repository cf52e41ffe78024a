// Polynomials in one unknown with integer coefficients of any size.
#include "integer_polynomial.h"

#include <algorithm>
#include <utility>

namespace deformable_contact_monitor {
namespace {

// The coefficients divided by their greatest common divisor, which is positive.
IntegerPolynomial primitivePart(const IntegerPolynomial& p) {
  mpz_class content = 0;
  for (int i = 0; i <= p.degree() && content != 1; ++i) content = ::gcd(content, p[i]);
  if (content == 1) return p;
  std::vector<mpz_class> out;
  for (int i = 0; i <= p.degree(); ++i) out.push_back(p[i] / content);
  return IntegerPolynomial(std::move(out));
}

struct Division {
  IntegerPolynomial quotient, remainder;
};

// factor * p = quotient * q + remainder with some positive factor; the remainder's degree is less
// than q's, which is not zero.
Division divide(const IntegerPolynomial& p, const IntegerPolynomial& q) {
  Division out{IntegerPolynomial(), p};
  const mpz_class scale = abs(q[q.degree()]);
  while (out.remainder.degree() >= q.degree()) {
    const int shift = out.remainder.degree() - q.degree();
    std::vector<mpz_class> term(static_cast<std::size_t>(shift) + 1);
    term.back() = out.remainder[out.remainder.degree()] * sgn(q[q.degree()]);
    const IntegerPolynomial step(std::move(term)), factor({scale});
    out.quotient = out.quotient * factor + step;
    out.remainder = out.remainder * factor - step * q;
  }
  return out;
}

IntegerPolynomial negative(const IntegerPolynomial& p) { return IntegerPolynomial() - p; }

}  // namespace

mpq_class toRational(const DyadicRational& x) {
  mpz_class denominator = 1;
  denominator <<= x.exponent;
  mpq_class out(x.numerator, denominator);
  out.canonicalize();
  return out;
}

IntegerPolynomial::IntegerPolynomial(std::vector<mpz_class> coefficients)
    : coefficients_(std::move(coefficients)) {
  while (!coefficients_.empty() && coefficients_.back() == 0) coefficients_.pop_back();
}

int IntegerPolynomial::signAt(const DyadicRational& x) const {
  mpz_class sum = 0, scaled;  // Horner's rule for 2^(exponent * degree) times the value
  for (int i = degree(); i >= 0; --i) {
    sum *= x.numerator;
    scaled = (*this)[i];
    scaled <<= x.exponent * static_cast<unsigned long>(degree() - i);
    sum += scaled;
  }
  return sgn(sum);
}

bool IntegerPolynomial::hasOneSignFrom(const DyadicRational& low) const {
  std::vector<mpz_class> taylor = coefficients_;
  for (int i = 0; i <= degree(); ++i) {
    taylor[static_cast<std::size_t>(i)] <<= low.exponent * static_cast<unsigned long>(degree() - i);
  }
  for (std::size_t from = 0; from < taylor.size(); ++from) {
    for (std::size_t i = taylor.size() - 1; i > from; --i) {
      mpz_addmul(taylor[i - 1].get_mpz_t(), taylor[i].get_mpz_t(), low.numerator.get_mpz_t());
    }
  }
  mpz_class others = 0;
  for (std::size_t i = 1; i < taylor.size(); ++i) others += abs(taylor[i]);
  return !isZero() && abs(taylor[0]) > others;
}

IntegerPolynomial operator+(const IntegerPolynomial& p, const IntegerPolynomial& q) {
  std::vector<mpz_class> sum(static_cast<std::size_t>(std::max(p.degree(), q.degree()) + 1));
  for (int i = 0; i <= p.degree(); ++i) sum[static_cast<std::size_t>(i)] += p[i];
  for (int i = 0; i <= q.degree(); ++i) sum[static_cast<std::size_t>(i)] += q[i];
  return IntegerPolynomial(std::move(sum));
}

IntegerPolynomial operator-(const IntegerPolynomial& p, const IntegerPolynomial& q) {
  std::vector<mpz_class> sum(static_cast<std::size_t>(std::max(p.degree(), q.degree()) + 1));
  for (int i = 0; i <= p.degree(); ++i) sum[static_cast<std::size_t>(i)] += p[i];
  for (int i = 0; i <= q.degree(); ++i) sum[static_cast<std::size_t>(i)] -= q[i];
  return IntegerPolynomial(std::move(sum));
}

IntegerPolynomial operator*(const IntegerPolynomial& p, const IntegerPolynomial& q) {
  if (p.isZero() || q.isZero()) return {};
  std::vector<mpz_class> product(static_cast<std::size_t>(p.degree() + q.degree() + 1));
  for (int i = 0; i <= p.degree(); ++i) {
    for (int j = 0; j <= q.degree(); ++j) {
      mpz_class& sum = product[static_cast<std::size_t>(i + j)];
      mpz_addmul(sum.get_mpz_t(), p[i].get_mpz_t(), q[j].get_mpz_t());
    }
  }
  return IntegerPolynomial(std::move(product));
}

IntegerPolynomial derivative(const IntegerPolynomial& p) {
  std::vector<mpz_class> out;
  for (int i = 1; i <= p.degree(); ++i) out.push_back(i * p[i]);
  return IntegerPolynomial(std::move(out));
}

IntegerPolynomial gcd(IntegerPolynomial p, IntegerPolynomial q) {
  while (!q.isZero()) {
    IntegerPolynomial remainder = divide(p, q).remainder;
    p = std::move(q);
    q = primitivePart(remainder);
  }
  return primitivePart(p);
}

IntegerPolynomial squareFree(const IntegerPolynomial& p) {
  const IntegerPolynomial common = gcd(p, derivative(p));
  return primitivePart(common.degree() > 0 ? divide(p, common).quotient : p);
}

std::vector<IntegerPolynomial> sturmChain(const IntegerPolynomial& p) {
  std::vector<IntegerPolynomial> chain{p};
  for (IntegerPolynomial next = derivative(p); !next.isZero();) {
    chain.push_back(primitivePart(next));
    const std::size_t n = chain.size();
    next = negative(divide(chain[n - 2], chain[n - 1]).remainder);
  }
  return chain;
}

}  // namespace deformable_contact_monitor
