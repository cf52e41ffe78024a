// What the diagnostics say of cycles that do not keep up.
#include "monitor/diagnostics/timing_watch.h"

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

namespace deformable_contact_monitor {
namespace {

using diagnostic_msgs::DiagnosticStatus;

class TimingWatchTest : public ::testing::Test {
 protected:
  DiagnosticStatus describe() {
    diagnostic_updater::DiagnosticStatusWrapper status;
    watch_.describe(status, now_);
    return status;
  }

  // A cycle of so long.
  void cycle(double cycle_s, const DetectionResult* result = nullptr) {
    watch_.start(now_);
    now_ += fromSeconds(cycle_s);
    report_.result = result;
    watch_.end(report_, {cycle_s, 1.5 * cycle_s, 2 * cycle_s});
  }

  static std::string value(const DiagnosticStatus& status, const std::string& key) {
    for (const auto& entry : status.values) {
      if (entry.key == key) return entry.value;
    }
    return "";
  }

  SteadyTime now_{std::chrono::hours(7)};
  TimingWatch watch_{now_};
  CycleReport report_;
};

TEST_F(TimingWatchTest, MoreThanNineTenthsOfTheTimeIsBusy) {
  for (int i = 0; i < 9; ++i) cycle(0.1);
  now_ += fromSeconds(0.11);
  EXPECT_EQ(describe().level, DiagnosticStatus::OK) << "0.9 of 1.01 s";
  for (int i = 0; i < 9; ++i) cycle(0.1);
  now_ += fromSeconds(0.09);
  const DiagnosticStatus status = describe();
  EXPECT_EQ(status.level, DiagnosticStatus::WARN) << "0.9 of 0.99 s";
  EXPECT_EQ(status.message, "always busy: meshes come faster than they are done");
  EXPECT_EQ(value(status, "busy share").substr(0, 4), "0.90");
  now_ += fromSeconds(1);
  EXPECT_EQ(describe().message, "in time") << "each description looks at its own time";
}

TEST_F(TimingWatchTest, ACycleThatDoesNotEndIsSaid) {
  EXPECT_EQ(watch_.runsFor(now_), 0);
  watch_.start(now_);
  now_ += fromSeconds(0.5);
  EXPECT_EQ(describe().level, DiagnosticStatus::OK) << "not more than half a second";
  now_ += fromSeconds(0.25);
  EXPECT_EQ(watch_.runsFor(now_), 0.75);
  EXPECT_EQ(describe().level, DiagnosticStatus::WARN);
  EXPECT_EQ(describe().message, "busy: a cycle runs for 0.750000 s");
  watch_.end(CycleReport(), {0.75, 0.75, 0.75});
  EXPECT_EQ(watch_.runsFor(now_), 0);
  now_ += fromSeconds(1);
  EXPECT_EQ(describe().message, "in time");
}

TEST_F(TimingWatchTest, TimesAreOfTheLastTwoHundredCycles) {
  DetectionResult result;
  result.round_trip_ms = 30;
  result.stages_ms = {{"sweep", 20}};
  result.started_cold = true;
  cycle(0.5, &result);
  result.started_cold = false;
  cycle(0.125);  // nothing detected
  for (int i = 0; i < 199; ++i) cycle(0.25, &result);
  EXPECT_EQ(value(describe(), "cycle [ms]"),
            "mean 251.250, median 250.000, p95 250.000, max 500.000");
  EXPECT_EQ(value(describe(), "latency [ms]"),
            "mean 502.500, median 500.000, p95 500.000, max 1000.000");
  cycle(0.25, &result);
  const DiagnosticStatus status = describe();
  EXPECT_EQ(value(status, "cycle [ms]"), "mean 250.000, median 250.000, p95 250.000, max 250.000");
  EXPECT_EQ(value(status, "detection [ms]"), "mean 30.000, median 30.000, p95 30.000, max 30.000");
  EXPECT_EQ(value(status, "latency of states [ms]"),
            "mean 375.000, median 375.000, p95 375.000, max 375.000");
  EXPECT_EQ(value(status, "latency of states without detection [ms]"),
            "mean 345.000, median 345.000, p95 345.000, max 345.000");
  EXPECT_EQ(value(status, "stage sweep [ms]"),
            "mean 20.000, median 20.000, p95 20.000, max 20.000");
  EXPECT_EQ(value(status, "cold starts"), "1");
}

TEST_F(TimingWatchTest, SweptMotionHasItsStepsAndTheLatencyWithoutThem) {
  const DetectionResult result;
  cycle(0.25, &result);
  EXPECT_EQ(value(describe(), "steps [ms]"), "");
  report_.motion = Motion::kSwept;
  report_.sweeps.resize(2);
  report_.sweeps[0].compute_s = 0.125;
  report_.sweeps[1].compute_s = 0.0625;
  cycle(0.25, &result);
  const DiagnosticStatus status = describe();
  EXPECT_EQ(value(status, "steps [ms]"), "mean 187.500, median 187.500, p95 187.500, max 187.500");
  EXPECT_EQ(value(status, "latency without steps [ms]"),
            "mean 312.500, median 312.500, p95 312.500, max 312.500");
  EXPECT_EQ(value(status, "latency [ms]"),
            "mean 500.000, median 500.000, p95 500.000, max 500.000");
}

}  // namespace
}  // namespace deformable_contact_monitor
