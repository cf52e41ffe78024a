// The oracle of swept contacts against the static ones, at many rational times of small integer
// pairs. $DCM_FUZZ_PAIRS says how many pairs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "cgal_oracle.h"
#include "exact_triangles.h"
#include "swept/random_swept_pairs.h"
#include "swept/swept_oracle.h"

namespace deformable_contact_monitor {
namespace {

using exact::Corners;
using exact::Point;
using exact::Rational;

int wantedPairs() {
  const char* wanted = std::getenv("DCM_FUZZ_PAIRS");
  return wanted != nullptr ? std::stoi(wanted) : 3000;
}

// By the static oracle, at numerator / denominator.
bool meetAt(const SweptPair& p, bool one_body, int numerator, int denominator) {
  const Triangle a = at(p.a0, p.a1, numerator, denominator);
  const Triangle b = at(p.b0, p.b1, numerator, denominator);
  return meetBeyondByPredicates(
      {a.v[0], a.v[1], a.v[2]}, {b.v[0], b.v[1], b.v[2]},
      one_body ? sharedAt(p, numerator, denominator) : std::vector<Vec3f>());
}

// The rational number in [low, high] with the least denominator.
mpq_class simplestIn(const mpq_class& low, const mpq_class& high) {
  const mpz_class floor = low.get_num() / low.get_den();
  if (floor == low) return low;
  if (floor + 1 <= high) return floor + 1;
  return floor + 1 / simplestIn(1 / (high - floor), 1 / (low - floor));
}

Rational toCgal(const mpz_class& n) {
  constexpr int kBits = 30;
  if (abs(n) < (1 << kBits)) return static_cast<int>(n.get_si());
  return toCgal(n >> kBits) * (1 << kBits) + toCgal(n & ((1 << kBits) - 1));
}

Rational toCgal(const mpq_class& t) { return toCgal(t.get_num()) / toCgal(t.get_den()); }

Point between(const Vec3f& start, const Vec3f& end, const Rational& t) {
  const Point p = exact::toPoint(start), q = exact::toPoint(end);
  return p + (q - p) * t;
}

Corners corners(const Triangle& state0, const Triangle& state1, const Rational& t) {
  return {between(state0.v[0], state1.v[0], t), between(state0.v[1], state1.v[1], t),
          between(state0.v[2], state1.v[2], t)};
}

// A pair at one time, by construction.
struct Frozen {
  Frozen(const SweptPair& p, bool one_body, const Rational& t)
      : a(corners(p.a0, p.a1, t)), b(corners(p.b0, p.b1, t)) {
    for (int i = 0; one_body && i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        if (p.a0.v[i] != p.b0.v[j] || p.a1.v[i] != p.b1.v[j]) continue;
        shared.push_back(a[i]);
        of_a[i] = of_b[j] = true;
      }
    }
  }

  bool meet() const {
    std::vector<Point> distinct;
    for (const Point& p : shared) {
      if (std::find(distinct.begin(), distinct.end(), p) == distinct.end()) distinct.push_back(p);
    }
    return exact::meetBeyond(a, b, distinct);
  }

  Corners a, b;
  std::vector<Point> shared;
  bool of_a[3] = {}, of_b[3] = {};
};

// A triangle without its shared corners: the hull of the others.
Corners rest(const Corners& t, const bool shared[3]) {
  Corners out = t;
  for (int i = 0; i < 3; ++i) {
    for (int k = 1; k < 3 && shared[i]; ++k) {
      if (!shared[(i + k) % 3]) out[i] = t[(i + k) % 3];
    }
  }
  return out;
}

bool areNear(const Corners& a, const Corners& b) {
  // 2^-30 of the step, at 32 units a step at most.
  return exact::meetBeyond(a, b, {}) || exact::squaredDistance(a, b) < Rational(1e-14);
}

// Returns whether two triangles on one edge point the same way from it, up to an angle of 2^-30.
bool areFolded(const Frozen& f) {
  const exact::Vector along = f.shared[1] - f.shared[0];
  const exact::Vector a = CGAL::cross_product(along, rest(f.a, f.of_a)[0] - f.shared[0]);
  const exact::Vector b = CGAL::cross_product(along, rest(f.b, f.of_b)[0] - f.shared[0]);
  return a * b >= 0 && CGAL::cross_product(a, b).squared_length() < Rational(1e-8);
}

// Returns a condition that must hold near a time that is no rational number. It also holds for
// pairs that come that near and do not meet.
bool almostMeet(const Frozen& f) {
  if (f.shared.empty()) return areNear(f.a, f.b);
  if (f.shared.size() == 2) return areFolded(f);
  return areNear(rest(f.a, f.of_a), f.b) || areNear(f.a, rest(f.b, f.of_b));
}

struct Figures {
  int pairs = 0, contacts = 0, confirmed = 0, right_after = 0, almost = 0, infima = 0, sampled = 0;
};

// Nothing sampled is missed, or earlier than the first time.
void sample(const SweptPair& p, bool one_body, const std::optional<SweptTime>& first,
            Figures* figures) {
  for (const int denominator : {1, 2, 3, 5, 7, 12, 16}) {
    for (int numerator = 0; numerator <= denominator; ++numerator) {
      if (!meetAt(p, one_body, numerator, denominator)) continue;
      ++figures->sampled;
      const mpq_class time(numerator, denominator);
      ASSERT_TRUE(first) << "meets at " << time.get_str();
      ASSERT_LE(first->low, mpq_class(time)) << "meets at " << time.get_str();
    }
  }
}

// They do not meet right before the first time, but at it or right after it.
void confirm(const SweptPair& p, bool one_body, const SweptTime& first, Figures* figures) {
  const mpq_class width(1, 1 << 30);
  ASSERT_LE(first.high - first.low, width);
  ASSERT_TRUE(0 <= first.low && first.high <= 1);
  const mpq_class before = first.low < first.high ? first.low : mpq_class(first.low - width);
  EXPECT_TRUE(before < 0 || !Frozen(p, one_body, toCgal(before)).meet());
  // An infimum by a time after it; else its only candidate for a rational number with a denominator
  // below 2^15, then the interval's end, by which they have met for a while, as a rule.
  const mpq_class simplest = simplestIn(first.low, first.high);
  const Frozen at_simplest(p, one_body, toCgal(simplest));
  const Frozen after(p, one_body, toCgal(std::min<mpq_class>(1, first.high + width)));
  if (first.is_attained ? at_simplest.meet() : after.meet()) {
    ++figures->confirmed;
    figures->infima += !first.is_attained;
    // An infimum that is known exactly is none of the times.
    EXPECT_TRUE(first.is_attained || first.low < first.high || !at_simplest.meet());
    return;
  }
  ASSERT_LT(first.low, first.high);
  const bool meet_after = after.meet();
  ++(meet_after ? figures->right_after : figures->almost);
  ASSERT_TRUE(meet_after || almostMeet(after));
}

TEST(SweptOracle, IsTheStaticOracleAtRationalTimes) {
  std::mt19937 generator(21);
  Figures figures;
  const int pairs = wantedPairs();
  for (; figures.pairs < pairs && !::testing::Test::HasFatalFailure(); ++figures.pairs) {
    SCOPED_TRACE("pair " + std::to_string(figures.pairs));
    const SweptPair p = randomSweptPair(generator);
    const bool one_body = figures.pairs % 2 == 0;
    const auto beyond = AdjacentPairs::kBeyondShared;
    const std::optional<SweptTime> first = one_body
                                               ? firstSweptContact(p.a0, p.a1, p.b0, p.b1, beyond)
                                               : firstSweptContact(p.a0, p.a1, p.b0, p.b1);
    ASSERT_EQ(first.has_value(), one_body ? sweptContact(p.a0, p.a1, p.b0, p.b1, beyond)
                                          : sweptContact(p.a0, p.a1, p.b0, p.b1));
    sample(p, one_body, first, &figures);
    if (!first) continue;
    ++figures.contacts;
    ASSERT_TRUE(first->is_attained || one_body);
    confirm(p, one_body, *first, &figures);
  }
  std::cout << figures.contacts << " contacts of " << figures.pairs
            << " pairs: " << figures.confirmed << " confirmed at a rational time ("
            << figures.infima << " infima), " << figures.right_after << " right after their time, "
            << figures.almost << " all but; " << figures.sampled << " sampled\n";
  EXPECT_GT(figures.confirmed, figures.pairs / 4);
  EXPECT_GT(figures.right_after, figures.pairs / 100);
}

}  // namespace
}  // namespace deformable_contact_monitor
