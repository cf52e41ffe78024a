// Tests of when a detection must end within a budget.
#include "monitor/cycle/cycle_budget.h"

#include <gtest/gtest.h>

#include <chrono>

namespace deformable_contact_monitor {
namespace {

using std::chrono::milliseconds;

constexpr SteadyTime kArrival{std::chrono::hours(7)};

// A cycle whose detection ended, and whose states were out, so many milliseconds after its arrival.
void cycle(int detected, int published, CycleBudget* budget) {
  budget->record(budget->deadline(kArrival), kArrival + milliseconds(detected),
                 kArrival + milliseconds(published));
}

double deadlineMs(const CycleBudget& budget) {
  return 1e3 * toSeconds(budget.deadline(kArrival) - kArrival);
}

TEST(CycleBudgetTest, WithoutOneThereIsNoDeadline) {
  CycleBudget budget(0);
  EXPECT_EQ(budget.deadline(kArrival), SteadyTime::max());
  budget.record(SteadyTime::max(), kArrival, kArrival + milliseconds(3));
  EXPECT_EQ(budget.deadline(kArrival), SteadyTime::max());
}

TEST(CycleBudgetTest, WhatPublishingTakesIsKeptFree) {
  CycleBudget budget(0.02);
  EXPECT_DOUBLE_EQ(deadlineMs(budget), 20);
  cycle(5, 8, &budget);
  EXPECT_NEAR(deadlineMs(budget), 20, 1e-3) << "the longest does not count";
  cycle(5, 6, &budget);
  EXPECT_NEAR(deadlineMs(budget), 19, 1e-3);
  cycle(5, 7, &budget);
  EXPECT_NEAR(deadlineMs(budget), 18, 1e-3);
}

TEST(CycleBudgetTest, WhatDetectionTakesBeyondItsDeadlineIsKeptFreeToo) {
  CycleBudget budget(0.02);
  for (int i = 0; i < 2; ++i) cycle(22, 23, &budget);
  EXPECT_NEAR(deadlineMs(budget), 17, 1e-3);
}

TEST(CycleBudgetTest, HalfOfItIsTheDetections) {
  CycleBudget budget(0.02);
  for (int i = 0; i < 2; ++i) cycle(1, 500, &budget);
  EXPECT_NEAR(deadlineMs(budget), 10, 1e-3);
}

TEST(CycleBudgetTest, OldCyclesAreForgotten) {
  CycleBudget budget(0.02);
  for (int i = 0; i < 2; ++i) cycle(0, 9, &budget);
  EXPECT_NEAR(deadlineMs(budget), 11, 1e-3);
  for (int i = 0; i < 100; ++i) cycle(0, 1, &budget);
  EXPECT_NEAR(deadlineMs(budget), 19, 1e-3);
}

}  // namespace
}  // namespace deformable_contact_monitor
