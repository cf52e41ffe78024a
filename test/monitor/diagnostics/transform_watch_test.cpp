// What the diagnostics say of transforms that do not come.
#include "monitor/diagnostics/transform_watch.h"

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <vector>

namespace deformable_contact_monitor {
namespace {

using diagnostic_msgs::DiagnosticStatus;

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

  static std::string value(const DiagnosticStatus& status, const std::string& key) {
    for (const auto& entry : status.values) {
      if (entry.key == key) return entry.value;
    }
    return "";
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
  EXPECT_EQ(value(status, "hand"), "never seen");
  EXPECT_EQ(value(status, "misses"), "4");
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
  EXPECT_EQ(value(describe(), "worst wait [s]"), "0.25");
  EXPECT_EQ(value(describe(), "worst wait [s]"), "0");
}

}  // namespace
}  // namespace deformable_contact_monitor
