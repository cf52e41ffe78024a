// Tests of what the guard decides, on clocks of their own.
#include "tools/contact_guard/guard.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "guard_watch.h"

namespace deformable_contact_monitor {
namespace {

GuardParameters distances(double slow_m, double stop_m) {
  GuardParameters p;
  p.slow_distance_m = slow_m;
  p.stop_distance_m = stop_m;
  p.least_scale = 0.2;
  p.receding_m = 0.0625;
  return p;
}

void expectStop(const GuardOutput& output, const std::string& because) {
  EXPECT_TRUE(output.stop);
  EXPECT_EQ(output.scale, 0);
  EXPECT_EQ(output.because, because);
}

void expectScale(const GuardOutput& output, double scale) {
  EXPECT_FALSE(output.stop) << output.because;
  EXPECT_NEAR(output.scale, scale, 1e-5) << output.because;
  EXPECT_EQ(output.because.empty(), scale == 1);
}

TEST(GuardTest, slowsAndStopsWithTheDistance) {
  Watch watch(distances(1, 0.5));
  expectScale(watch.hear(none("hand", "cloth")), 1);
  expectScale(watch.hear(at(1)), 1);
  expectScale(watch.hear(at(0.75)), 0.6);
  expectScale(watch.hear(at(0.5 + 1e-6)), 0.2);
  expectStop(watch.hear(at(0.5)), "hand and cloth: NEAR, 0.5000 m");
  expectStop(watch.hear(at(0)), "hand and cloth: CONTACT");
}

TEST(GuardTest, stopsAtContactWhereThatIsTheDistance) {
  Watch watch(distances(1, 0));
  expectScale(watch.hear(at(1e-6F)), 0.2);
  expectStop(watch.hear(at(0)), "hand and cloth: CONTACT");
  expectScale(watch.hear(at(0.03125)), 0.2 + 0.8 * 0.03125);
}

TEST(GuardTest, neverLetsTheScaleRiseOnTheWayIn) {
  Watch watch(distances(1, 0.25));
  double before = 1;
  for (float distance_m = 1.25; distance_m > 0; distance_m -= 0.01F) {
    const double scale = watch.hear(at(distance_m)).scale;
    EXPECT_LE(scale, before);
    EXPECT_GE(scale, distance_m > 0.25 ? 0.2 : 0);
    before = scale;
  }
  EXPECT_EQ(before, 0);
}

TEST(GuardTest, leavesAtFullSpeed) {
  Watch watch(distances(1, 0.25));
  watch.hear(at(0.5));
  expectStop(watch.hear(at(0)), "hand and cloth: CONTACT");
  expectStop(watch.hear(at(0.25)), "hand and cloth: NEAR, 0.2500 m");
  expectScale(watch.hear(at(0.375)), 1);
  expectScale(watch.hear(at(0.5)), 1);
  expectScale(watch.hear(at(0.46875)), 1);                // noise
  expectScale(watch.hear(at(0.4375)), 0.2 + 0.8 * 0.25);  // comes again
  expectScale(watch.hear(at(0.46875)), 0.2 + 0.8 * 0.21875 / 0.75);
  expectScale(watch.hear(at(0.5)), 1);
}

TEST(GuardTest, whatWasUnknownWhileItReceded) {
  const ContactState unknown = stateOf("hand", "cloth", ContactState::UNKNOWN, kNaN);
  Watch watch(distances(1, 0.25));
  watch.hear(at(0));
  watch.hear(at(0.375));
  expectScale(watch.hear(at(0.5)), 1);
  watch.hear(unknown);
  expectScale(watch.hear(at(0.5)), 0.2 + 0.8 / 3);  // it may have turned meanwhile
  expectScale(watch.hear(at(0.5625)), 1);
  watch.wait(1);  // silence
  watch.decide();
  expectScale(watch.hear(at(0.5625)), 0.2 + 0.8 * 0.3125 / 0.75);
  watch.hear(none("hand", "cloth"));
  expectScale(watch.hear(at(0.75)), 0.2 + 0.8 * 2 / 3);  // has come anew
}

// Otherwise a robot that turns back would reach the cloth before it is slowed.
TEST(GuardTest, byDefaultTheDistanceAloneCounts) {
  GuardParameters p = distances(1, 0.25);
  p.receding_m = GuardParameters().receding_m;
  Watch watch(p);
  watch.hear(at(0));
  expectScale(watch.hear(at(0.625)), 0.6);
  expectScale(watch.hear(at(0.4375)), 0.2 + 0.8 * 0.25);
}

TEST(GuardTest, aLatchSeesACauseThatIsOverBeforeTheNextOutput) {
  GuardParameters p = distances(1, 0.25);
  p.latch = true;
  Watch watch(p);
  watch.hear(none("hand", "cloth"));
  EXPECT_EQ(watch.release(), "");
  watch.store({stateOf("hand", "cloth", ContactState::PASSED, 0.5)});
  expectStop(watch.hear(none("hand", "cloth")), "latched: hand and cloth: PASSED");
}

TEST(GuardTest, theNearestOfThePairsThatCountDecides) {
  const ContactState other = stateOf("arm", "cloth", ContactState::NEAR, 0.5);
  Watch all(distances(1, 0));
  expectScale(all.hear({at(0.75), other}), 0.6);
  GuardParameters p = distances(1, 0);
  p.links = {"hand"};
  Watch hand(p);
  expectScale(hand.hear({at(0.75), other}), 0.8);
  expectScale(hand.hear({at(0.75), stateOf("arm", "cloth", ContactState::UNKNOWN, kNaN)}), 0.8);
  EXPECT_NEAR(hand.guard.nearest(ros::Time(hand.ros_s)), 0.75, 1e-6);
}

TEST(GuardTest, stopsWhenAnythingIsMissing) {
  Watch watch(distances(1, 0));
  expectStop(watch.decide(), "no states came yet");
  expectStop(watch.hear(std::vector<ContactState>()), "no pair is monitored");
  expectStop(watch.hear(stateOf("hand", "cloth", ContactState::UNKNOWN, kNaN)),
             "hand and cloth: UNKNOWN: late");
  expectStop(watch.hear(stateOf("hand", "cloth", ContactState::NEAR, kNaN)),
             "hand and cloth: its distance is no number");
  expectStop(watch.hear(stateOf("hand", "cloth", ContactState::PASSED, 0.5)),
             "hand and cloth: PASSED");
  expectScale(watch.hear(stateOf("hand", "cloth", ContactState::ALLOWED, kNaN)), 1);
  watch.wait(0.51);
  expectStop(watch.decide(), "no states came for 0.510 s");
}

TEST(GuardTest, requiredNamesMustBeThere) {
  GuardParameters p = distances(1, 0);
  p.links = {"hand", "arm"};
  p.required_bodies = {"cable"};
  Watch watch(p);
  expectStop(watch.hear(none("hand", "cloth")), "arm is in no state; there are cloth, hand");
  expectStop(watch.hear({none("hand", "cloth"), none("arm", "cloth")}),
             "required cable is in no state");
  expectStop(watch.hear({none("hand", "cloth"), none("arm", "cloth"), none("base", "cable")}),
             "required cable is in no state");
  expectScale(watch.hear({none("hand", "cloth"), none("arm", "cable")}), 1);
}

TEST(GuardTest, stopsWhereRosTimeStandsStill) {
  Watch watch(distances(1, 0));
  expectScale(watch.hear(none("hand", "cloth")), 1);
  watch.steady += fromSeconds(0.49);
  expectScale(watch.decide(), 1);
  watch.steady += fromSeconds(0.02);
  expectStop(watch.decide(), "ROS time stands still for 0.510 s");
  expectScale(watch.hear(none("hand", "cloth")), 1);
}

TEST(GuardTest, stopsWhereRosTimeCrawlsAndNothingComes) {
  Watch watch(distances(1, 0));
  watch.hear(none("hand", "cloth"));
  for (int i = 0; i < 6; ++i) {
    watch.ros_s += 0.001;
    watch.steady += fromSeconds(0.1);
    watch.decide();
  }
  expectStop(watch.decide(), "no states came for 0.600 s of wall time");
}

TEST(GuardTest, stopsWhereRosTimeJumps) {
  Watch watch(distances(1, 0));
  watch.hear(none("hand", "cloth"));
  watch.ros_s -= 0.2;
  watch.steady += fromSeconds(0.01);
  expectStop(watch.decide(), "ROS time went back by 0.200 s");
  watch.wait(0.15);
  expectStop(watch.decide(), "ROS time went back by 0.200 s");
  expectScale(watch.hear(none("hand", "cloth")), 1);
  watch.ros_s += 50;
  watch.steady += fromSeconds(0.01);
  expectStop(watch.decide(), "no states came for 50.000 s");
  expectScale(watch.hear(none("hand", "cloth")), 1);
}

// One monitor says CONTACT, and the other, which was told to allow that, says ALLOWED.
TEST(GuardTest, stopsWhileTwoNodesPublish) {
  const ContactState allowed = stateOf("hand", "cloth", ContactState::ALLOWED, kNaN);
  const std::string two =
      "two nodes publish contact_monitor/contact_states: /contact_monitor and /mgr; stop one of "
      "them";
  Watch watch(distances(1, 0));
  expectScale(watch.hear(none("hand", "cloth")), 1);
  for (int i = 0; i < 10; ++i) {
    watch.publisher = "/mgr";
    expectStop(watch.hear(allowed), two);
    EXPECT_EQ(watch.guard.nearest(ros::Time(watch.ros_s)), 0);
    watch.publisher = "/contact_monitor";
    expectStop(watch.hear(at(i % 2 == 0 ? 0.75F : 0.0F)), two);
  }
  // A monitor that has nothing to do publishes once a second.
  watch.publisher = "/mgr";
  watch.hear(allowed);
  watch.publisher = "/contact_monitor";
  for (int i = 0; i < 19; ++i) expectStop(watch.hear(at(0.75)), two);
  watch.hear(at(0.75));
  expectScale(watch.hear(at(0.75)), 0.8);
}

TEST(GuardTest, aMonitorThatIsStartedAgainIsNoSecondNode) {
  Watch watch(distances(1, 0));
  expectScale(watch.hear(none("hand", "cloth")), 1);
  watch.cycle = 0;
  expectScale(watch.hear(at(0.75)), 0.8);
  // One of another name takes its place.
  watch.publisher = "/other";
  EXPECT_TRUE(watch.hear(at(0.75)).stop);
  for (int i = 0; i < 20; ++i) watch.hear(at(0.75));
  expectScale(watch.decide(), 0.8);
}

TEST(GuardTest, twoNodesThatHaveEndedAreSilent) {
  GuardParameters p = distances(1, 0);
  p.latch = true;
  Watch watch(p);
  watch.hear(none("hand", "cloth"));
  EXPECT_EQ(watch.release(), "");
  watch.publisher = "/mgr";
  watch.hear(none("hand", "cloth"));
  watch.wait(0.51);
  expectStop(watch.decide(), "no states came for 0.510 s of wall time");
  watch.wait(2);
  expectStop(
      watch.hear(none("hand", "cloth")),
      "latched: two nodes publish contact_monitor/contact_states: /contact_monitor and /mgr; "
      "stop one of them");
}

TEST(GuardTest, aLatchedStopStaysUntilItIsReleased) {
  GuardParameters p = distances(1, 0);
  p.latch = true;
  Watch watch(p);
  EXPECT_EQ(watch.release(), "no states came yet");
  expectStop(watch.hear(none("hand", "cloth")), "latched: not released since its start");
  EXPECT_EQ(watch.release(), "");
  expectScale(watch.decide(), 1);
  expectStop(watch.hear(at(0)), "hand and cloth: CONTACT");
  EXPECT_EQ(watch.release(), "hand and cloth: CONTACT");
  expectStop(watch.hear(none("hand", "cloth")), "latched: hand and cloth: CONTACT");
  EXPECT_TRUE(watch.guard.isLatched());
  EXPECT_EQ(watch.release(), "");
  expectScale(watch.hear(none("hand", "cloth")), 1);
  EXPECT_FALSE(watch.guard.isLatched());
}

TEST(GuardTest, oneDistanceForSlowAndStop) {
  Watch watch(distances(0.5, 0.5));
  expectScale(watch.hear(at(0.5 + 1e-6)), 1);
  expectStop(watch.hear(at(0.5)), "hand and cloth: NEAR, 0.5000 m");
}

}  // namespace
}  // namespace deformable_contact_monitor
