// Tests which bodies the states of a question move: links, rigid objects, and robots on robots.
#include "monitor/planning/moved_bodies.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "planning/state_questions_support.h"
#include "refusal.h"

namespace deformable_contact_monitor {
namespace {

using MovedBodiesTest = StateQuestionsTest;

TEST_F(MovedBodiesTest, ARigidObjectGoesWithTheLinkAboveItInTf) {
  parameters_.pair_classes = {false, false, false, false, true, true};
  const Names turn{"turn"}, cloth{"cloth"};
  EXPECT_EQ(states(ask({kAtCloth}, turn, 0, cloth)),
            " object 'cloth' has no monitored pair with anything that these joints move "
            "(~pair_classes, ~links)");
  now_ += ros::Duration(0.0625);
  put("mount", "hand", -0.125);
  put("tool_tip", "mount", 0.0625);
  put("arm", "base", 0, 0.5);
  put("hand", "arm", 1);
  EXPECT_EQ(states(ask({kFree, kAtCloth}, turn, 0, cloth)), "-C");
  EXPECT_EQ(ask({kAtCloth}, turn, 0, cloth).link, Names{"tool"});
  EXPECT_TRUE(ask({kAtCloth}, turn, 0, {"tool"}).object_stamps[0].isZero());
}

TEST_F(MovedBodiesTest, AnAttachedRigidObjectGoesWithItsLink) {
  parameters_.pair_classes = {false, false, false, false, true, true};
  const Names turn{"turn"}, cloth{"cloth"};
  RigidGrip grip{"hand", {}};
  grip.link_from_object.translation[0] = -0.125;
  requests_.attach("tool", {"hand"}, nullptr, std::make_shared<const RigidGrip>(grip));
  const StatesChecked answer = ask({kFree, kAtCloth}, turn, 0, cloth);
  EXPECT_EQ(states(answer), "-C");
  EXPECT_EQ(answer.link[1], "tool");
  requests_.attach("tool", {});
  EXPECT_FALSE(ask({kFree}, turn, 0, cloth).success);
}

// The tool is on the hand, but its own transform does not come any more.
TEST_F(MovedBodiesTest, AStaleFrameLeavesOnlyItsBodyUnknown) {
  transforms_.clear();
  const auto put_robot = [&] {
    put("arm", "base", 0);
    put("hand", "arm", 1);
  };
  put_robot();
  put("tool_tip", "hand", 0.0625);
  now_ += ros::Duration(1.25);
  put_robot();
  give();
  const std::string late =
      " tool: TF from 'tool_tip' to 'base' is late: wanted 101.250000000, newest available "
      "100.000000000";
  for (const Names& joints : {Names{"turn"}, Names{"turn", "slide"}}) {
    const bool is_one = joints.size() == 1;
    const auto positions =
        is_one ? std::vector<double>{kFree, kAtCloth} : std::vector<double>{kFree, 0, kAtCloth, 0};
    for (const float margin : {0.0F, 0.5F}) {
      const StatesChecked answer = ask(positions, joints, margin);
      EXPECT_EQ(states(answer), "?C" + late);
      EXPECT_EQ(answer.stamp, now_);
      EXPECT_EQ(answer.link[1], "arm");
      EXPECT_TRUE(std::isnan(answer.distance[0]));
    }
    EXPECT_EQ(states(ask(positions, joints, 0, {"tool"})), "??" + late);
    requests_.changeAllowedContacts({false, {}, {allowed("tool", "cloth")}});
    EXPECT_EQ(states(ask(positions, joints)), "-C") << "nothing is asked of the tool";
    requests_.changeAllowedContacts({true, {}, {}});
  }
  put("tool_tip", "hand", 0.0625);
  EXPECT_EQ(states(ask({kFree, kAtCloth})), "-C") << "no pair stays left out";
  EXPECT_EQ(states(ask({kFree, kAtCloth}, {"turn"}, 0, {"tool"})), "-C");
}

TEST_F(MovedBodiesTest, AMeshStaysAlsoIfALinkSawIt) {
  now_ += ros::Duration(0.125);
  put("arm", "base", 0, 0);
  put("hand", "arm", 0);
  put("tool_tip", "base", -5);
  give(0, "hand");
  EXPECT_EQ(states(ask({kFree, kAtCloth})), "-C");
}

TEST_F(MovedBodiesTest, LinksOfARobotThatStandsOnAnotherGoWithIt) {
  robot_ = load({{kRobot, "", "", {}}, {kRobot, "", "top/", {}}});
  requests_.changeAllowedContacts({false, {}, {allowed("arm", "cloth"), allowed("hand", "cloth")}});
  put("top/base", "arm", 0.5);
  put("top/arm", "top/base", 0);
  put("top/hand", "top/arm", 1);
  const StatesChecked answer = ask({kFree, kAtCloth});
  EXPECT_EQ(states(answer), "-C");
  EXPECT_EQ(ask({0.5}, {"top/turn"}).state.size(), 1U);
}

TEST_F(MovedBodiesTest, WithoutTheTransformOfAStillJointAllIsUnknown) {
  transforms_.clear();
  put("tool_tip", "base", -5);
  EXPECT_EQ(states(ask({kFree})), "? TF from 'arm' to 'base' never seen");
  EXPECT_EQ(states(ask({kFree, 0}, {"turn", "slide"})), "-");
}

TEST_F(MovedBodiesTest, JointsThatAreNotNamedStayWhereTfHasThem) {
  now_ += ros::Duration(0.125);
  put("arm", "base", 0, 1);
  put("hand", "arm", 2);  // a slide of 1, from where the hand does not reach back to the sheet
  const StatesChecked answer = ask({kFree, kAtCloth}, {"turn"}, 1);
  EXPECT_EQ(answer.stamp, now_);
  EXPECT_EQ(states(answer), "nC");
  EXPECT_EQ(answer.link[1], "arm");
  EXPECT_EQ(states(ask({kAtCloth, 0.1, kAtCloth, 0.9}, {"turn", "slide"})), "CC");
  // Only the hand moves, so the arm does not count.
  now_ += ros::Duration(0.125);
  give();
  put("hand", "arm", 1);
  put("tool_tip", "base", -5);
  put("arm", "base", 0, kAtCloth);
  EXPECT_EQ(states(ask({0.1, 0.9}, {"slide"})), "C-");
}

// The base is posed by the question, although no joint of the URDFs carries it. Its links sort
// before those that carry it.
TEST_F(MovedBodiesTest, ARobotOnAnotherGoesWithItAlsoIfJointsOfBothAreNamed) {
  robot_ = load({{kRobot, "", "", {}}, {kRobot, "", "above/", {}}});
  requests_.changeAllowedContacts({false, {}, {allowed("arm", "cloth"), allowed("hand", "cloth")}});
  put("mount", "arm", 0.25);
  put("above/base", "mount", 0.25);
  const Names joints{"turn", "above/turn", "above/slide"};
  const std::vector<double> positions{kFree, 0, 0, kAtCloth, 0, 0, kAtCloth, kAtCloth, 0};
  EXPECT_EQ(states(ask(positions, joints)), "-C-");
  now_ += ros::Duration(0.125);
  put("arm", "base", 0, kAtCloth);
  put("mount", "arm", 0.25);
  put("above/base", "mount", 0.25);
  put("hand", "arm", 1);
  EXPECT_EQ(states(ask(positions, joints)), "-C-") << "wherever the arm is now";
}

// Such trees come from localisation, whose frames are above those of the robot.
TEST_F(MovedBodiesTest, ARobotWhoseRootIsBelowItsOwnLinkInTfIsNotOnAnother) {
  transforms_.clear();
  put("base", "arm", 0);
  put("hand", "arm", 1);
  put("tool_tip", "arm", -5);
  EXPECT_EQ(states(ask({kFree, kAtCloth})), "-C");
}

TEST_F(MovedBodiesTest, WhatMayMoveAlongLeavesItOpen) {
  const auto put_arm = [&] {
    transforms_.clear();
    put("arm", "base", 0);
    put("hand", "arm", 1);
  };
  put_arm();
  const std::string open =
      "?C tool: it is not known whether it moves with the joints: TF from 'tool_tip' to 'base' "
      "never seen";
  EXPECT_EQ(states(ask({kFree, kAtCloth})), open);
  EXPECT_EQ(states(ask({kFree, kAtCloth}, {"turn"}, 0, {"cloth"})), open);
  put("tool_tip", "mount", 1);
  EXPECT_EQ(states(ask({kFree})).substr(0, 6), "? tool") << "the mount may be on the arm";
  requests_.changeAllowedContacts({false, {}, {allowed("tool", "cloth")}});
  EXPECT_EQ(states(ask({kFree, kAtCloth})), "-C");
  requests_.changeAllowedContacts({true, {}, {}});
  put("mount", "hand", 0);
  EXPECT_EQ(states(ask({kFree, kAtCloth})), "-C");

  robot_ = load({{kRobot, "", "", {}}, {kRobot, "", "other/", {}}});
  expectIn("? other/arm: it is not known whether it moves with the joints: TF frame",
           states(ask({kFree})));
  put("other/base", "base", -5);
  EXPECT_EQ(states(ask({kFree})), "-") << "the URDF has its links on its base";
}

}  // namespace
}  // namespace deformable_contact_monitor
