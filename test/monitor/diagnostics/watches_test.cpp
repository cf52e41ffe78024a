// Tests what /diagnostics say about cycles, steps, bounds, transforms and the backend.
#include "monitor/diagnostics/watches.h"

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "sample_report.h"
#include "sample_step.h"

namespace deformable_contact_monitor {
namespace {

using diagnostic_msgs::DiagnosticStatus;

std::string valueOf(const DiagnosticStatus& status, const std::string& key) {
  for (const auto& entry : status.values) {
    if (entry.key == key) return entry.value;
  }
  return "missing";
}

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
    report_.result = result == nullptr ? nullptr : std::make_shared<DetectionResult>(*result);
    watch_.end(report_, {cycle_s, 1.5 * cycle_s, 2 * cycle_s});
  }

  SteadyTime now_{std::chrono::hours(7)};
  TimingWatch watch_{now_};
  CycleReport report_;
};

TEST_F(TimingWatchTest, MoreThanHalfOfTheTimeIsBusy) {
  for (int i = 0; i < 5; ++i) cycle(0.1);
  now_ += fromSeconds(0.51);
  EXPECT_EQ(describe().level, DiagnosticStatus::OK) << "0.5 of 1.01 s";
  for (int i = 0; i < 5; ++i) cycle(0.1);
  now_ += fromSeconds(0.49);
  DiagnosticStatus status = describe();
  EXPECT_EQ(status.level, DiagnosticStatus::WARN) << "0.5 of 0.99 s";
  EXPECT_EQ(status.message, "busy for 51 % of the time: little is left until meshes are dropped");
  for (int i = 0; i < 9; ++i) cycle(0.1);
  now_ += fromSeconds(0.09);
  status = describe();
  EXPECT_EQ(status.level, DiagnosticStatus::WARN) << "0.9 of 0.99 s";
  EXPECT_EQ(status.message, "always busy: meshes arrive faster than cycles process them");
  EXPECT_EQ(valueOf(status, "busy share").substr(0, 4), "0.90");
  now_ += fromSeconds(1);
  EXPECT_EQ(describe().message, "in time") << "each description looks at its own time";
}

// One cycle in twenty may take longer than the time between two meshes.
TEST_F(TimingWatchTest, CyclesThatAreLongerThanTheMeshesPeriodAreSaid) {
  const DetectionResult result;
  const auto level = [this](double period_s) {
    diagnostic_updater::DiagnosticStatusWrapper status;
    now_ += fromSeconds(1000);
    watch_.describe(status, now_, period_s);
    return std::make_pair(status.level, status.message);
  };
  for (int i = 0; i < 19; ++i) cycle(0.25, &result);
  EXPECT_EQ(level(0.125).first, DiagnosticStatus::OK) << "a few cycles tell nothing";
  for (int i = 19; i < 100; ++i) cycle(i < 94 ? 0.0625 : 0.25, &result);
  EXPECT_EQ(level(0.125).first, DiagnosticStatus::WARN);
  EXPECT_EQ(level(0.125).second, "cycles take 250.0 ms (p95), but a mesh comes every 125.0 ms");
  EXPECT_EQ(level(0.25).first, DiagnosticStatus::OK);
  EXPECT_EQ(level(0).first, DiagnosticStatus::OK) << "no mesh comes";
  for (int i = 0; i < 200; ++i) cycle(i < 190 ? 0.0625 : 0.25, &result);
  EXPECT_EQ(level(0.125).first, DiagnosticStatus::OK) << "5 %";
}

TEST_F(TimingWatchTest, ACycleThatDoesNotEndIsSaid) {
  EXPECT_EQ(watch_.runsFor(now_), 0);
  watch_.start(now_);
  now_ += fromSeconds(0.5);
  EXPECT_EQ(describe().level, DiagnosticStatus::OK) << "not more than half a second";
  now_ += fromSeconds(0.25);
  EXPECT_EQ(watch_.runsFor(now_), 0.75);
  EXPECT_EQ(describe().level, DiagnosticStatus::WARN);
  EXPECT_EQ(describe().message, "busy: a cycle has been running for 0.750000 s");
  watch_.end(CycleReport(), {0.75, 0.75, 0.75});
  EXPECT_EQ(watch_.runsFor(now_), 0);
  now_ += fromSeconds(2);
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
  EXPECT_EQ(valueOf(describe(), "cycle [ms]"),
            "mean 251.250, median 250.000, p95 250.000, max 500.000");
  EXPECT_EQ(valueOf(describe(), "latency [ms]"),
            "mean 502.500, median 500.000, p95 500.000, max 1000.000");
  cycle(0.25, &result);
  const DiagnosticStatus status = describe();
  EXPECT_EQ(valueOf(status, "cycle [ms]"),
            "mean 250.000, median 250.000, p95 250.000, max 250.000");
  EXPECT_EQ(valueOf(status, "detection [ms]"),
            "mean 30.000, median 30.000, p95 30.000, max 30.000");
  EXPECT_EQ(valueOf(status, "latency of states [ms]"),
            "mean 375.000, median 375.000, p95 375.000, max 375.000");
  EXPECT_EQ(valueOf(status, "latency of states without detection [ms]"),
            "mean 345.000, median 345.000, p95 345.000, max 345.000");
  EXPECT_EQ(valueOf(status, "stage sweep [ms]"),
            "mean 20.000, median 20.000, p95 20.000, max 20.000");
  EXPECT_EQ(valueOf(status, "cold starts"), "1");
}

TEST_F(TimingWatchTest, SweptMotionHasItsStepsAndTheLatencyWithoutThem) {
  const DetectionResult result;
  cycle(0.25, &result);
  EXPECT_EQ(valueOf(describe(), "steps [ms]"), "missing");
  report_.motion = Motion::kSwept;
  report_.sweeps.resize(2);
  report_.sweeps[0].compute_s = 0.125;
  report_.sweeps[1].compute_s = 0.0625;
  cycle(0.25, &result);
  const DiagnosticStatus status = describe();
  EXPECT_EQ(valueOf(status, "steps [ms]"),
            "mean 187.500, median 187.500, p95 187.500, max 187.500");
  EXPECT_EQ(valueOf(status, "latency without steps [ms]"),
            "mean 312.500, median 312.500, p95 312.500, max 312.500");
  EXPECT_EQ(valueOf(status, "latency [ms]"),
            "mean 500.000, median 500.000, p95 500.000, max 500.000");
}

TEST(MotionWatchTest, countsStepsAndWhatTheyLack) {
  MotionWatch watch;
  SampleStep sample;
  sample.step.sub_steps = 5;
  watch.record(sample.report);
  SampleStep none;
  none.lackStep("reset");
  watch.record(none.report);
  const auto describe = [&watch] {
    diagnostic_updater::DiagnosticStatusWrapper status;
    watch.describe(status);
    return status;
  };
  const DiagnosticStatus status = describe();
  EXPECT_EQ(status.level, DiagnosticStatus::OK) << "a reset is no fault";
  EXPECT_EQ(valueOf(status, "steps"), "1");
  EXPECT_EQ(valueOf(status, "steps missing or not of all bodies"), "1");
  EXPECT_EQ(valueOf(status, "why the last of them"), "cloth: reset");
  EXPECT_EQ(valueOf(status, "pairs of bodies passed"), "1");
  EXPECT_EQ(valueOf(status, "triangle pairs in the last step"), "2");
  EXPECT_EQ(valueOf(status, "sub-steps of the last step"), "5");

  sample.result.contacts = {{0, 0, 2, 2}};
  watch.record(sample.report);
  EXPECT_EQ(valueOf(describe(), "pairs of bodies passed"), "1") << "in contact at the stamp";
  sample.result.separations_m = {0.5F};
  watch.record(sample.report);
  EXPECT_EQ(valueOf(describe(), "pairs of bodies passed"), "2") << "near";

  sample.step.detection.cutOff(kNoTime);
  watch.record(sample.report);
  EXPECT_EQ(describe().message, std::string("a step was cut off: ") + kNoTime);
  EXPECT_EQ(describe().level, DiagnosticStatus::OK) << "each description looks at its own time";
}

// Two pairs that are looked at: hand and cloth, base and cloth.
class TradeWatchTest : public ::testing::Test {
 protected:
  TradeWatchTest() {
    sample_.scene.setPairEnabled(0, 2, true);
    sample_.scene.setPairEnabled(1, 2, true);
  }

  DiagnosticStatus describe() {
    diagnostic_updater::DiagnosticStatusWrapper status;
    watch_.describe(status);
    return status;
  }
  std::string value(const std::string& key) { return valueOf(describe(), key); }

  SampleReport sample_;
  TradeWatch watch_{0.005, 0.02};
};

TEST_F(TradeWatchTest, CountsThePairsThatWereDecided) {
  EXPECT_EQ(describe().level, DiagnosticStatus::OK) << "before the first cycle";
  watch_.record(sample_.report, 0.01);
  EXPECT_EQ(value("pairs of bodies decided"), "100.00 %");
  sample_.result.cutOff(kNoTime);
  watch_.record(sample_.report, 0.01);
  EXPECT_EQ(value("pairs of bodies decided"), "75.00 %") << "what is in contact is decided";
  sample_.result.distances.resize(2);
  sample_.result.distances[0].body_b = sample_.result.distances[1].body_b = 2;
  sample_.result.distances[1].body_a = 1;
  sample_.result.distances[0].low_m = 1;
  watch_.record(sample_.report, 0.01);
  watch_.record(sample_.report, 0.01);
  EXPECT_EQ(value("pairs of bodies decided"), "62.50 %");
  EXPECT_EQ(value("tolerance [m]"), "0.005");
}

TEST_F(TradeWatchTest, WhatIsOnlyNearIsUndecidedWhereTimeWasOver) {
  sample_.result.cutOff(kNoTime);
  sample_.result.separations_m = {0.1F, 0.1F, 0.1F};
  watch_.record(sample_.report, 0.01);
  EXPECT_EQ(value("pairs of bodies decided"), "0.00 %");
  sample_.result.separations_m = {0.1F, 0.1F, 0};
  watch_.record(sample_.report, 0.01);
  EXPECT_EQ(value("pairs of bodies decided"), "25.00 %");
}

TEST_F(TradeWatchTest, NearAndContactAreDecidedAsNoneIs) {
  sample_.scene.setMargin(2, 0.02F);
  sample_.result.cutOff(kNoTime);
  sample_.result.contacts.clear();
  sample_.result.distances.resize(2);
  BodyDistance &hand = sample_.result.distances[0], &base = sample_.result.distances[1];
  hand.body_b = base.body_b = 2;
  base.body_a = 1;
  hand.low_m = 0.001F;
  hand.high_m = 0.004F;
  watch_.record(sample_.report, 0.01);
  EXPECT_EQ(value("pairs of bodies decided"), "50.00 %") << "a contact, and an open one";
  base.low_m = 0.008F;
  base.high_m = 0.012F;
  watch_.record(sample_.report, 0.01);
  EXPECT_EQ(value("pairs of bodies decided"), "75.00 %") << "and one that is near";
}

TEST_F(TradeWatchTest, TheLatestTwoHundredCyclesCount) {
  for (int i = 0; i < 200; ++i) watch_.record(sample_.report, 0.03);
  EXPECT_EQ(describe().level, DiagnosticStatus::WARN);
  for (int i = 0; i < 199; ++i) watch_.record(sample_.report, 0.01);
  EXPECT_EQ(value("arrival to states [ms]"), "median 10.000, p99 10.000, max 30.000");
  watch_.record(sample_.report, 0.01);
  EXPECT_EQ(value("arrival to states [ms]"), "median 10.000, p99 10.000, max 10.000");
}

TEST_F(TradeWatchTest, ALateAnswerInAHundredIsAWarning) {
  for (int i = 0; i < 99; ++i) watch_.record(sample_.report, 0.01);
  watch_.record(sample_.report, 0.03);
  EXPECT_EQ(describe().level, DiagnosticStatus::OK);
  EXPECT_EQ(value("p99 over budget"), "0.50");
  watch_.record(sample_.report, 0.021);
  watch_.record(sample_.report, 0.021);
  EXPECT_EQ(describe().level, DiagnosticStatus::OK) << "a tenth is allowed";
  watch_.record(sample_.report, 0.03);
  EXPECT_EQ(describe().level, DiagnosticStatus::OK);
  watch_.record(sample_.report, 0.03);
  watch_.record(sample_.report, 0.03);
  EXPECT_EQ(describe().level, DiagnosticStatus::WARN);
  EXPECT_EQ(describe().message, "states come later than budget_ms");
}

class TransformWatchTest : public ::testing::Test {
 protected:
  // A cycle that asks for these bodies and misses those.
  void record(const std::vector<std::string>& asked, const std::vector<std::string>& missed,
              double waited_s = 0) {
    TransformReport report;
    report.asked = asked;
    report.waited_s = waited_s;
    for (const std::string& body : missed) {
      TransformReport::Miss miss;
      miss.body = body;
      miss.answer.problem = "never seen";
      report.misses.push_back(miss);
    }
    watch_.record(report, now_);
  }

  diagnostic_updater::DiagnosticStatusWrapper describe() {
    diagnostic_updater::DiagnosticStatusWrapper status;
    watch_.describe(status, now_);
    return status;
  }

  TransformWatch watch_;
  SteadyTime now_{std::chrono::hours(7)};
};

TEST_F(TransformWatchTest, AFrameThatNeverAppearsIsAnErrorAfterFiveSeconds) {
  record({"arm", "hand", "foot"}, {});
  EXPECT_EQ(describe().level, DiagnosticStatus::OK);
  record({"arm", "hand", "foot"}, {"hand", "foot"});
  EXPECT_EQ(describe().level, DiagnosticStatus::WARN);
  EXPECT_EQ(describe().message, "no transform for: foot, hand");
  now_ += std::chrono::seconds(3);
  record({"arm", "hand", "foot"}, {"hand", "arm"});
  now_ += std::chrono::seconds(2);
  EXPECT_EQ(describe().level, DiagnosticStatus::WARN) << "not more than 5 s";
  now_ += std::chrono::milliseconds(1);
  const DiagnosticStatus status = describe();
  EXPECT_EQ(status.level, DiagnosticStatus::ERROR);
  EXPECT_EQ(status.message, "no transform for: arm, hand");
  EXPECT_EQ(valueOf(status, "hand"), "never seen");
  EXPECT_EQ(valueOf(status, "misses"), "4");
  record({"arm", "hand", "foot"}, {"arm"});
  EXPECT_EQ(describe().level, DiagnosticStatus::WARN) << "the arm's 5 s are not over";
}

TEST_F(TransformWatchTest, BodiesOfOtherCyclesAreAsTheyWere) {
  record({"hand", "cloth"}, {"cloth"});
  record({"hand", "cable"}, {});
  EXPECT_EQ(describe().message, "no transform for: cloth");
  record({"hand", "cloth"}, {});
  EXPECT_EQ(describe().level, DiagnosticStatus::OK);
}

TEST_F(TransformWatchTest, WhatNobodyAsksForIsForgotten) {
  record({"hand", "cloth"}, {"hand", "cloth"});
  now_ += std::chrono::seconds(20);
  record({"hand"}, {"hand"});
  now_ += std::chrono::seconds(10);
  EXPECT_EQ(describe().message, "no transform for: cloth, hand") << "not more than 30 s";
  now_ += std::chrono::milliseconds(1);
  EXPECT_EQ(describe().message, "no transform for: hand") << "the cloth's meshes have stopped";
  now_ += std::chrono::seconds(21);
  EXPECT_EQ(describe().level, DiagnosticStatus::OK);
}

TEST_F(TransformWatchTest, TheWorstWaitIsThatSinceTheLastDescription) {
  record({}, {}, 0.25);
  record({}, {}, 0.125);
  EXPECT_EQ(valueOf(describe(), "worst wait [s]"), "0.25");
  EXPECT_EQ(valueOf(describe(), "worst wait [s]"), "0");
}

int levelOf(BackendChoice asked, BackendFault fault) {
  return backendStatus(asked, {"why", fault, false}).level;
}

std::string summaryOf(BackendFault fault, bool tried_again) {
  return backendStatus(BackendChoice::kAuto, {"out of memory", fault, tried_again}).summary;
}

TEST(BackendStatus, NothingIsSaidWhileAllIsWell) {
  for (const BackendChoice asked :
       {BackendChoice::kAuto, BackendChoice::kCuda, BackendChoice::kCpu}) {
    const BackendStatus status = backendStatus(asked, BackendState());
    EXPECT_EQ(status.level, DiagnosticStatus::OK);
    EXPECT_EQ(status.summary, "");
  }
}

TEST(BackendStatus, TheLevelGoesByTheCause) {
  const BackendChoice any = BackendChoice::kAuto, cuda = BackendChoice::kCuda;
  EXPECT_EQ(levelOf(any, BackendFault::kUnavailable), DiagnosticStatus::OK) << "it is a choice";
  EXPECT_EQ(levelOf(cuda, BackendFault::kUnavailable), DiagnosticStatus::ERROR);
  EXPECT_EQ(levelOf(any, BackendFault::kTransient), DiagnosticStatus::WARN);
  EXPECT_EQ(levelOf(cuda, BackendFault::kTransient), DiagnosticStatus::ERROR);
  EXPECT_EQ(levelOf(any, BackendFault::kSticky), DiagnosticStatus::ERROR);
  EXPECT_EQ(levelOf(cuda, BackendFault::kSticky), DiagnosticStatus::ERROR);
  EXPECT_EQ(levelOf(any, BackendFault::kSceneTooLarge), DiagnosticStatus::WARN);
  EXPECT_EQ(levelOf(cuda, BackendFault::kSceneTooLarge), DiagnosticStatus::WARN);
}

TEST(BackendStatus, ADeviceOfSeveralIsAWarning) {
  BackendState state{"CUDA device 1: out of memory", BackendFault::kSticky, false};
  state.partly = true;
  const BackendStatus status = backendStatus(BackendChoice::kCuda, state);
  EXPECT_EQ(status.level, DiagnosticStatus::WARN);
  EXPECT_EQ(status.summary,
            "one of the CUDA devices failed and is not used until this process restarts: "
            "CUDA device 1: out of memory");
}

TEST(BackendStatus, TheSummarySaysWhyAndWhatHelps) {
  const std::string why =
      "contacts are computed on the CPU, because CUDA cannot be used: out of memory";
  EXPECT_EQ(summaryOf(BackendFault::kTransient, true),
            why + "; CUDA is tried again at least once a minute");
  EXPECT_EQ(summaryOf(BackendFault::kSticky, false),
            why + "; restart this process to use CUDA again");
  EXPECT_EQ(summaryOf(BackendFault::kSceneTooLarge, true), why + "; smaller scenes run on CUDA");
  EXPECT_EQ(summaryOf(BackendFault::kUnavailable, false), why);
}

}  // namespace
}  // namespace deformable_contact_monitor
