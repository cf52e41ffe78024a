// Checks that an evaluation knows no link meshes and no robot description that were recorded later,
// except where there is no earlier value.
#include <deformable_contact_monitor/ContactEvent.h>
#include <gtest/gtest.h>
#include <sensor_msgs/JointState.h>

#include <string>

#include "written_bag.h"

namespace deformable_contact_monitor {
namespace {

TEST(RecordedRobot, LinkMeshesHoldFromTheirRecordingOn) {
  WrittenBag bag;
  bag.camera(0, 0);
  bag.meshes(1, 2);
  bag.links(kPeriod * 3, 5);
  bag.meshes(3, 3);
  bag.links(kPeriod * 6, 0, "tool");
  bag.meshes(6, 3);
  bag.links(kPeriod * 9, 0, "tool");
  bag.meshes(9, 3);
  Found found = evaluate(&bag);
  EXPECT_EQ(found.states["cloth"], "-----CCCCCC");
  ASSERT_EQ(found.events.size(), 1U) << "the same robot again is no other robot";
  EXPECT_EQ(found.events[0].type, ContactEvent::BEGIN);
}

// Another robot ends what is known of the earlier one, as in the node.
TEST(RecordedRobot, AnotherRobotEndsContacts) {
  WrittenBag bag;
  bag.camera(0, 0);
  bag.links(0, 0);
  bag.meshes(1, 3);
  bag.links(kPeriod * 4, 5);
  bag.meshes(4, 1);
  const Found found = evaluate(&bag);
  ASSERT_EQ(found.events.size(), 2U);
  EXPECT_EQ(found.events[1].type, ContactEvent::END);
  EXPECT_EQ(found.events[1].reason, "robot changed");
}

// As in the node, whose links are UNKNOWN until the next message.
TEST(RecordedRobot, LinkMeshesThatAreRejectedHideTheLinks) {
  WrittenBag bag;
  bag.camera(0, 0);
  bag.links(0, 0);
  bag.meshes(1, 3);
  bag.links(kPeriod * 4, 5, "finger");
  bag.meshes(4, 3);
  bag.links(kPeriod * 7, 0);
  bag.meshes(7, 2);
  Found found = evaluate(&bag);
  EXPECT_EQ(found.states["cloth"], "CCC???CC");
  ASSERT_EQ(found.warnings.size(), 1U);
  EXPECT_NE(found.warnings[0].find("'finger' was sent twice"), std::string::npos);
}

// What holds before the first message that can be used is not known.
TEST(RecordedRobot, LinkMeshesThatAreRejectedFirstHideTheLinks) {
  WrittenBag bag;
  bag.camera(0, 0);
  bag.links(0, 5, "finger");
  bag.meshes(1, 3);
  bag.links(kPeriod * 4, 0);
  bag.meshes(4, 3);
  EXPECT_EQ(statesOf(&bag), "???CCC");
}

TEST(RecordedRobot, LinkMeshesThatAreAllRejectedAreAnError) {
  WrittenBag bag;
  bag.camera(0, 0);
  bag.links(0, 0, "finger");
  bag.meshes(1, 3);
  EXPECT_THROW(evaluate(&bag), std::runtime_error);
}

TEST(RecordedRobot, ARobotDescriptionHoldsFromItsRecordingOn) {
  WrittenBag bag;
  bag.camera(0, 0.05);
  bag.text(0, "/robot_description", urdf("prismatic", 0.05));
  bag.meshes(1, 3);
  bag.text(kPeriod * 4, "/robot_description", urdf("prismatic", 0.2));
  bag.meshes(4, 3);
  EXPECT_EQ(statesOf(&bag), "---CCC");
}

// Without TF, the URDF of that time poses the links, fixed ones too.
TEST(RecordedRobot, JointsPoseByTheRobotDescriptionOfTheirTime) {
  for (const std::string type : {"prismatic", "fixed"}) {
    WrittenBag bag;
    bag.camera(0, 0);
    bag.text(0, "/robot_description", urdf(type, 0.1, 2));
    for (int i = 1; i <= 6; ++i) {
      if (i == 4) bag.text(kPeriod * 3.9, "/robot_description", urdf(type, 0.1, 0));
      sensor_msgs::JointState state;
      state.header.stamp = at(kPeriod * i);
      state.name = {"j"};
      state.position = {0};
      bag.add("/joint_states", at(kPeriod * i), state);
      bag.mesh(at(kPeriod * i + kDelay), at(kPeriod * i), "cloth");
    }
    EXPECT_EQ(statesOf(&bag), "---CCC") << type;
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
