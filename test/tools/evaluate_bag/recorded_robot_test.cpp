// Checks that an evaluation knows no link meshes and no robot description that were recorded later,
// except where there is no earlier value.
#include <deformable_contact_monitor/ContactEvent.h>
#include <deformable_contact_monitor/LinkMeshes.h>
#include <gtest/gtest.h>
#include <sensor_msgs/JointState.h>

#include <stdexcept>
#include <string>

#include "monitor/diagnostics/robot_checks.h"
#include "tools/bags/bag_robots.h"
#include "written_bag.h"

namespace deformable_contact_monitor {

// Is written as LinkMeshes of which the end is missing.
struct CutLinkMeshes {};

}  // namespace deformable_contact_monitor

namespace ros::message_traits {
using deformable_contact_monitor::CutLinkMeshes;
using deformable_contact_monitor::LinkMeshes;
template <>
struct MD5Sum<CutLinkMeshes> : MD5Sum<LinkMeshes> {
  static const char* value(const CutLinkMeshes&) { return MD5Sum<LinkMeshes>::value(); }
};
template <>
struct DataType<CutLinkMeshes> : DataType<LinkMeshes> {
  static const char* value(const CutLinkMeshes&) { return DataType<LinkMeshes>::value(); }
};
template <>
struct Definition<CutLinkMeshes> : Definition<LinkMeshes> {
  static const char* value(const CutLinkMeshes&) { return Definition<LinkMeshes>::value(); }
};
}  // namespace ros::message_traits

namespace ros::serialization {
template <>
struct Serializer<deformable_contact_monitor::CutLinkMeshes> {
  template <typename Stream, typename T>
  static void allInOne(Stream& stream, T /*message*/) {
    std::uint32_t sequence = 0;
    stream.next(sequence);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};
}  // namespace ros::serialization

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

// The bag has only the beginning of a message.
TEST(RecordedRobot, LinkMeshesThatCannotBeReadHideTheLinks) {
  WrittenBag bag;
  bag.camera(0, 0);
  bag.links(0, 0);
  bag.meshes(1, 3);
  bag.add("/contact_monitor/robot_meshes", at(kPeriod * 4), CutLinkMeshes());
  bag.meshes(4, 3);
  EXPECT_EQ(statesOf(&bag), "CCC???");
}

// One more rejection changes nothing. What stands for the robot is one with shapes.
TEST(RecordedRobot, RejectedLinkMeshesAreNoOtherRobots) {
  for (const bool is_first : {true, false}) {
    WrittenBag bag;
    bag.camera(0, 0);
    if (!is_first) bag.links(0, 0);
    bag.links(kPeriod, 5, "finger");
    bag.links(kPeriod * 2, 6, "finger");
    if (is_first) bag.links(kPeriod * 3, 0);
    bag.meshes(4, 3);
    Found found = evaluate(&bag);
    EXPECT_EQ(found.states["cloth"], is_first ? "CCC" : "???");
    EXPECT_EQ(found.warnings.size(), 2U);
  }
  RobotGeometry robot;
  robot.links.push_back({"finger", "", TriangleMesh(), ""});
  const RobotGeometry hidden = withoutShapes(robot, "cut off");
  EXPECT_EQ(firstWithShapes({{ros::Time(1), hidden}, {ros::Time(2), robot}}), 1U);
  EXPECT_EQ(firstWithShapes({{ros::Time(1), robot}, {ros::Time(2), hidden}}), 0U);
  EXPECT_EQ(firstWithShapes({{ros::Time(1), hidden}}), 0U);
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
