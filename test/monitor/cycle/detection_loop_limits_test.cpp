// Tests of how long a cycle may take: max_cycle_s and budget_ms.
#include <chrono>
#include <string>
#include <utility>

#include "loop_fixture.h"

namespace deformable_contact_monitor {
namespace {

using LimitsTest = LoopTest;

// A mesh that takes too long costs its own object time, and nobody else.
TEST_F(LimitsTest, WhoRunsOutOfTimeHasLessOfItAndSharesNoCycle) {
  const auto budgetMs = [this] {
    return std::chrono::duration<double, std::milli>(detector_.deadline - steady_time_).count();
  };
  parameters_.max_cycle_s = 2;
  detector_.out_of_time = true;
  give(0, 50);
  give(1, 50);
  EXPECT_EQ(step(), Lines{"cycle 50: *cloth@50 *cable@50"});
  EXPECT_EQ(budgetMs(), 2000);
  give(0, 50.25);
  give(1, 50.25);
  EXPECT_EQ(step(), Lines{"cycle 50.25: *cloth@50.25 cable@50.25"});
  EXPECT_EQ(budgetMs(), 500);
  detector_.out_of_time = false;
  EXPECT_EQ(step(), Lines{"cycle 50.25: cloth@50.25 *cable@50.25"});
  EXPECT_EQ(budgetMs(), 500);
  give(1, 50.5);
  EXPECT_EQ(step(), Lines{"cycle 50.5: cloth@50.25 *cable@50.5"});
  EXPECT_EQ(budgetMs(), 2000) << "its last cycle ended in time";
  give(0, 50.5);
  EXPECT_EQ(step(), Lines{"cycle 50.5: *cloth@50.5 cable@50.5"});
  EXPECT_EQ(budgetMs(), 500);
}

TEST_F(LimitsTest, ABudgetRunsFromTheMeshsArrivalAndKeepsTimeForPublishing) {
  steady_time_ = std::chrono::steady_clock::now();  // as arrivals are
  parameters_.budget_ms = 20;
  parameters_.max_cycle_s = 600;
  const auto deadlineMs = [this](double stamp_s) {
    give(0, stamp_s);
    give(1, stamp_s);
    step();
    return 1e3 * toSeconds(detector_.deadline - said_.arrival);
  };
  EXPECT_NEAR(deadlineMs(50), 20, 1e-3);
  said_.published = steady_time_ + std::chrono::milliseconds(3);
  EXPECT_NEAR(deadlineMs(50.25), 20, 1e-3);
  EXPECT_NEAR(deadlineMs(50.5), 20, 1e-3) << "one hiccup does not count";
  EXPECT_NEAR(deadlineMs(50.75), 17, 1e-3);
}

// A mesh may wait in a queue or for other cycles. If meshes share a cycle, the first arrival
// counts.
TEST_F(LimitsTest, WhatAMeshWaitedIsOffItsBudget) {
  parameters_.budget_ms = 20;
  parameters_.max_cycle_s = 600;
  double stamp_s = 50;
  for (const auto& [cloth_s, cable_s] : {std::pair(0.012, 0.005), std::pair(0.005, 0.012)}) {
    const SteadyTime before = std::chrono::steady_clock::now();
    give(0, stamp_s, "base", 0, 3, cloth_s);
    give(1, stamp_s, "base", 0, 3, cable_s);
    steady_time_ = std::chrono::steady_clock::now();
    EXPECT_EQ(step().size(), 1U);
    EXPECT_GE(detector_.deadline, before + std::chrono::milliseconds(8));
    EXPECT_LE(detector_.deadline, steady_time_ + std::chrono::milliseconds(8));
    stamp_s += 0.25;
  }
}

// A slow simulator lets a mesh wait for transforms for long, of which the budget knows only the
// simulated time.
TEST_F(LimitsTest, OfASimulatorsWaitItsOwnTimeIsOffTheBudget) {
  steady_time_ = std::chrono::steady_clock::now();
  is_simulated_ = true;
  parameters_.pair_classes = {false, false, true, false};
  parameters_.tf_timeout_s = 0.05;
  parameters_.budget_ms = 20;
  addTransform(&transforms_, "camera", 49.5);
  give(0, 50, "camera");
  const SteadyTime taken = steady_time_;
  EXPECT_EQ(step(), Lines());
  EXPECT_EQ(stepAfter(80, 8), Lines());
  addTransform(&transforms_, "camera", 50);
  EXPECT_EQ(stepAfter(20, 2).size(), 1U);
  EXPECT_NEAR(1e3 * toSeconds(detector_.deadline - taken), 100 + 20 - 10, 5);
}

// The user asked for the budget, so a cycle that it ends does not cost the next one time.
TEST_F(LimitsTest, ABudgetThatEndsCostsNobodyTime) {
  steady_time_ = std::chrono::steady_clock::now();
  parameters_.budget_ms = 20;
  parameters_.max_cycle_s = 600;
  detector_.out_of_time = true;
  give(0, 50);
  give(1, 50);
  EXPECT_EQ(step(), Lines{"cycle 50: *cloth@50 *cable@50"});
  give(0, 50.25);
  give(1, 50.25);
  EXPECT_EQ(step(), Lines{"cycle 50.25: *cloth@50.25 *cable@50.25"}) << "they share a cycle still";
}

TEST_F(LimitsTest, TheEarlierOfBudgetAndLongestCycleHolds) {
  steady_time_ = std::chrono::steady_clock::now();
  parameters_.budget_ms = 60000;
  parameters_.max_cycle_s = 2;
  give(0, 50);
  give(1, 50);
  step();
  EXPECT_EQ(detector_.deadline, steady_time_ + std::chrono::seconds(2));
}

TEST_F(LimitsTest, WithoutOthersNobodyIsShortOfTime) {
  parameters_.objects.pop_back();
  parameters_.pair_classes = {false, false, true, false};
  detector_.out_of_time = true;
  for (const double stamp_s : {50.0, 50.25, 50.5}) {
    give(0, stamp_s);
    EXPECT_EQ(step().size(), 1U);
    EXPECT_EQ(detector_.deadline - steady_time_, std::chrono::seconds(1)) << stamp_s;
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
