// Tests of the guard while a robot moves as the guard lets it: time to contact, leaving, noise.
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <random>
#include <string>
#include <vector>

#include "guard_watch.h"

namespace deformable_contact_monitor {
namespace {

constexpr double kPeriodS = 1.0 / 30;

GuardParameters byTime() {
  GuardParameters p;
  p.slow_distance_m = 0.03;
  p.stop_distance_m = 0.02;
  p.least_scale = 0.05;
  p.time_to_contact_s = 1;
  p.fastest_closing_mps = 0.6;
  return p;
}

// A robot that is told to move towards a cloth, and moves as the guard says `delay` periods later.
class Robot {
 public:
  Robot(const GuardParameters& parameters, double distance_m, int delay = 0, double noise_m = 0)
      : watch(parameters),
        distance_m(distance_m),
        scales_(static_cast<std::size_t>(delay), 0.0),
        noise_(-noise_m, noise_m) {}

  // Moves for one period at `closing_mps` of full speed, and returns what the guard says then.
  GuardOutput move(double closing_mps) {
    scales_.push_back(output.stop ? 0 : output.scale);
    speed_mps = closing_mps * scales_.front();
    scales_.pop_front();
    distance_m -= speed_mps * kPeriodS;
    const double seen_m = distance_m + noise_(random_);
    output = watch.hear(at(static_cast<float>(std::max(seen_m, 0.0))), kPeriodS);
    return output;
  }

  Watch watch;
  double distance_m;
  double speed_mps = 0;
  GuardOutput output;

 private:
  std::deque<double> scales_;
  std::uniform_real_distribution<double> noise_;
  std::mt19937 random_{5};
};

TEST(GuardMotionTest, leavesTheTimeToContact) {
  for (const int delay : {0, 1, 3}) {
    for (const double noise_m : {0.0, 5e-4}) {
      Robot robot(byTime(), 1, delay, noise_m);
      double least_s = 10;
      int steps = 0;
      while (!robot.move(0.5).stop && ++steps < 1000) {
        EXPECT_GE(robot.output.scale, 0.05);
        if (robot.output.scale <= 0.051) continue;  // as slow as least_scale allows
        if (robot.speed_mps > 0) {
          least_s = std::min(least_s, (robot.distance_m - 0.02) / robot.speed_mps);
        }
      }
      EXPECT_LT(steps, 1000) << "never arrives";
      EXPECT_GT(least_s, 0.6) << "delay " << delay << ", noise " << noise_m;
      EXPECT_GT(robot.distance_m, 0);
    }
  }
}

TEST(GuardMotionTest, approachesSmoothly) {
  Robot robot(byTime(), 1);
  for (int i = 0; i < 6; ++i) robot.move(0.5);
  double before = robot.output.scale;
  for (int i = 0; i < 1000 && !robot.move(0.5).stop; ++i) {
    EXPECT_LT(std::abs(robot.output.scale - before), 0.12) << robot.distance_m;
    before = robot.output.scale;
  }
}

// A slow approach is never slowed as long as the time is there; the distance alone would do so.
TEST(GuardMotionTest, aSlowApproachGoesOnAtFullSpeed) {
  Robot robot(byTime(), 0.6);
  for (int i = 0; i < 5; ++i) robot.move(0.02);
  while (robot.distance_m > 0.05) {
    ASSERT_EQ(robot.move(0.02).scale, 1) << robot.output.because;
  }
}

TEST(GuardMotionTest, leavingIsNeverSlowed) {
  for (const double noise_m : {0.0, 5e-4}) {
    GuardParameters p = byTime();
    p.slow_distance_m = 0.5;
    p.receding_m = 0;  // only the closing speed shows that it leaves
    Robot robot(p, 0.2, 0, noise_m);
    for (int i = 0; i < 30; ++i) robot.move(0.3);
    robot.output = {false, 1, "", false, ""};  // at the stop, the operator takes over
    for (int i = 0; i < 4; ++i) robot.move(-0.3);
    while (robot.distance_m < 0.5) {
      ASSERT_EQ(robot.move(-0.3).scale, 1) << robot.output.because << ", noise " << noise_m;
    }
    EXPECT_LT(robot.move(0.3).scale, 1) << "it turned back";
  }
}

TEST(GuardMotionTest, noiseDoesNotSlowARobotThatStands) {
  Robot robot(byTime(), 0.2, 0, 1e-3);
  for (int i = 0; i < 8; ++i) robot.move(0);
  for (int i = 0; i < 300; ++i) ASSERT_EQ(robot.move(0).scale, 1) << robot.output.because;
}

TEST(GuardMotionTest, anUnknownSpeedCountsAsTheFastest) {
  Watch watch(byTime());
  watch.hear(none("hand", "cloth"), kPeriodS);
  const GuardOutput output = watch.hear(at(0.32F), kPeriodS);
  EXPECT_NEAR(output.scale, 0.3 / 0.6, 1e-6);
  EXPECT_EQ(output.because, "hand and cloth: 0.3200 m, its closing speed is not known yet");
  // The cloth comes, although the robot stands: what is measured.
  for (int i = 1; i < 4; ++i) watch.hear(at(0.32F - 0.01F * static_cast<float>(i)), kPeriodS);
  EXPECT_NE(watch.decide().because.find(", closing at 0.3"), std::string::npos)
      << watch.decide().because;
}

TEST(GuardMotionTest, anUnknownStateStopsAndTheSpeedBeforeItHolds) {
  Robot robot(byTime(), 0.5);
  for (int i = 0; i < 8; ++i) robot.move(0.1);
  const GuardOutput stop =
      robot.watch.hear(stateOf("hand", "cloth", ContactState::UNKNOWN, kNaN), kPeriodS);
  EXPECT_TRUE(stop.stop);
  EXPECT_EQ(stop.scale, 0);
  EXPECT_FALSE(robot.move(0).stop);
  robot.watch.wait(0.51);
  EXPECT_TRUE(robot.watch.decide().stop) << "its state is too old";
}

TEST(GuardMotionTest, randomStatesHaveAScaleAndItIsZeroWithAStop) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int run = 0; run < 50; ++run) {
    GuardParameters p = byTime();
    p.slow_distance_m = 0.02 + unit(random);
    p.time_to_contact_s = 2 * unit(random);
    p.least_scale = unit(random);
    Watch watch(p);
    double distance_m = unit(random);
    for (int i = 0; i < 200; ++i) {
      distance_m = std::abs(distance_m + 0.1 * (unit(random) - 0.5));
      const double kind = unit(random);
      const bool is_unknown = kind < 0.05;
      const GuardOutput output =
          watch.hear(is_unknown   ? stateOf("hand", "cloth", ContactState::UNKNOWN, kNaN)
                     : kind < 0.1 ? none("hand", "cloth")
                                  : at(static_cast<float>(distance_m)),
                     0.001 + 0.1 * unit(random));
      ASSERT_TRUE(output.scale >= 0 && output.scale <= 1) << output.scale;
      if (output.stop) {
        ASSERT_EQ(output.scale, 0);
      } else {
        ASSERT_GE(output.scale, p.least_scale);
      }
      if (is_unknown || (kind >= 0.1 && distance_m <= p.stop_distance_m)) {
        ASSERT_TRUE(output.stop);
      }
    }
  }
}

TEST(GuardMotionTest, warnsWithinItsDistance) {
  GuardParameters p = byTime();
  p.time_to_contact_s = 0;
  p.warn_distance_m = 0.25;
  Watch watch(p);
  EXPECT_TRUE(watch.decide().warn) << "nothing is known";
  EXPECT_FALSE(watch.hear(at(0.26F)).warn);
  EXPECT_TRUE(watch.hear(at(0.25F)).warn);
  GuardOutput output = watch.hear({at(0.25F), stateOf("arm", "cloth", ContactState::NEAR, 0.125)});
  EXPECT_TRUE(output.warn);
  EXPECT_EQ(output.near, "arm and cloth: 0.1250 m");
  EXPECT_EQ(output.scale, 1);
  output = watch.hear(at(0.01F));
  EXPECT_TRUE(output.stop && output.warn);
  EXPECT_EQ(output.near, "");
  EXPECT_FALSE(watch.hear(none("hand", "cloth")).warn);
}

TEST(GuardMotionTest, withoutAWarningDistanceOnlyAStopWarns) {
  Watch watch(byTime());
  EXPECT_FALSE(watch.hear(at(0.021F)).warn);
  EXPECT_TRUE(watch.hear(at(0.02F)).warn);
}

}  // namespace
}  // namespace deformable_contact_monitor
