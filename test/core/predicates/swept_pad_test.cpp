// Pairs within a pad, against exact rationals at many times of the step.
#include "core/predicates/swept_pad.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "core/predicates/swept_exact.h"
#include "exact_triangles.h"
#include "moving_pairs.h"

namespace deformable_contact_monitor {
namespace {

using exact::Rational;

exact::Corners cornersAt(const MovingTriangle& t, int numerator, int denominator) {
  const Rational part = Rational(numerator) / Rational(denominator);
  exact::Corners corners;
  for (std::size_t i = 0; i < 3; ++i) {
    const exact::Point from = exact::toPoint(t.from.v[i]), to = exact::toPoint(t.to.v[i]);
    corners[i] = from + part * (to - from);
  }
  return corners;
}

Rational squaredDistanceAt(const MovingPair& pair, int numerator, int denominator) {
  const exact::Corners a = cornersAt(pair.a, numerator, denominator);
  const exact::Corners b = cornersAt(pair.b, numerator, denominator);
  return exact::meetBeyond(a, b, {}) ? Rational(0) : exact::squaredDistance(a, b);
}

// No less than the root.
float rootAbove(const Rational& squared) {
  auto root = static_cast<float>(std::sqrt(CGAL::to_double(squared.exact())));
  while (Rational(double{root}) * Rational(double{root}) < squared) {
    root = std::nextafter(root, INFINITY);
  }
  return root;
}

// The distance in double, at some time: of triangles that do not intersect.
double distanceAt(const MovingPair& pair, double time) {
  const auto at = [time](const MovingTriangle& t) {
    Triangle triangle;
    for (int i = 0; i < 3; ++i) {
      const Vec3d from = toDouble(t.from.v[i]), to = toDouble(t.to.v[i]);
      triangle.v[i] = toFloat(from + (to - from) * time);
    }
    return triangle;
  };
  return separation(at(pair.a), at(pair.b));
}

void forEachPair(int count, const std::function<void(const MovingPair&)>& visit) {
  for (const MovingPairClass& kind : movingPairClasses()) {
    MotionDice dice(7);
    for (int i = 0; i < count; ++i) {
      SCOPED_TRACE(kind.name + std::string(", pair ") + std::to_string(i));
      visit(kind.make(&dice));
      if (::testing::Test::HasFailure()) return;
    }
  }
}

// Pads that are attained, but for an ulp, at a time that is looked at and at no other.
TEST(SweptPad, IsNeverToldApartWhereAnExactDistanceIsWithin) {
  constexpr int kTimes = 12;
  int within = 0;
  forEachPair(60, [&within](const MovingPair& pair) {
    std::vector<Rational> squared;
    for (int k = 0; k <= kTimes; ++k) squared.push_back(squaredDistanceAt(pair, k, kTimes));
    for (const Rational& one : squared) {
      const float pad_m = std::max(rootAbove(one), FLT_MIN);
      const Rational squared_pad = Rational(double{pad_m}) * Rational(double{pad_m});
      const PadVerdict verdict = withinPad(pair.a, pair.b, pad_m);
      ASSERT_TRUE(verdict.may_touch);
      const auto first = std::find_if(squared.begin(), squared.end(),
                                      [&](const Rational& s) { return s <= squared_pad; });
      const auto k = first - squared.begin();
      ASSERT_LE(double{verdict.first_low} * kTimes, static_cast<double>(k));
      within += k > 0;
    }
  });
  EXPECT_GT(within, 1000);
}

TEST(SweptPad, IsTheSameForBothOrders) {
  forEachPair(3000, [](const MovingPair& pair) {
    for (const float pad_m : {1e-3F, 1.0F, 30.0F}) {
      const PadVerdict ab = withinPad(pair.a, pair.b, pad_m), ba = withinPad(pair.b, pair.a, pad_m);
      ASSERT_EQ(ab.may_touch, ba.may_touch) << pad_m;
      ASSERT_EQ(ab.first_low, ba.first_low) << pad_m;
    }
  });
}

TEST(SweptPad, FollowsExactScales) {
  MotionDice dice(9);
  for (int i = 0; i < 5000; ++i) {
    const MovingPair pair = dice.pair(9);
    const float pad_m = static_cast<float>(dice.within(1, 64)) / 16;
    const PadVerdict expected = withinPad(pair.a, pair.b, pad_m);
    for (const int power : {-120, 100}) {
      const MovingPair other = scaled(pair, power);
      const PadVerdict verdict = withinPad(other.a, other.b, std::ldexp(pad_m, power));
      ASSERT_EQ(verdict.may_touch, expected.may_touch) << power;
      ASSERT_EQ(verdict.first_low, expected.first_low) << power;
    }
  }
}

// Triangles of a few centimetres that move by some millimetres, as in sub-steps, and are some
// tenths of a millimetre apart at the nearest.
MovingPair nearMiss(MotionDice* dice, double* distance) {
  for (;;) {
    MovingPair pair = dice->pair(1000);
    for (MovingTriangle* t : {&pair.a, &pair.b}) {
      const Vec3f step = dice->point(60);
      for (int i = 0; i < 3; ++i) {
        t->from.v[i] = t->from.v[i] * 3e-5F + Vec3f{0.5F, 0.5F, 0.5F};
        t->to.v[i] = t->from.v[i] + step * 1e-4F + dice->point(10) * 1e-4F;
      }
    }
    double least = distanceAt(pair, 0.5);
    if (least > 0.01) continue;
    for (int k = 0; k <= 400; ++k) least = std::min(least, distanceAt(pair, k / 400.0));
    *distance = least;
    PredicateState state;
    if (!(least > 1e-5 && least < 1e-3)) continue;
    if (sweptVerdict(pair.a, pair.b, {}, AdjacentPairs::kSkip, false, state).part ==
        PartVerdict::kApart) {
      return pair;
    }
  }
}

TEST(SweptPad, TellsNearlyAllApartThatAreAFifthFurther) {
  MotionDice dice(11);
  constexpr int kPairs = 1000;  // all of them
  int apart = 0;
  for (int i = 0; i < kPairs; ++i) {
    double distance;
    const MovingPair pair = nearMiss(&dice, &distance);
    apart += !withinPad(pair.a, pair.b, static_cast<float>(distance / 1.2)).may_touch;
  }
  EXPECT_GE(apart, kPairs - 5);
}

// Triangles of centimetres that move by up to 2 m, and pads of 10 um to 3 mm: those that are listed
// come as near as the comment of withinPad() says.
TEST(SweptPad, ListsNoneThatStaysFartherThanItsWayTells) {
  std::mt19937 random(1);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<>(low, high)(random);
  };
  int far = 0;
  for (int i = 0; i < 30000; ++i) {
    const double size = std::pow(10, uniform(-2, -0.5)), move = std::pow(10, uniform(-3, 0.3));
    const auto pad_m = static_cast<float>(std::pow(10, uniform(-5, -2.5)));
    MovingPair pair;
    double way = 0;
    for (MovingTriangle* t : {&pair.a, &pair.b}) {
      const auto vector = [&](double most) {
        return Vec3d{uniform(-most, most), uniform(-most, most), uniform(-most, most)};
      };
      const Vec3d centre = vector(0.1), step = vector(t == &pair.a ? move : 0);
      double longest = 0;
      for (int k = 0; k < 3; ++k) {
        const Vec3d bend = step + vector(t == &pair.a ? 0.3 * move : 0);
        t->from.v[k] = toFloat(centre + vector(size));
        t->to.v[k] = toFloat(toDouble(t->from.v[k]) + bend);
        longest = std::max(longest, std::sqrt(dot(bend, bend)));
      }
      way += longest;
    }
    const PadVerdict verdict = withinPad(pair.a, pair.b, pad_m);
    PredicateState state;
    if (!verdict.may_touch ||
        sweptVerdict(pair.a, pair.b, {}, AdjacentPairs::kSkip, false, state).part !=
            PartVerdict::kApart) {
      continue;
    }
    double distance = INFINITY;
    for (int k = 0; k <= 64; ++k) {
      distance = std::min(distance, distanceAt(pair, verdict.first_low + k / 65536.0));
    }
    far += distance > pad_m * 1.01;
    ASSERT_LE(distance, pad_m + way / 2048 + 1e-6) << i;
  }
  EXPECT_GT(far, 0);
}

// A vertex of b lies on a's face all the time: projections differ by nothing but rounding.
TEST(SweptPad, RoundingTellsNothingApart) {
  MotionDice dice(13);
  for (int i = 0; i < 20000; ++i) {
    Triangle a = dice.triangle(1 << 20), b = dice.triangle(1 << 20);
    for (Vec3f& v : a.v) v = v * 4;
    b.v[0] = a.v[0] * 0.5F + a.v[1] * 0.25F + a.v[2] * 0.25F;
    MovingPair pair{{a, a}, {b, b}};
    const Vec3f step = dice.point(1 << 20);
    for (MovingTriangle* t : {&pair.a, &pair.b}) {
      for (Vec3f& v : t->to.v) v = v + step;
    }
    ASSERT_TRUE(withinPad(pair.a, pair.b, FLT_TRUE_MIN).may_touch) << i;
  }
}

// A vertex comes down on a face, and is a pad away from it after `at`.
TEST(SweptPad, SaysHowLongTheyAreApart) {
  const Triangle floor{{{-1, -1, 0}, {2, -1, 0}, {0, 2, 0}}};
  for (const double at : {0.01, 0.2, 1.0 / 3, 0.5, 0.77, 0.99}) {
    const float pad_m = 1e-4F, height = 0.01F;
    const auto end = static_cast<float>(height - (height - pad_m) / at);
    const MovingTriangle still{floor, floor};
    const MovingTriangle falls{{{{0, 0, height}, {0, 0.1F, 1}, {0.1F, 0, 1}}},
                               {{{0, 0, end}, {0, 0.1F, 1}, {0.1F, 0, 1}}}};
    const PadVerdict verdict = withinPad(still, falls, pad_m);
    ASSERT_TRUE(verdict.may_touch);
    EXPECT_LE(verdict.first_low, at + 1e-6);
    EXPECT_GE(verdict.first_low, at - 2e-3);
  }
}

TEST(SweptPad, HoldsAtExtremes) {
  const Triangle huge{{{-FLT_MAX, -FLT_MAX, 0}, {FLT_MAX, -FLT_MAX, 0}, {0, FLT_MAX, 0}}};
  const Triangle above{{{0, 0, 2}, {1, 0, 2}, {0, 1, 2}}};
  const MovingTriangle ground{huge, huge}, over{above, above};
  EXPECT_TRUE(withinPad(ground, over, 3).may_touch);
  EXPECT_TRUE(withinPad(over, ground, FLT_MAX).may_touch);
  const Triangle point{{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}};
  const Triangle next{{{1, 1, 1.5F}, {1, 1, 1.5F}, {1, 1, 1.5F}}};
  EXPECT_TRUE(withinPad({point, point}, {next, next}, 0.5F).may_touch);
  EXPECT_FALSE(withinPad({point, point}, {next, next}, std::nextafter(0.5F, 0.0F)).may_touch);
  EXPECT_TRUE(withinPad({point, point}, {point, point}, FLT_TRUE_MIN).may_touch);
  EXPECT_FALSE(withinPad({point, point}, {next, next}, FLT_TRUE_MIN).may_touch);
}

}  // namespace
}  // namespace deformable_contact_monitor
