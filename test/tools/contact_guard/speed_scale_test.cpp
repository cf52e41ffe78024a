// Tests of the rules for the speed scale, over random distances, speeds and parameters.
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "tools/contact_guard/closing_speed.h"

namespace deformable_contact_monitor {
namespace {

GuardParameters randomParameters(std::mt19937* random) {
  std::uniform_real_distribution<double> unit(0, 1);
  GuardParameters p;
  p.slow_distance_m = unit(*random);
  p.stop_distance_m = p.slow_distance_m * unit(*random);
  p.least_scale = unit(*random) < 0.2 ? 0 : unit(*random);
  p.time_to_contact_s = 3 * unit(*random);
  p.fastest_closing_mps = 0.01 + 2 * unit(*random);
  return p;
}

TEST(SpeedScaleTest, isAtMostOneAndMonotone) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 100000; ++i) {
    const GuardParameters p = randomParameters(&random);
    const double near_m = 1.2 * unit(random), far_m = near_m + 0.5 * unit(random);
    const double slow_mps = 3 * unit(random) - 1, fast_mps = slow_mps + unit(random);
    EXPECT_LE(scaleByDistance(near_m, p), scaleByDistance(far_m, p));
    EXPECT_LE(scaleByTime(near_m, fast_mps, p), scaleByTime(far_m, fast_mps, p));
    EXPECT_GE(scaleByTime(near_m, slow_mps, p), scaleByTime(near_m, fast_mps, p));
    for (const double scale : {scaleByDistance(near_m, p), scaleByTime(near_m, fast_mps, p)}) {
      EXPECT_GE(scale, p.least_scale);
      EXPECT_LE(scale, 1);
    }
    EXPECT_EQ(scaleByTime(near_m, -fast_mps * fast_mps, p), 1);
  }
}

TEST(SpeedScaleTest, leavesTheTimeThatIsAskedFor) {
  GuardParameters p;
  p.stop_distance_m = 0.02;
  p.least_scale = 0.1;
  p.time_to_contact_s = 2;
  EXPECT_EQ(scaleByTime(1.02, 0.5, p), 1);
  EXPECT_DOUBLE_EQ(scaleByTime(0.52, 0.5, p), 0.5);
  EXPECT_DOUBLE_EQ(scaleByTime(0.27, 0.5, p), 0.25);
  EXPECT_EQ(scaleByTime(0.021, 0.5, p), 0.1);
  p.time_to_contact_s = 0;
  EXPECT_EQ(scaleByTime(0.021, 100, p), 1);
}

TEST(SpeedScaleTest, whatIsMeasuredWasScaledAlready) {
  GuardParameters p;
  p.fastest_closing_mps = 1;
  EXPECT_EQ(closingAtFullSpeed(std::nullopt, 1, p), 1);
  EXPECT_EQ(closingAtFullSpeed(ClosingEstimate{0.2, 0}, 1, p), 0.2);
  EXPECT_EQ(closingAtFullSpeed(ClosingEstimate{0.2, 0}, 0.5, p), 0.4);
  EXPECT_EQ(closingAtFullSpeed(ClosingEstimate{0.2, 0.05}, 0.5, p), 0.5);
  EXPECT_EQ(closingAtFullSpeed(ClosingEstimate{0.2, 0}, 0.1, p), 1);    // not faster than that
  EXPECT_EQ(closingAtFullSpeed(ClosingEstimate{1.5, 0}, 0.1, p), 1.5);  // but as fast as it is
  EXPECT_EQ(closingAtFullSpeed(ClosingEstimate{0.2, 0}, 0, p), 1);
  EXPECT_EQ(closingAtFullSpeed(ClosingEstimate{-0.2, 0.1}, 0, p), -0.1);
}

TEST(ScaleHistoryTest, hasTheMeanOverTime) {
  ScaleHistory history;
  EXPECT_EQ(history.mean(0, 100), 0);
  history.add(100, 1);
  history.add(150, 1);
  history.add(200, 0.5);
  EXPECT_EQ(history.mean(0, 100), 0);
  EXPECT_EQ(history.mean(0, 200), 0.5);
  EXPECT_EQ(history.mean(100, 200), 1);
  EXPECT_EQ(history.mean(150, 250), 0.75);
  EXPECT_EQ(history.mean(300, 400), 0.5);
  EXPECT_EQ(history.mean(300, 300), 0.5);
  history.dropBefore(180);
  EXPECT_EQ(history.mean(150, 250), 0.75);
  history.add(50, 0.25);  // the clock went back
  EXPECT_EQ(history.mean(50, 100), 0.25);
}

}  // namespace
}  // namespace deformable_contact_monitor
