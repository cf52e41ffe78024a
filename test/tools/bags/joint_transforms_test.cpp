// Frames posed by joints, against the URDF's own rule, written down with Eigen.
#include "tools/bags/joint_transforms.h"

#include <gtest/gtest.h>
#include <tf2_eigen/tf2_eigen.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace deformable_contact_monitor {
namespace {

constexpr const char* kRobot = R"(<robot name="test">
  <link name="base"><inertial><mass value="1"/></inertial></link>
  <link name="arm%1"/><link name="wheel"/><link name="slide"/><link name="follower"/>
  <link name="tool"/><link name="kite"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="arm%1"/>
    <origin xyz="1 2 3" rpy="0.1 0.2 0.3"/><axis xyz="0 3 4"/>
    <limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
  <joint name="roll" type="continuous"><parent link="arm%1"/><child link="wheel"/>
    <origin xyz="0 0 1" rpy="0 0 1.5"/><axis xyz="1 0 0"/></joint>
  <joint name="extend" type="prismatic"><parent link="wheel"/><child link="slide"/>
    <origin xyz="0 1 0" rpy="0 1 0"/><axis xyz="0 0 1"/>
    <limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
  <joint name="follow" type="revolute"><parent link="slide"/><child link="follower"/>
    <axis xyz="0 0 1"/><limit lower="-9" upper="9" effort="1" velocity="1"/>
    <mimic joint="shoulder" multiplier="-2" offset="0.25"/></joint>
  <joint name="mount" type="fixed"><parent link="follower"/><child link="tool"/>
    <origin xyz="0 0 0.5" rpy="-0.4 0 0"/></joint>
  <joint name="string" type="floating"><parent link="tool"/><child link="kite"/></joint>
</robot>)";

bool all(const std::string& /*frame*/) { return true; }

Eigen::Isometry3d origin(double x, double y, double z, double roll, double pitch, double yaw) {
  return Eigen::Translation3d(x, y, z) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX());
}

sensor_msgs::JointState stateOf(double shoulder, double roll, double extend) {
  sensor_msgs::JointState state;
  state.header.stamp = ros::Time(5);
  state.name = {"extend", "shoulder", "of another robot", "roll"};
  state.position = {extend, shoulder, 9, roll};
  return state;
}

void expectPose(const geometry_msgs::TransformStamped& found, const std::string& parent,
                const Eigen::Isometry3d& wanted) {
  EXPECT_EQ(found.header.frame_id, parent);
  const Eigen::Matrix4d difference = tf2::transformToEigen(found).matrix() - wanted.matrix();
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-12) << found.child_frame_id;
}

TEST(JointTransforms, AreTheUrdfsForAnyPositions) {
  const JointTransforms joints(kRobot, "", all);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> position(-7, 7);
  for (int trial = 0; trial < 200; ++trial) {
    const double shoulder = position(random), roll = position(random), extend = position(random);
    std::set<std::string> frames;
    for (const auto& found : joints.at(stateOf(shoulder, roll, extend))) {
      EXPECT_EQ(found.header.stamp, ros::Time(5));
      frames.insert(found.child_frame_id);
      if (found.child_frame_id == "arm%1") {
        expectPose(found, "base",
                   origin(1, 2, 3, 0.1, 0.2, 0.3) *
                       Eigen::AngleAxisd(shoulder, Eigen::Vector3d(0, 0.6, 0.8)));
      } else if (found.child_frame_id == "wheel") {
        expectPose(found, "arm%1",
                   origin(0, 0, 1, 0, 0, 1.5) * Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()));
      } else if (found.child_frame_id == "slide") {
        expectPose(found, "wheel", origin(0, 1, 0, 0, 1, 0) * Eigen::Translation3d(0, 0, extend));
      } else {
        expectPose(
            found, "slide",
            Eigen::Isometry3d(Eigen::AngleAxisd(0.25 - 2 * shoulder, Eigen::Vector3d::UnitZ())));
      }
    }
    EXPECT_EQ(frames, (std::set<std::string>{"arm%1", "wheel", "slide", "follower"}));
  }
}

TEST(JointTransforms, FixedJointsNeedNoPositionAndFloatingOnesAreUnknown) {
  const JointTransforms joints(kRobot, "", all);
  ASSERT_EQ(joints.fixed().size(), 1U);
  EXPECT_EQ(joints.fixed()[0].child_frame_id, "tool");
  expectPose(joints.fixed()[0], "follower", origin(0, 0, 0.5, -0.4, 0, 0));
}

TEST(JointTransforms, OnlyFramesThatAreWantedAndJointsThatHaveAPosition) {
  const JointTransforms joints(kRobot, "",
                               [](const std::string& frame) { return frame != "wheel"; });
  sensor_msgs::JointState state = stateOf(1, 2, 3);
  EXPECT_EQ(joints.at(state).size(), 3U);
  state.name = {"roll", "extend"};
  state.position = {1, 2};
  ASSERT_EQ(joints.at(state).size(), 1U);
  EXPECT_EQ(joints.at(state)[0].child_frame_id, "slide");
  state.position.clear();  // as of a message with efforts alone
  EXPECT_TRUE(joints.at(state).empty());
}

// As robot_state_publisher does: a position that was recorded counts more than the joint's rule.
TEST(JointTransforms, AMimicJointStandsWhereItWasRecorded) {
  const JointTransforms joints(kRobot, "",
                               [](const std::string& frame) { return frame == "follower"; });
  const auto expectAngle = [&joints](const sensor_msgs::JointState& state, double angle) {
    const auto found = joints.at(state);
    ASSERT_EQ(found.size(), 1U);
    expectPose(found[0], "slide",
               Eigen::Isometry3d(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ())));
  };
  sensor_msgs::JointState state;
  state.name = {"shoulder", "follow"};
  state.position = {1, 2};
  expectAngle(state, 2);
  state.name = {"follow"};
  state.position = {2};
  expectAngle(state, 2);
  state.name = {"shoulder", "shoulder"};  // the first of two
  state.position = {1, 3};
  expectAngle(state, -1.75);
}

TEST(JointTransforms, MimicJointsMayMimicOneAnother) {
  const std::string shoulder = "<mimic joint=\"shoulder\" multiplier=\"-2\" offset=\"0.25\"/>";
  std::string robot = kRobot;
  robot.replace(robot.find(shoulder), shoulder.size(),
                "<mimic joint=\"extend\" multiplier=\"3\"/>");
  const std::string axis = "<axis xyz=\"0 0 1\"/>";
  robot.insert(robot.find(axis), shoulder);  // of the joint "extend"
  const JointTransforms joints(robot, "",
                               [](const std::string& frame) { return frame == "follower"; });
  sensor_msgs::JointState state;
  state.name = {"shoulder"};
  state.position = {1};
  const auto found = joints.at(state);
  ASSERT_EQ(found.size(), 1U);
  expectPose(found[0], "slide",
             Eigen::Isometry3d(Eigen::AngleAxisd(3 * -1.75, Eigen::Vector3d::UnitZ())));
}

TEST(JointTransforms, WhatIsNoRobotIsRefused) {
  EXPECT_THROW(JointTransforms("<robot name='r'/>", "", all), std::invalid_argument);
  EXPECT_THROW(JointTransforms("no xml", "", all), std::invalid_argument);
}

}  // namespace
}  // namespace deformable_contact_monitor
