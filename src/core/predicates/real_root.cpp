#include "core/predicates/real_root.h"

#include <algorithm>
#include <cmath>

namespace deformable_contact_monitor {
namespace {

constexpr int kTimeHalvings = 21;  // an interval of 2^-21, rounded outwards to 2^-24
constexpr int kTieHalvings = 8;    // a sign that is open by then is nearly always zero

Polynomial trimmed(Polynomial p) {
  while (p.degree >= 0 && p.c[p.degree].sign() == 0) --p.degree;
  return p;
}

// Returns 2^(m degree) f((k + s) / 2^m), a polynomial in s.
Polynomial onInterval(const Polynomial& f, const Dyadic& low) {
  Polynomial g = f;
  for (int i = 0; i < f.degree; ++i) g.c[i] = f.c[i] << low.m * (f.degree - i);
  for (int i = 0; i < f.degree; ++i) {
    for (int j = f.degree - 1; j >= i; --j) g.c[j] = g.c[j] + low.k * g.c[j + 1];
  }
  return g;
}

// Returns the sign of f at t.
int signAt(const Polynomial& f, const Dyadic& t) {
  if (f.isZero()) return 0;
  GrowingInteger value = f.c[f.degree];
  for (int i = f.degree - 1; i >= 0; --i) {
    value = value * t.k + (f.c[i] << t.m * (f.degree - i));
  }
  return value.sign();
}

// The signs of the Bernstein coefficients of f on [k / 2^m, (k + 1) / 2^m]. The number of sign
// changes bounds the number of roots there (Descartes' rule of signs).
struct BernsteinSigns {
  int variations = 0, first = 0;
  bool plus = false, minus = false;

  BernsteinSigns(const Polynomial& f, const Dyadic& low) {
    static constexpr int kTimes[4][4][4] = {
        {{1}}, {{1}, {1, 1}}, {{1}, {2, 1}, {1, 1, 1}}, {{1}, {3, 1}, {3, 2, 1}, {1, 1, 1, 1}}};
    const Polynomial g = onInterval(f, low);
    int last = 0;
    for (int i = 0; i <= f.degree; ++i) {
      GrowingInteger sum;
      for (int j = 0; j <= i; ++j) sum = sum + GrowingInteger(kTimes[f.degree][i][j]) * g.c[j];
      const int sign = sum.sign();
      if (sign == 0) continue;
      if (first == 0) first = sign;
      variations += last == -sign ? 1 : 0;
      last = sign;
      (sign > 0 ? plus : minus) = true;
    }
  }
};

// Returns a multiple of the remainder of f divided by g, which is not zero.
Polynomial pseudoRemainder(Polynomial f, const Polynomial& g) {
  while (f.degree >= g.degree) {
    const GrowingInteger lead = f.c[f.degree];
    const int shift = f.degree - g.degree;
    for (int i = 0; i <= f.degree; ++i) f.c[i] = f.c[i] * g.c[g.degree];
    for (int i = 0; i <= g.degree; ++i) f.c[i + shift] = f.c[i + shift] - lead * g.c[i];
    f = trimmed(f);
  }
  return f;
}

// Returns the greatest common divisor by Euclid's algorithm.
Polynomial commonDivisor(Polynomial f, Polynomial g) {
  while (!g.isZero()) {
    Polynomial rest = pseudoRemainder(std::move(f), g);
    f = std::move(g);
    g = std::move(rest);
  }
  return f;
}

Polynomial derivative(const Polynomial& f) {
  Polynomial d;
  d.degree = f.degree - 1;
  for (int i = 1; i <= f.degree; ++i) d.c[i - 1] = GrowingInteger(i) * f.c[i];
  return d;
}

// Returns polynomials with simple roots only that together have the roots of f. A multiple root is
// rational, and then the third root is rational too.
std::vector<Polynomial> simpleParts(const Polynomial& f) {
  const Polynomial g = commonDivisor(f, derivative(f));
  if (g.degree < 1) return {f};
  if (g.degree == 2) return {Polynomial::linear(f.c[2], GrowingInteger(3) * f.c[3])};
  if (f.degree == 2) return {g};
  return {g, Polynomial::linear(f.c[2] * g.c[1] - GrowingInteger(2) * f.c[3] * g.c[0],
                                f.c[3] * g.c[1])};
}

// Adds the roots of f in the open interval (0, 1); all of them must be simple. It halves intervals
// until each has one sign change, hence one root, or none.
void addSimpleRoots(const Polynomial& f, std::vector<RealRoot>& roots) {
  std::vector<Dyadic> intervals = {Dyadic{}};
  while (!intervals.empty()) {
    const Dyadic low = intervals.back();
    intervals.pop_back();
    const BernsteinSigns signs(f, low);
    if (signs.variations == 0) continue;
    if (signs.variations == 1) {
      roots.emplace_back(f, low, signs.first);
      continue;
    }
    const Dyadic left{low.k << 1, low.m + 1}, middle{left.k + 1, left.m};
    if (signAt(f, middle) == 0) roots.emplace_back(middle);
    intervals.push_back(left);
    intervals.push_back(middle);
  }
}

// Returns floor(2^24 t).
std::int64_t in24Bits(const Dyadic& t) {
  return static_cast<std::int64_t>(t.m <= 24 ? t.k << (24 - t.m) : t.k >> (t.m - 24));
}

float from24Bits(std::int64_t value) { return std::ldexp(static_cast<float>(value), -24); }

}  // namespace

Polynomial Polynomial::linear(const GrowingInteger& at_zero, const GrowingInteger& slope) {
  Polynomial p;
  p.degree = 1;
  p.c[0] = at_zero;
  p.c[1] = slope;
  return trimmed(p);
}

Polynomial operator+(const Polynomial& p, const Polynomial& q) {
  Polynomial sum;
  sum.degree = std::max(p.degree, q.degree);
  for (int i = 0; i <= sum.degree; ++i) {
    if (i <= p.degree) sum.c[i] = p.c[i];
    if (i <= q.degree) sum.c[i] = sum.c[i] + q.c[i];
  }
  return trimmed(sum);
}

Polynomial operator-(const Polynomial& p, const Polynomial& q) {
  Polynomial negative = q;
  for (int i = 0; i <= q.degree; ++i) negative.c[i] = -q.c[i];
  return p + negative;
}

Polynomial operator*(const Polynomial& p, const Polynomial& q) {
  Polynomial product;
  if (p.isZero() || q.isZero()) return product;
  product.degree = p.degree + q.degree;
  for (int i = 0; i <= p.degree; ++i) {
    for (int j = 0; j <= q.degree; ++j) {
      product.c[i + j] = product.c[i + j] + p.c[i] * q.c[j];
    }
  }
  return product;
}

int compare(const Dyadic& a, const Dyadic& b) {
  const int m = std::max(a.m, b.m);
  return ((a.k << (m - a.m)) - (b.k << (m - b.m))).sign();
}

Dyadic RealRoot::high() const { return exact_ ? low_ : Dyadic{low_.k + 1, low_.m}; }

void RealRoot::refine() {
  if (exact_) return;
  const Dyadic left{low_.k << 1, low_.m + 1}, middle{left.k + 1, left.m};
  const int sign = signAt(f_, middle);
  exact_ = sign == 0;
  low_ = sign == 0 || sign == sign_after_low_ ? middle : left;
}

// A common divisor has no other root in the interval than this one, and a simple one.
bool RealRoot::isRootOf(const Polynomial& q) const {
  const Polynomial g = commonDivisor(f_, q);
  return g.degree > 0 && BernsteinSigns(g, low_).variations % 2 == 1;
}

int RealRoot::signOf(const Polynomial& q) {
  if (q.isZero()) return 0;
  for (bool tested = false;; refine()) {
    if (exact_) return signAt(q, low_);
    const BernsteinSigns signs(q, low_);
    if (signs.plus != signs.minus) return signs.plus ? 1 : -1;
    if (!tested && low_.m >= kTieHalvings) {
      if (isRootOf(q)) return 0;
      tested = true;
    }
  }
}

float RealRoot::floatLow() {
  while (!exact_ && low_.m < kTimeHalvings) refine();
  return from24Bits(in24Bits(low_));
}

float RealRoot::floatHigh() {
  const float low = floatLow();
  if (exact_ && low_.m <= 24) return low;
  return from24Bits(low_.m <= 24 ? in24Bits(high()) : in24Bits(low_) + 1);
}

int RealRoot::compare(RealRoot& a, RealRoot& b) {
  using deformable_contact_monitor::compare;
  for (bool tested = false, equal = false;;) {
    if (a.exact_ && b.exact_) return compare(a.low_, b.low_);
    if (compare(a.high(), b.low_) <= 0) return -1;
    if (compare(b.high(), a.low_) <= 0) return 1;
    if (equal && !b.exact_ && compare(a.low_, b.low_) >= 0 && compare(a.high(), b.high()) <= 0) {
      return 0;  // a root of b's polynomial where b is the only one
    }
    if (!tested && (a.exact_ || a.low_.m >= kTieHalvings) &&
        (b.exact_ || b.low_.m >= kTieHalvings)) {
      tested = true;
      equal = b.exact_ ? signAt(a.f_, b.low_) == 0 : a.signOf(b.f_) == 0;
      if (b.exact_ && equal) return 0;
    }
    RealRoot& wider = b.exact_ || (!a.exact_ && a.low_.m <= b.low_.m) ? a : b;
    wider.refine();
  }
}

Dyadic RealRoot::numberBetween(RealRoot& a, RealRoot& b) {
  using deformable_contact_monitor::compare;
  for (;;) {
    if (a.exact_ && b.exact_) {
      const int m = std::max(a.low_.m, b.low_.m);
      return {(a.low_.k << (m - a.low_.m)) + (b.low_.k << (m - b.low_.m)), m + 1};
    }
    if (!a.exact_) {
      const int order = compare(a.high(), b.low_);
      if (order < 0 || (order == 0 && !b.exact_)) return a.high();
      a.refine();
    } else {
      if (compare(a.low_, b.low_) < 0) return b.low_;
      b.refine();
    }
  }
}

std::vector<RealRoot> rootsInUnitInterval(const Polynomial& f) {
  std::vector<RealRoot> roots;
  if (f.degree < 1) return roots;
  const Dyadic zero{0, 0}, one{1, 0};
  if (signAt(f, zero) == 0) roots.emplace_back(zero);
  if (signAt(f, one) == 0) roots.emplace_back(one);
  if (BernsteinSigns(f, zero).variations == 0) return roots;
  for (const Polynomial& part : simpleParts(f)) addSimpleRoots(part, roots);
  return roots;
}

}  // namespace deformable_contact_monitor
