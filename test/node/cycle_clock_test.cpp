// When the monitor makes cycles and heartbeats, and which stamps it mistrusts.
#include "node/cycle_clock.h"

#include <gtest/gtest.h>

namespace deformable_contact_monitor {
namespace {

using std::chrono::milliseconds;

const CycleClock::SteadyTime kStart{std::chrono::hours(7)};

CycleClock::SteadyTime at(int ms) { return kStart + milliseconds(ms); }

TEST(CycleClockTest, TheFirstCycleMayBeAtOnceTheFirstHeartbeatAfterASecond) {
  const CycleClock clock(10, 0.5, kStart);
  EXPECT_TRUE(clock.mayCycle(kStart));
  EXPECT_FALSE(clock.mustBeat(at(999)));
  EXPECT_TRUE(clock.mustBeat(at(1000)));
}

TEST(CycleClockTest, CyclesKeepToTheRate) {
  CycleClock clock(10, 0.5, kStart);
  clock.startCycle(at(5));
  EXPECT_FALSE(clock.mayCycle(at(104)));
  EXPECT_TRUE(clock.mayCycle(at(105)));
}

TEST(CycleClockTest, WithoutARateEveryMeshHasItsCycle) {
  CycleClock clock(0, 0.5, kStart);
  clock.startCycle(at(5));
  EXPECT_TRUE(clock.mayCycle(at(5)));
}

TEST(CycleClockTest, ACyclePutsTheHeartbeatOffUntilItsMeshIsTooOld) {
  CycleClock impatient(10, 0.5, kStart), patient(10, 3, kStart);
  impatient.startCycle(at(500));
  EXPECT_FALSE(impatient.mustBeat(at(1499)));
  EXPECT_TRUE(impatient.mustBeat(at(1500))) << "a second at least";
  patient.startCycle(at(500));
  EXPECT_FALSE(patient.mustBeat(at(3499)));
  EXPECT_TRUE(patient.mustBeat(at(3500)));
}

TEST(CycleClockTest, HeartbeatsComeOnceASecond) {
  CycleClock clock(10, 3, kStart);
  clock.startHeartbeat(at(1200));
  EXPECT_FALSE(clock.mustBeat(at(2199)));
  EXPECT_TRUE(clock.mustBeat(at(2200)));
  EXPECT_TRUE(clock.mayCycle(at(1200))) << "a heartbeat is no cycle";
}

TEST(CycleClockTest, WakesForTheNextCycleIfAMeshWaitsElseForTheHeartbeat) {
  CycleClock clock(10, 0.5, kStart);
  clock.startCycle(at(0));
  EXPECT_EQ(clock.wakeTime(true), at(100));
  EXPECT_EQ(clock.wakeTime(false), at(1000));
  CycleClock slow(0.5, 0.5, kStart);
  slow.startCycle(at(0));
  EXPECT_EQ(slow.wakeTime(true), at(1000)) << "the heartbeat comes first";
}

TEST(CycleClockTest, AfterAFailureItIsTriedAgainInASecond) {
  CycleClock clock(10, 0.5, kStart);
  EXPECT_EQ(clock.retryTime(at(300)), at(1300));
}

TEST(CycleClockTest, ASmallStepBackIsNoJump) {
  CycleClock clock(10, 0.5, kStart);
  EXPECT_EQ(clock.update(ros::Time(50)), 0);
  EXPECT_EQ(clock.update(ros::Time(60)), 0);
  EXPECT_EQ(clock.update(ros::Time(59.91)), 0);
  EXPECT_NEAR(clock.update(ros::Time(59.8)), 0.11, 1e-6);
  EXPECT_EQ(clock.rosTime(), ros::Time(59.8));
  EXPECT_EQ(clock.update(ros::Time(59.8)), 0) << "a jump is told once";
}

TEST(CycleClockTest, AClockThatBeginsIsNoJump) {
  CycleClock clock(10, 0.5, kStart);
  EXPECT_EQ(clock.update(ros::Time()), 0);
  EXPECT_EQ(clock.update(ros::Time(1e9)), 0);
}

TEST(CycleClockTest, LeftoversAreAheadOfTheClockWhileTheWindowIsOpen) {
  CycleClock clock(10, 0.5, kStart);
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
  CycleClock clock(10, 0.5, kStart);
  clock.update(ros::Time(4.2e9));
  EXPECT_GT(clock.update(ros::Time(1)), 4e9);
  clock.startLeftoverWindow(kStart);
  EXPECT_TRUE(clock.isLeftover(ros::Time(4.2e9), kStart));
}

}  // namespace
}  // namespace deformable_contact_monitor
