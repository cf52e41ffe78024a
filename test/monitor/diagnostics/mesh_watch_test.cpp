// Tests what /diagnostics say about an object's meshes.
#include "monitor/diagnostics/mesh_watch.h"

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <gtest/gtest.h>

#include <string>

namespace deformable_contact_monitor {
namespace {

using diagnostic_msgs::DiagnosticStatus;

// Meshes at most 0.5 s apart, at 5 Hz at least.
class MeshWatchTest : public ::testing::Test {
 protected:
  // A description `real_s` after the last one, `ros_s` later by ROS time, in which so many meshes
  // came and so many of them were dropped.
  DiagnosticStatus after(double real_s, double ros_s, int came, int dropped = 0) {
    now_ += fromSeconds(real_s);
    situation_.ros_time = ros::Time(situation_.ros_time.toSec() + ros_s);
    situation_.meshes.received += static_cast<std::uint64_t>(came);
    situation_.meshes.dropped += static_cast<std::uint64_t>(dropped);
    diagnostic_updater::DiagnosticStatusWrapper status;
    watch_.describe(status, situation_, now_);
    return status;
  }

  SteadyTime now_{std::chrono::hours(7)};
  MeshWatch watch_{true, 0.5, 5, now_};
  MeshSituation situation_{{}, "", ros::Time(100), false, true, 100};
};

TEST_F(MeshWatchTest, RateAndPeriodAreThoseSinceTheLastTime) {
  EXPECT_EQ(after(1, 1, 0).message, "no mesh received yet");
  EXPECT_EQ(watch_.periodS(), 0);
  EXPECT_EQ(after(1, 1, 30).message, "meshes arrive");
  EXPECT_DOUBLE_EQ(watch_.periodS(), 1 / 30.0);
  EXPECT_EQ(after(1, 1, 4).message, "rate below diagnostic_min_rate_hz");
  EXPECT_EQ(after(1, 1, 1).message,
            "slower than max_mesh_age_s, so UNKNOWN between meshes; raise max_mesh_age_s");
  EXPECT_EQ(after(1, 1, 0).level, DiagnosticStatus::ERROR);
  EXPECT_EQ(after(1, 1, 0).message, "no mesh within the last second");
  EXPECT_EQ(after(1, 1, 500).message, "meshes arrive");
  EXPECT_DOUBLE_EQ(watch_.periodS(), 0.01) << "max_rate_hz";
}

TEST_F(MeshWatchTest, ASlowSimulatorsRateIsThatOfItsOwnTime) {
  situation_.is_simulated = true;
  for (int i = 0; i < 30; ++i) {
    const DiagnosticStatus status = after(1, 0.1, 3);
    EXPECT_EQ(status.level, DiagnosticStatus::OK) << i << ": " << status.message;
  }
  EXPECT_NEAR(watch_.periodS(), 1 / 3.0, 1e-6) << "in real time";
  for (int i = 0; i < 10; ++i) after(1, 0.1, 0);
  EXPECT_EQ(after(1, 0.1, 0).message, "no mesh within the last second");
}

TEST_F(MeshWatchTest, AFastClocksRateIsThatOfItsOwnTime) {
  situation_.is_simulated = true;
  after(1, 10, 30);
  EXPECT_EQ(after(1, 10, 30).message, "rate below diagnostic_min_rate_hz") << "3 Hz";
  EXPECT_EQ(after(1, 10, 60).message, "meshes arrive") << "6 Hz";
}

TEST_F(MeshWatchTest, AClockThatStandsStillHidesNoSilence) {
  situation_.is_simulated = true;
  for (int i = 0; i < 8; ++i) after(1, 1, 30);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(after(1, 0, 0).level, DiagnosticStatus::OK) << i;
  EXPECT_EQ(after(1, 0, 0).message, "no mesh within the last second");
}

TEST_F(MeshWatchTest, DroppedMeshesAreAWarningUnlessTheRateAsksForThem) {
  EXPECT_EQ(after(1, 1, 60).level, DiagnosticStatus::OK);
  const DiagnosticStatus status = after(1, 1, 60, 20);
  EXPECT_EQ(status.level, DiagnosticStatus::WARN);
  EXPECT_EQ(status.message,
            "20 of 60 meshes had no cycle: they come faster than cycles end, or out of order");
  EXPECT_EQ(after(1, 1, 60).level, DiagnosticStatus::OK) << "it is over";
  EXPECT_EQ(after(1, 1, 60, 2).level, DiagnosticStatus::WARN);
  EXPECT_EQ(after(1, 1, 60, 1).level, DiagnosticStatus::OK) << "1 of 60";
  EXPECT_EQ(after(1, 1, 200, 100).level, DiagnosticStatus::OK) << "100 Hz of 200";
  EXPECT_EQ(after(1, 1, 200, 120).level, DiagnosticStatus::WARN) << "80 Hz of 200";
  situation_.max_rate_hz = 0;
  EXPECT_EQ(after(1, 1, 200, 100).level, DiagnosticStatus::WARN);
  situation_.is_enabled = false;
  EXPECT_EQ(after(1, 1, 200, 200).level, DiagnosticStatus::OK) << "~set_enabled false";
}

TEST_F(MeshWatchTest, WhatIsWrongIsSaidBesideOneAnother) {
  situation_.rivals = "two nodes";
  watch_.setAnomaly("800 m long");
  const DiagnosticStatus status = after(1, 1, 30);
  EXPECT_EQ(status.level, DiagnosticStatus::WARN);
  EXPECT_EQ(status.message, "two nodes; 800 m long");
}

}  // namespace
}  // namespace deformable_contact_monitor
