// Tests of heartbeats, of stamps that are mistrusted, and of deadlines within a budget.
#include "monitor/cycle/cycle_clock.h"

#include <gtest/gtest.h>

namespace deformable_contact_monitor {
namespace {

using std::chrono::milliseconds;

const SteadyTime kStart{std::chrono::hours(7)};

SteadyTime at(int ms) { return kStart + milliseconds(ms); }

TEST(CycleClockTest, TheFirstHeartbeatIsAfterASecond) {
  const CycleClock clock(0.5, 0, kStart);
  EXPECT_FALSE(clock.mustBeat(at(999)));
  EXPECT_TRUE(clock.mustBeat(at(1000)));
  EXPECT_EQ(clock.heartbeatDue(at(10)), at(1000));
}

TEST(CycleClockTest, ACyclePutsTheHeartbeatOffUntilItsMeshIsTooOld) {
  CycleClock impatient(0.5, 0, kStart), patient(3, 0, kStart);
  impatient.startCycle(at(500));
  EXPECT_FALSE(impatient.mustBeat(at(1499)));
  EXPECT_TRUE(impatient.mustBeat(at(1500))) << "a second at least";
  patient.startCycle(at(500));
  EXPECT_FALSE(patient.mustBeat(at(3499)));
  EXPECT_TRUE(patient.mustBeat(at(3500)));
}

TEST(CycleClockTest, HeartbeatsComeOnceASecond) {
  CycleClock clock(3, 0, kStart);
  clock.startHeartbeat(at(1200));
  EXPECT_FALSE(clock.mustBeat(at(2199)));
  EXPECT_TRUE(clock.mustBeat(at(2200)));
}

ros::Time atRos(int ms) { return ros::Time(50 + ms / 1000.0); }

TEST(CycleClockTest, AWaitLastsByTheSteadyClockWhereTimeIsReal) {
  CycleClock clock(0.5, 0, kStart);
  clock.update(atRos(0));
  const Wait wait = clock.startWait(0.05, at(0));
  EXPECT_FALSE(wait.isOver(at(49), atRos(1000)));
  EXPECT_TRUE(wait.isOver(at(50), atRos(0)));
  EXPECT_EQ(wait.passed(at(49), atRos(0)), milliseconds(49));
  EXPECT_EQ(wait.nextLook(at(10)), at(50));
}

TEST(CycleClockTest, AWaitLastsByBothClocksWhereTimeIsSimulated) {
  CycleClock clock(0.5, 0, kStart, true);
  clock.update(atRos(0));
  const Wait wait = clock.startWait(0.05, at(0));
  EXPECT_FALSE(wait.isOver(at(499), atRos(49))) << "a tenth of real time";
  EXPECT_TRUE(wait.isOver(at(500), atRos(50)));
  EXPECT_FALSE(wait.isOver(at(49), atRos(490))) << "ten times real time";
  EXPECT_TRUE(wait.isOver(at(50), atRos(500)));
  EXPECT_FALSE(wait.isOver(at(4999), atRos(0))) << "it stands still";
  EXPECT_TRUE(wait.isOver(at(5000), atRos(0)));
  EXPECT_TRUE(wait.isOver(at(5000), atRos(-10000))) << "it went back";
  EXPECT_EQ(wait.passed(at(100), atRos(10)), milliseconds(10));
  EXPECT_EQ(wait.passed(at(100), atRos(1000)), milliseconds(100));
  EXPECT_EQ(wait.passed(at(100), atRos(-10)), milliseconds(0));
  EXPECT_EQ(wait.nextLook(at(10)), at(50));
  EXPECT_EQ(wait.nextLook(at(100)), at(110)) << "ROS time wakes nobody";
  EXPECT_EQ(wait.nextLook(at(4995)), at(5000));
  EXPECT_TRUE(clock.startWait(0, at(0)).isOver(at(0), atRos(0)));
  EXPECT_TRUE(clock.startWait(7, at(0)).isOver(at(7000), atRos(0))) << "a long one is no longer";
}

TEST(CycleClockTest, HeartbeatsAreMissedBySimulatedTime) {
  CycleClock clock(0.5, 0, kStart, true);
  clock.update(atRos(0));
  clock.startCycle(at(0));
  clock.update(atRos(300));
  EXPECT_FALSE(clock.mustBeat(at(3000))) << "a tenth of real time";
  clock.update(atRos(1000));
  EXPECT_TRUE(clock.mustBeat(at(3000)));
  clock.startCycle(at(3000));
  EXPECT_FALSE(clock.mustBeat(at(7999)));
  EXPECT_TRUE(clock.mustBeat(at(8000))) << "it stands still";
  clock.startHeartbeat(at(8000));
  EXPECT_TRUE(clock.mustBeat(at(9000))) << "then once a second";
}

TEST(CycleClockTest, AfterAFailureItIsTriedAgainInASecond) {
  CycleClock clock(0.5, 0, kStart);
  EXPECT_EQ(clock.retryTime(at(300)), at(1300));
}

TEST(CycleClockTest, ASmallStepBackIsNoJump) {
  CycleClock clock(0.5, 0, kStart);
  EXPECT_EQ(clock.update(ros::Time(50)), 0);
  EXPECT_EQ(clock.update(ros::Time(60)), 0);
  EXPECT_EQ(clock.update(ros::Time(59.91)), 0);
  EXPECT_NEAR(clock.update(ros::Time(59.8)), 0.11, 1e-6);
  EXPECT_EQ(clock.rosTime(), ros::Time(59.8));
  EXPECT_EQ(clock.update(ros::Time(59.8)), 0) << "a jump is told once";
}

TEST(CycleClockTest, AClockThatBeginsIsNoJump) {
  CycleClock clock(0.5, 0, kStart);
  EXPECT_EQ(clock.update(ros::Time()), 0);
  EXPECT_EQ(clock.update(ros::Time(1e9)), 0);
}

TEST(CycleClockTest, LeftoversAreAheadOfTheClockWhileTheWindowIsOpen) {
  CycleClock clock(0.5, 0, kStart);
  clock.update(ros::Time(50));
  EXPECT_FALSE(clock.isLeftover(ros::Time(60), kStart)) << "nothing was reset yet";
  clock.startLeftoverWindow(at(100));
  EXPECT_TRUE(clock.isLeftover(ros::Time(60), at(100)));
  EXPECT_TRUE(clock.isLeftover(ros::Time(50.11), at(599)));
  EXPECT_FALSE(clock.isLeftover(ros::Time(50.09), at(599))) << "clocks differ a little";
  EXPECT_FALSE(clock.isLeftover(ros::Time(49), at(599)));
  EXPECT_FALSE(clock.isLeftover(ros::Time(60), at(600)));
}

// Such differences do not fit into a ros::Duration.
TEST(CycleClockTest, StampsAtTheEndsOfTimeAreSurvived) {
  CycleClock clock(0.5, 0, kStart);
  clock.update(ros::Time(4.2e9));
  EXPECT_GT(clock.update(ros::Time(1)), 4e9);
  clock.startLeftoverWindow(kStart);
  EXPECT_TRUE(clock.isLeftover(ros::Time(4.2e9), kStart));
}

// Records a cycle whose detection ended, and whose states were published, so many milliseconds
// after the arrival of its mesh.
void cycle(int detected, int published, CycleClock* clock) {
  clock->recordCycle(clock->deadline(kStart), kStart + milliseconds(detected),
                     kStart + milliseconds(published));
}

double deadlineMs(const CycleClock& clock) {
  return 1e3 * toSeconds(clock.deadline(kStart) - kStart);
}

TEST(CycleBudgetTest, WithoutOneThereIsNoDeadline) {
  CycleClock clock(0.5, 0, kStart);
  EXPECT_EQ(clock.deadline(kStart), SteadyTime::max());
  clock.recordCycle(SteadyTime::max(), kStart, kStart + milliseconds(3));
  EXPECT_EQ(clock.deadline(kStart), SteadyTime::max());
}

TEST(CycleBudgetTest, WhatPublishingTakesIsKeptFree) {
  CycleClock clock(0.5, 0.02, kStart);
  EXPECT_DOUBLE_EQ(deadlineMs(clock), 20);
  cycle(5, 8, &clock);
  EXPECT_NEAR(deadlineMs(clock), 20, 1e-3) << "the longest does not count";
  cycle(5, 6, &clock);
  EXPECT_NEAR(deadlineMs(clock), 19, 1e-3);
  cycle(5, 7, &clock);
  EXPECT_NEAR(deadlineMs(clock), 18, 1e-3);
}

TEST(CycleBudgetTest, WhatDetectionTakesBeyondItsDeadlineIsKeptFreeToo) {
  CycleClock clock(0.5, 0.02, kStart);
  for (int i = 0; i < 2; ++i) cycle(22, 23, &clock);
  EXPECT_NEAR(deadlineMs(clock), 17, 1e-3);
}

TEST(CycleBudgetTest, HalfOfItIsTheDetections) {
  CycleClock clock(0.5, 0.02, kStart);
  for (int i = 0; i < 2; ++i) cycle(1, 500, &clock);
  EXPECT_NEAR(deadlineMs(clock), 10, 1e-3);
}

TEST(CycleBudgetTest, OldCyclesAreForgotten) {
  CycleClock clock(0.5, 0.02, kStart);
  for (int i = 0; i < 2; ++i) cycle(0, 9, &clock);
  EXPECT_NEAR(deadlineMs(clock), 11, 1e-3);
  for (int i = 0; i < 100; ++i) cycle(0, 1, &clock);
  EXPECT_NEAR(deadlineMs(clock), 19, 1e-3);
}

}  // namespace
}  // namespace deformable_contact_monitor
