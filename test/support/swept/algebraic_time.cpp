// Exact times in [0, 1]: roots of integer polynomials, isolated by Sturm's theorem.
#include "algebraic_time.h"

#include <algorithm>
#include <utility>

namespace deformable_contact_monitor {
namespace {

// At this length of its interval a root is asked whether it is a root of the other polynomial too.
constexpr unsigned long kAskForTie = 16;

DyadicRational next(const DyadicRational& low) { return {low.numerator + 1, low.exponent}; }

mpz_class numeratorAt(const DyadicRational& x, unsigned long exponent) {
  return x.numerator << (exponent - x.exponent);
}

int variations(const std::vector<IntegerPolynomial>& chain, const DyadicRational& x) {
  int count = 0, last = 0;
  for (const IntegerPolynomial& p : chain) {
    const int sign = p.signAt(x);
    if (sign == 0) continue;
    count += sign == -last;
    last = sign;
  }
  return count;
}

// Appends the roots of chain[0] in the half-open interval (low, low + 2^-exponent].
void appendRoots(const std::vector<IntegerPolynomial>& chain, const DyadicRational& low,
                 int before_low, int before_high, std::vector<AlgebraicTime>* out) {
  const DyadicRational high = next(low);
  const bool at_high = chain[0].signAt(high) == 0;
  const int inside = before_low - before_high - at_high;
  if (inside == 1) {
    out->emplace_back(chain[0], low);
  } else if (inside > 1) {
    const DyadicRational left{low.numerator * 2, low.exponent + 1}, right = next(left);
    const int before_middle = variations(chain, right);
    appendRoots(chain, left, before_low, before_middle, out);
    appendRoots(chain, right, before_middle, before_high, out);
    return;
  }
  if (at_high) out->emplace_back(high);
}

}  // namespace

AlgebraicTime::AlgebraicTime(DyadicRational value) : low_(std::move(value)) {}

AlgebraicTime::AlgebraicTime(IntegerPolynomial polynomial, DyadicRational low)
    : polynomial_(std::move(polynomial)), low_(std::move(low)) {
  const int sign = polynomial_.signAt(low_);
  sign_after_low_ = sign != 0 ? sign : derivative(polynomial_).signAt(low_);
}

DyadicRational AlgebraicTime::high() const { return isDyadic() ? low_ : next(low_); }

void AlgebraicTime::halve() {
  low_.numerator *= 2;
  ++low_.exponent;
  const DyadicRational middle = next(low_);
  const int sign = polynomial_.signAt(middle);
  if (sign == 0 || sign == sign_after_low_) low_ = middle;
  if (sign == 0) polynomial_ = IntegerPolynomial();
}

void AlgebraicTime::refineTo(unsigned long exponent) {
  while (!isDyadic() && low_.exponent < exponent) halve();
}

bool AlgebraicTime::isRootOf(const IntegerPolynomial& p) {
  while (!isDyadic() && (polynomial_.signAt(low_) == 0 || polynomial_.signAt(high()) == 0)) halve();
  if (isDyadic()) return p.signAt(low_) == 0;
  // The common divisor has simple roots, all of them roots of polynomial_, which has one inside.
  const IntegerPolynomial common = gcd(polynomial_, p);
  return common.signAt(low_) != common.signAt(high());
}

int AlgebraicTime::signOf(const IntegerPolynomial& p) {
  bool is_no_root = false;
  while (!isDyadic()) {
    if (p.isZero()) return 0;
    if (p.hasOneSignFrom(low_)) break;
    if (!is_no_root && low_.exponent >= kAskForTie) {
      if (isRootOf(p)) return 0;
      is_no_root = true;
    }
    if (!isDyadic()) halve();
  }
  return p.signAt(low_);
}

int compare(AlgebraicTime& a, AlgebraicTime& b) {
  bool differ = false;
  for (;;) {
    const unsigned long exponent = std::max(a.low_.exponent, b.low_.exponent);
    a.refineTo(exponent);
    b.refineTo(exponent);
    const mpz_class at_a = numeratorAt(a.low_, exponent), at_b = numeratorAt(b.low_, exponent);
    if (at_a != at_b) {
      // Open intervals begin after their low end, so that a dyadic number there is before them,
      // and one at their high end is after them.
      return at_a < at_b ? -1 : 1;
    }
    if (a.isDyadic() || b.isDyadic()) return b.isDyadic() - a.isDyadic();
    if (!differ && a.isRootOf(b.polynomial_)) return 0;
    differ = true;
    if (!a.isDyadic()) a.halve();
  }
}

std::vector<AlgebraicTime> rootsInStep(const IntegerPolynomial& p) {
  const DyadicRational zero{0, 0};
  if (p.hasOneSignFrom(zero)) return {};
  std::vector<IntegerPolynomial> chain = sturmChain(p);
  if (chain.back().degree() > 0) chain = sturmChain(squareFree(p));
  std::vector<AlgebraicTime> roots;
  if (chain[0].signAt(zero) == 0) roots.emplace_back(zero);
  appendRoots(chain, zero, variations(chain, zero), variations(chain, next(zero)), &roots);
  return roots;
}

DyadicRational between(AlgebraicTime& a, AlgebraicTime& b) {
  for (unsigned long exponent = std::max(a.low().exponent, b.low().exponent);; ++exponent) {
    a.refineTo(exponent);
    b.refineTo(exponent);
    const mpz_class from = numeratorAt(a.high(), exponent), to = numeratorAt(b.low(), exponent);
    // Roots within open intervals are no ends of them.
    if (from < to || (from == to && !a.isDyadic() && !b.isDyadic())) {
      return {from + to, exponent + 1};
    }
  }
}

}  // namespace deformable_contact_monitor
