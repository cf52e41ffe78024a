// What the diagnostics say of a tolerance and a budget.
#include "monitor/diagnostics/trade_watch.h"

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <gtest/gtest.h>

#include <string>

#include "sample_report.h"

namespace deformable_contact_monitor {
namespace {

using diagnostic_msgs::DiagnosticStatus;

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
  std::string value(const std::string& key) {
    for (const auto& entry : describe().values) {
      if (entry.key == key) return entry.value;
    }
    return "missing";
  }

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

}  // namespace
}  // namespace deformable_contact_monitor
