// What may hold what.
#include "monitor/rules/attach_object.h"

#include <gtest/gtest.h>

namespace deformable_contact_monitor {
namespace {

const std::vector<ObjectParameters> kObjects{{"cloth", "", 0, true}, {"cable", "", 0, true}};

RobotGeometry robot() {
  RobotGeometry robot;
  robot.link_names = {"arm", "hand", "tool_frame"};
  robot.links.push_back({"arm", "test", TriangleMesh(), ""});
  return robot;
}

TEST(AttachObject, AnyLinkOfTheRobotMayHold) {
  const RobotGeometry known = robot();
  EXPECT_EQ(attachProblem("cloth", {"hand", "tool_frame"}, kObjects, &known), "");
  EXPECT_EQ(attachProblem("cable", {}, kObjects, &known), "");
  EXPECT_EQ(attachProblem("cable", {}, kObjects, nullptr), "") << "to release needs no robot";
}

TEST(AttachObject, UnknownNamesAreRefusedAllOfThem) {
  const RobotGeometry known = robot();
  EXPECT_EQ(attachProblem("clot", {"hnd", "arm", "xxxxxxxx"}, kObjects, &known),
            "no object 'clot' is monitored (did you mean 'cloth'?); the robot has no link 'hnd' "
            "(did you mean 'hand'?); the robot has no link 'xxxxxxxx'");
  EXPECT_EQ(attachProblem("", {""}, kObjects, &known).find("no object '' is monitored"), 0U);
  EXPECT_NE(attachProblem("cloth", {""}, kObjects, &known), "");
  EXPECT_NE(attachProblem("cloth", {"*"}, kObjects, &known), "") << "no wildcards";
  EXPECT_NE(attachProblem("hand", {}, kObjects, &known), "") << "a link is no object";
  EXPECT_EQ(attachProblem("cloth", {"hand"}, kObjects, nullptr), "there is no robot");
}

TEST(AttachObject, WhatIsHeldInWords) {
  EXPECT_EQ(describeHeld({}), "nothing is held");
  EXPECT_EQ(describeHeld({{"cloth", {"finger", "hand"}}, {"cable", {"arm"}}}),
            "held: cable by arm; cloth by finger, hand");
}

}  // namespace
}  // namespace deformable_contact_monitor
