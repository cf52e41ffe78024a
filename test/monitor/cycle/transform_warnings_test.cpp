// Tests how often missing transforms are said, and that it is said when they come.
#include "monitor/cycle/transform_warnings.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace deformable_contact_monitor {
namespace {

using std::chrono::milliseconds;
using Outcome = PoseAnswer::Outcome;
using Lines = std::vector<std::string>;

class TransformWarningsTest : public ::testing::Test {
 protected:
  // A cycle that asks for hand and cloth, and misses those with an outcome.
  TransformWarnings::Said look(int ms, Outcome hand, Outcome cloth) {
    TransformReport report;
    report.asked = {"hand", "cloth"};
    if (hand != Outcome::kFound) report.misses.push_back({"hand", answer(hand)});
    if (cloth != Outcome::kFound) report.misses.push_back({"cloth", answer(cloth)});
    return warnings_.look(
        report, [] { return std::string("known frames: 'base'"); }, kStart + milliseconds(ms));
  }

  static PoseAnswer answer(Outcome outcome) {
    PoseAnswer answer;
    answer.outcome = outcome;
    answer.problem = outcome == Outcome::kNever ? "never seen" : "late";
    return answer;
  }

  // The times [ms] of warnings during `to_ms` of cycles 10 ms apart.
  std::vector<int> warnedAt(int from_ms, int to_ms, Outcome hand, Outcome cloth) {
    std::vector<int> at;
    for (int ms = from_ms; ms < to_ms; ms += 10) {
      if (!look(ms, hand, cloth).warnings.empty()) at.push_back(ms);
    }
    return at;
  }

  const SteadyTime kStart{std::chrono::hours(7)};
  TransformWarnings warnings_;
};

TEST_F(TransformWarningsTest, WhatIsLateIsSaidOnceASecond) {
  EXPECT_EQ(warnedAt(0, 3500, Outcome::kLate, Outcome::kFound),
            (std::vector<int>{0, 1000, 2000, 3000}));
  EXPECT_EQ(look(4000, Outcome::kLate, Outcome::kFound).warnings,
            Lines{"UNKNOWN for want of a transform:\n  hand: late"});
  EXPECT_EQ(look(4100, Outcome::kFound, Outcome::kFound).news, Lines());
}

TEST_F(TransformWarningsTest, WhatWasNeverSeenIsSaidEverLessOften) {
  EXPECT_EQ(warnedAt(0, 25000, Outcome::kNever, Outcome::kFound),
            (std::vector<int>{0, 1000, 3000, 7000, 12000, 17000, 22000}));
  EXPECT_EQ(look(27000, Outcome::kNever, Outcome::kFound).warnings,
            Lines{"UNKNOWN for want of a transform:\n  hand: never seen\n  known frames: 'base'"});
}

TEST_F(TransformWarningsTest, AnotherBodyIsSaidSoon) {
  warnedAt(0, 12500, Outcome::kNever, Outcome::kFound);
  EXPECT_EQ(warnedAt(12500, 16000, Outcome::kNever, Outcome::kNever),
            (std::vector<int>{13000, 14000}));
}

TEST_F(TransformWarningsTest, ItIsSaidWhenItIsOver) {
  look(0, Outcome::kNever, Outcome::kNever);
  EXPECT_EQ(look(100, Outcome::kNever, Outcome::kNever).news, Lines());
  EXPECT_EQ(look(2000, Outcome::kNever, Outcome::kLate).news,
            Lines{"the transforms that were never seen are there now: of 'cloth', after 2.0 s"});
  EXPECT_EQ(look(2100, Outcome::kNever, Outcome::kFound).news, Lines()) << "once";
  EXPECT_EQ(look(2500, Outcome::kFound, Outcome::kFound).news,
            Lines{"the transforms that were never seen are there now: of 'hand', after 2.5 s"});
}

TEST(DescribeKnownFrames, ListsTheFirstInTheirOrder) {
  EXPECT_EQ(describeKnownFrames({}), "no frame is known");
  EXPECT_EQ(describeKnownFrames({"b", "c", "a"}), "known frames: 'a', 'b', 'c'");
  const std::string many = describeKnownFrames(std::vector<std::string>(1000, "frame"));
  EXPECT_NE(many.find(" and 990 more"), std::string::npos) << many;
}

TransformReport misses(int count) {
  TransformReport report;
  for (int i = 0; i < count; ++i) {
    TransformReport::Miss miss;
    miss.body = "link" + std::to_string(i);
    miss.answer.problem = "no data";
    report.misses.push_back(miss);
  }
  return report;
}

TEST(DescribeMisses, FiveAreListedTheOthersCounted) {
  EXPECT_EQ(describeMisses(misses(1)), "UNKNOWN for want of a transform:\n  link0: no data");
  EXPECT_EQ(describeMisses(misses(5)).find("more"), std::string::npos);
  const std::string seven = describeMisses(misses(7));
  EXPECT_NE(seven.find("\n  link4: no data\n  and 2 more"), std::string::npos) << seven;
  EXPECT_EQ(seven.find("link5"), std::string::npos);
}

}  // namespace
}  // namespace deformable_contact_monitor
