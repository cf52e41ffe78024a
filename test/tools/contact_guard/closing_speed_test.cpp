// Tests of the estimate of a closing speed: its value, its noise, and when it is not known.
#include "tools/contact_guard/closing_speed.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

namespace deformable_contact_monitor {
namespace {

constexpr double kWindowS = 0.2, kMostAgeS = 0.5;
constexpr std::int64_t kPeriodNs = 33333333;
constexpr std::int64_t kStartNs = 1700000000000000000;

// Distances of one pair at 30 Hz.
struct Pair {
  void add(double distance_m) {
    stamp_ns += kPeriodNs;
    speed.add(stamp_ns, distance_m, kWindowS, kMostAgeS);
  }
  void wait(double s) { stamp_ns += static_cast<std::int64_t>(s * 1e9); }
  double measured() const { return speed.estimate()->speed_mps; }

  std::int64_t stamp_ns = kStartNs;
  ClosingSpeed speed;
};

TEST(ClosingSpeedTest, isTheSlopeOfTheDistance) {
  Pair pair;
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(pair.speed.estimate().has_value(), i >= 3) << i;
    pair.add(0.5 - 0.3 * i * kPeriodNs * 1e-9);
  }
  EXPECT_NEAR(pair.measured(), 0.3, 1e-9);
  EXPECT_NEAR(pair.speed.estimate()->error_mps, 0, 1e-9);
  EXPECT_FALSE(pair.speed.isLeaving());
  EXPECT_LE(static_cast<double>(pair.speed.newestNs() - pair.speed.oldestNs()) * 1e-9, kWindowS);
}

TEST(ClosingSpeedTest, aPairThatLeavesIsKnownAfterThreeStatesAndTurnsAtOnce) {
  Pair pair;
  for (int i = 0; i < 8; ++i) {
    pair.add(0.1 + 0.01 * i);
    EXPECT_EQ(pair.speed.isLeaving(), i >= 2) << i;
  }
  EXPECT_NEAR(pair.measured(), -0.3, 1e-6);
  pair.add(0.165);
  EXPECT_FALSE(pair.speed.isLeaving());
}

// The turn bends the distances: they are not on a line, and have no noise.
TEST(ClosingSpeedTest, aPairThatBrakesAndTurnsLeavesNoLongerAtTheFirstSmallerDistance) {
  for (const double braking_mps2 : {2.0, 5.0, 10.0}) {
    ClosingSpeed speed;
    double before_m = 0;
    bool was_leaving = false;
    for (int i = 0, smaller = 0; smaller < 4; ++i) {
      const double t_s = i / 60.0;
      const double distance_m = 0.1 + t_s - braking_mps2 * t_s * t_s / 2;
      speed.add(kStartNs + i * kPeriodNs / 2, distance_m, 1.0, 2.0);
      was_leaving |= speed.isLeaving();
      smaller += distance_m < before_m ? 1 : 0;
      EXPECT_FALSE(speed.isLeaving() && smaller > 0) << braking_mps2 << ", " << smaller;
      before_m = distance_m;
    }
    EXPECT_TRUE(was_leaving);
  }
}

TEST(ClosingSpeedTest, standingStillIsNotLeaving) {
  Pair pair;
  for (int i = 0; i < 8; ++i) pair.add(0.1);
  EXPECT_EQ(pair.measured(), 0);
  EXPECT_FALSE(pair.speed.isLeaving());
}

TEST(ClosingSpeedTest, oneWrongDistanceHardlyChangesIt) {
  for (const double wrong_m : {0.0, 0.05, 0.4, 5.0}) {
    for (int at = 1; at < 6; ++at) {
      Pair pair;
      for (int i = 0; i < 7; ++i) pair.add(i == at ? wrong_m : 0.3 - 0.2 * i * kPeriodNs * 1e-9);
      EXPECT_NEAR(pair.measured(), 0.2, 0.03) << wrong_m << " at " << at;
    }
  }
}

// Noise of 1 mm either way, over a window of 0.2 s.
TEST(ClosingSpeedTest, noiseIsBounded) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> noise(-1e-3, 1e-3);
  for (const double true_mps : {0.0, 0.05, 0.3, -0.1}) {
    Pair pair;
    int outside = 0;
    for (int i = 0; i < 600; ++i) {
      pair.add(20 - true_mps * i * kPeriodNs * 1e-9 + noise(random));
      const auto found = pair.speed.estimate();
      if (i < 7) continue;
      EXPECT_NEAR(found->speed_mps, true_mps, 0.02);
      EXPECT_LE(found->error_mps, 0.06);
      if (found->mostMps() < true_mps) ++outside;
    }
    EXPECT_LT(outside, 80) << true_mps;  // of 593
  }
}

TEST(ClosingSpeedTest, isNotKnownAfterAGapOrAJumpOfTheClock) {
  Pair pair;
  for (int i = 0; i < 8; ++i) pair.add(0.5 - 0.01 * i);
  pair.wait(0.45);  // the last three samples would be too old with the next one
  pair.add(0.2);
  EXPECT_FALSE(pair.speed.estimate());
  for (int i = 0; i < 8; ++i) pair.add(0.5 - 0.01 * i);
  pair.wait(-2);
  pair.add(0.2);
  EXPECT_FALSE(pair.speed.estimate());
  for (int i = 0; i < 8; ++i) pair.add(0.5 - 0.01 * i);
  pair.add(std::numeric_limits<double>::infinity());
  EXPECT_FALSE(pair.speed.estimate());
}

TEST(ClosingSpeedTest, aRepeatedStampCountsOnce) {
  ClosingSpeed speed;
  for (int i = 0; i < 5; ++i) speed.add(kStartNs, 0.1, kWindowS, kMostAgeS);
  EXPECT_FALSE(speed.estimate());
}

TEST(ClosingSpeedTest, slowMeshesKeepThreeSamples) {
  ClosingSpeed speed;
  for (int i = 0; i < 5; ++i) {
    speed.add(kStartNs + i * 200000000LL, 1 - 0.1 * i, kWindowS, kMostAgeS);
  }
  ASSERT_TRUE(speed.estimate());
  EXPECT_NEAR(speed.estimate()->speed_mps, 0.5, 1e-9);
}

}  // namespace
}  // namespace deformable_contact_monitor
