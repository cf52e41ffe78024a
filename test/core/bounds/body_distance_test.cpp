// Tests which decision (contact, near, none, open) follows from the bounds of a distance.
#include "core/body_distance.h"

#include <gtest/gtest.h>

#include <cmath>

namespace deformable_contact_monitor {
namespace {

PairDecision decisionOf(float low_m, float high_m, float margin_m, float tolerance_m) {
  BodyDistance distance;
  distance.low_m = low_m;
  distance.high_m = high_m;
  return decide(distance, margin_m, tolerance_m);
}

TEST(BodyDistance, OfWhichNothingIsKnownIsOpen) {
  EXPECT_EQ(PairDecision::kOpen, decide(BodyDistance(), 0, 0));
  EXPECT_EQ(PairDecision::kOpen, decide(BodyDistance(), 1, 1));
}

TEST(BodyDistance, IsNoneOnlyBeyondTheMargin) {
  EXPECT_EQ(PairDecision::kNone, decisionOf(1e-44F, INFINITY, 0, 0.01F));
  EXPECT_EQ(PairDecision::kOpen, decisionOf(0, INFINITY, 0, 0.01F));
  EXPECT_EQ(PairDecision::kOpen, decisionOf(0.02F, INFINITY, 0.02F, 0.01F));
  EXPECT_EQ(PairDecision::kNone, decisionOf(0.0201F, INFINITY, 0.02F, 0.01F));
}

TEST(BodyDistance, IsAContactWithinTheToleranceAndNotBeyond) {
  EXPECT_EQ(PairDecision::kContact, decisionOf(0, 0.01F, 0, 0.01F));
  EXPECT_EQ(PairDecision::kOpen, decisionOf(0, 0.0101F, 0, 0.01F));
  EXPECT_EQ(PairDecision::kContact, decisionOf(0, 0, 0, 0));
  EXPECT_EQ(PairDecision::kNone, decisionOf(0.001F, 0.01F, 0, 0.01F)) << "certainly apart is more";
}

TEST(BodyDistance, IsNearOnceItIsKnownToTheTolerance) {
  EXPECT_EQ(PairDecision::kNear, decisionOf(0.011F, 0.02F, 0.02F, 0.01F));
  EXPECT_EQ(PairDecision::kOpen, decisionOf(0.005F, 0.02F, 0.02F, 0.01F)) << "too wide";
  EXPECT_EQ(PairDecision::kOpen, decisionOf(0, 0.02F, 0.02F, 0.015F)) << "may touch";
  EXPECT_EQ(PairDecision::kOpen, decisionOf(0.0199F, 0.0301F, 0.02F, 0.01F)) << "may be farther";
}

TEST(BodyDistance, RoundingLeavesNothingOpen) {
  for (float m = 1e-44F; m < 1e38F; m *= 7) {
    EXPECT_EQ(PairDecision::kNear, decisionOf(m, std::nextafter(m, INFINITY), m, 0)) << m;
  }
}

TEST(BodyDistance, OfAListIsWhatTheListSays) {
  BodyDistance distance;
  distance.is_listed = true;
  EXPECT_EQ(PairDecision::kNone, decide(distance, 0.01F, 0));
  distance.contact_count = 1;
  distance.high_m = 0.005F;
  EXPECT_EQ(PairDecision::kNear, decide(distance, 0.01F, 0));
  distance.high_m = 0;
  EXPECT_EQ(PairDecision::kContact, decide(distance, 0.01F, 0));
}

}  // namespace
}  // namespace deformable_contact_monitor
