// Tests poses of links by joint positions against the URDF's own rule, written down with Eigen, on
// a robot with joints of all types and on the Panda; and the joints that are refused.
#include "robot/robot_kinematics.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "refusal.h"
#include "robot/robot_poses.h"
#include "robot/urdf_document.h"
#include "robot_test_support.h"

namespace deformable_contact_monitor {
namespace {

using Names = std::vector<std::string>;

constexpr const char* kRobot = R"(<robot name="test">
  <link name="base"/><link name="arm"/><link name="wheel"/><link name="slide"/>
  <link name="follower"/><link name="second"/><link name="tool"/><link name="kite"/>
  <link name="cart"/><link name="tail"/><link name="side"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="arm"/>
    <origin xyz="1 2 3" rpy="0.1 0.2 0.3"/><axis xyz="0 3 4"/>
    <limit lower="-1" upper="2" effort="1" velocity="1"/></joint>
  <joint name="roll" type="continuous"><parent link="arm"/><child link="wheel"/>
    <origin xyz="0 0 1" rpy="0 0 1.5"/><axis xyz="1 0 0"/>
    <limit effort="1" velocity="1"/></joint>
  <joint name="extend" type="prismatic"><parent link="wheel"/><child link="slide"/>
    <origin xyz="0 1 0" rpy="0 1 0"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="0.5" effort="1" velocity="1"/></joint>
  <joint name="follow" type="revolute"><parent link="slide"/><child link="follower"/>
    <axis xyz="0 0 1"/><limit lower="-9" upper="9" effort="1" velocity="1"/>
    <mimic joint="shoulder" multiplier="-2" offset="0.25"/></joint>
  <joint name="follow_it" type="prismatic"><parent link="follower"/><child link="second"/>
    <axis xyz="1 0 0"/><limit lower="-9" upper="9" effort="1" velocity="1"/>
    <mimic joint="follow" multiplier="3" offset="1"/></joint>
  <joint name="mount" type="fixed"><parent link="second"/><child link="tool"/>
    <origin xyz="0 0 0.5" rpy="-0.4 0 0"/></joint>
  <joint name="string" type="floating"><parent link="tool"/><child link="kite"/></joint>
  <joint name="floor" type="planar"><parent link="kite"/><child link="cart"/><axis xyz="0 0 1"/></joint>
  <joint name="wag" type="revolute"><parent link="cart"/><child link="tail"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="bend" type="revolute"><parent link="base"/><child link="side"/><axis xyz="1 0 0"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
</robot>)";

std::vector<RobotJoint> joints() { return readUrdf(kRobot, GeometryKind::kCollision).joints; }

Eigen::Isometry3d origin(double x, double y, double z, double roll, double pitch, double yaw) {
  return Eigen::Translation3d(x, y, z) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX());
}

Eigen::Isometry3d turned(double angle, const Eigen::Vector3d& axis) {
  return Eigen::Isometry3d(Eigen::AngleAxisd(angle, axis));
}

Eigen::Matrix4d matrixOf(const RigidTransform& pose) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      matrix(row, column) = pose.rotation[3 * row + column];
    }
    matrix(row, 3) = pose.translation[row];
  }
  return matrix;
}

RigidTransform toPose(const Eigen::Isometry3d& from) {
  RigidTransform pose;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      pose.rotation[3 * row + column] = from.linear()(row, column);
    }
    pose.translation[row] = from.translation()[row];
  }
  return pose;
}

// Returns the poses of the moved links by name. `present` has the poses of the links that stay.
std::map<std::string, Eigen::Matrix4d> pose(JointMotion& motion,
                                            const std::map<std::string, Eigen::Isometry3d>& present,
                                            const std::vector<double>& positions) {
  std::vector<RigidTransform> given;
  for (const std::string& link : motion.presentLinks()) given.push_back(toPose(present.at(link)));
  motion.setPresent(given);
  std::vector<RigidTransform> poses(motion.movedLinks().size());
  motion.pose(positions.data(), poses.data());
  std::map<std::string, Eigen::Matrix4d> found;
  for (std::size_t i = 0; i < poses.size(); ++i) found[motion.movedLinks()[i]] = matrixOf(poses[i]);
  return found;
}

void expectNear(const Eigen::Matrix4d& found, const Eigen::Isometry3d& wanted, const char* what) {
  EXPECT_LT((found - wanted.matrix()).cwiseAbs().maxCoeff(), 1e-12) << what;
}

TEST(RobotKinematics, ChainsMimicsAndFixedJointsAreTheUrdfs) {
  JointMotion motion(joints(), {"extend", "wag", "shoulder"});
  EXPECT_EQ(motion.movedLinks(),
            (Names{"arm", "wheel", "slide", "follower", "second", "tool", "kite", "cart", "tail"}));
  EXPECT_EQ(motion.presentLinks(), (Names{"base", "arm", "wheel", "tool", "kite", "cart"}));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-3, 3);
  for (int trial = 0; trial < 100; ++trial) {
    const double extend = any(random), wag = any(random), shoulder = any(random);
    const Eigen::Isometry3d base = origin(any(random), 1, 2, any(random), 0.3, -0.7);
    const double roll = any(random);
    // The joints that are not named stay as these links are now, wherever the robot is now.
    const Eigen::Isometry3d wheel_in_arm =
        origin(0, 0, 1, 0, 0, 1.5) * turned(roll, Eigen::Vector3d::UnitX());
    const Eigen::Isometry3d kite_in_tool = origin(0, 0, any(random), 0.1, any(random), 0);
    const Eigen::Isometry3d cart_in_kite = origin(any(random), 1, 0, 0, 0, any(random));
    const Eigen::Isometry3d arm_now = origin(5, any(random), 5, 1, 1, 1), tool_now = arm_now;
    const auto found = pose(motion,
                            {{"base", base},
                             {"arm", arm_now},
                             {"wheel", arm_now * wheel_in_arm},
                             {"tool", tool_now},
                             {"kite", tool_now * kite_in_tool},
                             {"cart", tool_now * kite_in_tool * cart_in_kite}},
                            {extend, wag, shoulder});
    const Eigen::Isometry3d arm =
        base * origin(1, 2, 3, 0.1, 0.2, 0.3) * turned(shoulder, Eigen::Vector3d(0, 0.6, 0.8));
    const Eigen::Isometry3d slide =
        arm * wheel_in_arm * origin(0, 1, 0, 0, 1, 0) * Eigen::Translation3d(0, 0, extend);
    const double follow = 0.25 - 2 * shoulder;
    const Eigen::Isometry3d second = slide * turned(follow, Eigen::Vector3d::UnitZ()) *
                                     Eigen::Translation3d(3 * follow + 1, 0, 0);
    const Eigen::Isometry3d tool = second * origin(0, 0, 0.5, -0.4, 0, 0);
    expectNear(found.at("arm"), arm, "arm");
    expectNear(found.at("slide"), slide, "slide");
    expectNear(found.at("second"), second, "second");
    expectNear(found.at("tool"), tool, "tool");
    expectNear(found.at("tail"),
               tool * kite_in_tool * cart_in_kite * turned(wag, Eigen::Vector3d::UnitY()), "tail");
  }
}

TEST(RobotKinematics, OnlyWhatTheJointsCarryMoves) {
  const JointMotion side(joints(), {"bend"});
  EXPECT_EQ(side.movedLinks(), Names{"side"});
  EXPECT_EQ(side.presentLinks(), Names{"base"});
  const JointMotion none(joints(), {});
  EXPECT_TRUE(none.movedLinks().empty());
}

TEST(RobotKinematics, AMimicJointThatIsNamedHasThePositionThatIsGiven) {
  JointMotion motion(joints(), {"follow"});
  EXPECT_EQ(motion.presentLinks(), (Names{"slide", "tool", "kite", "cart", "tail"}));
  std::map<std::string, Eigen::Isometry3d> present;
  for (const std::string& link : motion.presentLinks()) present[link].setIdentity();
  const auto found = pose(motion, present, {0.5});
  expectNear(found.at("follower"), turned(0.5, Eigen::Vector3d::UnitZ()), "follower");
  expectNear(found.at("second"),
             turned(0.5, Eigen::Vector3d::UnitZ()) * Eigen::Translation3d(2.5, 0, 0), "second");
}

TEST(RobotKinematics, LimitsAreTheUrdfsAndAContinuousJointHasNone) {
  const JointMotion motion(joints(), {"roll", "shoulder", "extend"});
  const auto beyond = [&](double roll, double shoulder, double extend) {
    const double positions[] = {roll, shoulder, extend};
    return motion.isBeyondLimits(positions);
  };
  EXPECT_FALSE(beyond(100, 2, 0));
  EXPECT_FALSE(beyond(-100, -1, 0.5));
  EXPECT_TRUE(beyond(0, 2.0000001, 0));
  EXPECT_TRUE(beyond(0, -1.0000001, 0));
  EXPECT_TRUE(beyond(0, 0, -0.0000001));
}

TEST(RobotKinematics, WhatIsNoJointOrHasNoPositionIsRefusedByName) {
  const auto why = [](const Names& names) {
    return refusal([&] { JointMotion(joints(), names); });
  };
  EXPECT_EQ(why({"sholder"}), "the robot has no joint 'sholder' (did you mean 'shoulder'?)");
  EXPECT_EQ(why({"mount"}), "joint 'mount' is fixed, so it has no position");
  EXPECT_EQ(
      why({"string"}),
      "joint 'string' is floating, and no single number is its position: leave it out, and it "
      "stays where it is");
  expectIn("joint 'floor' is planar", why({"floor"}));
  EXPECT_EQ(why({"roll", "bend", "roll"}), "joint 'roll' is named twice");
  EXPECT_EQ(why({"roll", "bend"}), "");
}

TEST(RobotKinematics, BadJointsAreRefusedByName) {
  std::vector<RobotJoint> bad = joints();
  for (RobotJoint& joint : bad) {
    if (joint.name == "bend") joint.axis.clear();
    if (joint.name == "follow") joint.mimics = "follow_it";  // which mimics it
  }
  EXPECT_EQ(refusal([&] { JointMotion(bad, {"bend"}); }),
            "joint 'bend' has an origin that is not finite, or an axis without direction");
  EXPECT_EQ(JointMotion(bad, {"wag"}).movedLinks(), Names{"tail"});
  std::vector<RobotJoint> twice = joints();
  twice.push_back(twice.front());
  twice.back().parent = "other base";
  twice.back().child = "other link";
  EXPECT_EQ(refusal([&] { JointMotion(twice, {twice.front().name}); }),
            "several robots have a joint '" + twice.front().name +
                "'; give each robot its own frame_prefix");
}

RobotGeometry robotOf(const std::string& urdf) {
  return loadRobotGeometry(urdf, {}, [](const std::string& uri) { return uri; });
}

// Returns a robot of these joints, "type name parent child [joint that it mimics]".
RobotGeometry robotOfJoints(const std::vector<std::string>& joints) {
  std::string text, links;
  std::set<std::string> names;
  for (const std::string& joint : joints) {
    std::istringstream words(joint);
    std::string type, name, parent, child, mimics;
    words >> type >> name >> parent >> child >> mimics;
    names.insert({parent, child});
    text += "<joint name='" + name + "' type='" + type + "'><parent link='" + parent +
            "'/><child link='" + child + "'/><axis xyz='0 0 1'/><limit lower='-1' upper='1' " +
            "effort='1' velocity='1'/>" +
            (mimics.empty() ? "" : "<mimic joint='" + mimics + "' offset='0.1'/>") + "</joint>";
  }
  for (const std::string& name : names) links += "<link name='" + name + "'/>";
  return robotOf("<robot name='r'>" + links + text + "</robot>");
}

// Returns why a question that names `joint`, and poses of all links, are refused.
std::pair<std::string, std::string> refusals(const RobotGeometry& robot, const std::string& joint) {
  std::string of_all = refusal([&] { RobotPoses(robot, ""); });
  for (const std::string& warning : geometryWarnings(robot)) {
    EXPECT_NE(warning.find("; links stand where TF says"), std::string::npos);
  }
  return {refusal([&] { JointMotion(robot.joints, {joint}); }), of_all};
}

TEST(RobotKinematics, AMimicOfNoJointIsRefusedByNameWhereItWouldBeMoved) {
  const std::string arm = "revolute arm base upper", turn = "revolute turn base table";
  for (const auto& [mimics, why] :
       std::map<std::string, std::string>{{"amr", "'amr', but there is no joint 'amr'"},
                                          {"slide", "itself"},
                                          {"turn2", "'turn2', but there is no joint 'none'"},
                                          {"round", "'round', and that leads round in a circle"},
                                          {"still", "'still', and 'still' has no position"}}) {
    const RobotGeometry robot = robotOfJoints(
        {arm, turn, "prismatic slide upper hand " + mimics, "revolute turn2 table a none",
         "revolute round table b round2", "revolute round2 table c round", "fixed still table d"});
    const std::string text = "joint 'slide' mimics " + why;
    EXPECT_EQ(refusals(robot, "arm").first, text + "; name it too, or correct the URDF");
    EXPECT_EQ(refusals(robot, "slide").first, "");
    EXPECT_EQ(refusal([&] { JointMotion(robot.joints, {"arm", "slide"}); }), "");
    const std::vector<std::string> warnings = geometryWarnings(robot);
    EXPECT_EQ(std::count_if(warnings.begin(), warnings.end(),
                            [&](const std::string& line) { return line.find(text + ";") == 0; }),
              1);
    const RobotGeometry alone = robotOfJoints({arm, turn, "prismatic slide upper hand amr"});
    EXPECT_EQ(refusals(alone, "turn"),
              std::make_pair(std::string(), std::string("robot description: joint 'slide' mimics "
                                                        "'amr', but there is no joint 'amr'")));
  }
  EXPECT_EQ(refusals(robotOfJoints({arm, "prismatic slide upper hand arm"}), "arm"),
            std::make_pair(std::string(), std::string()));
}

TEST(RobotKinematics, LoopsAndLinksOfSeveralParentsAreRefusedByName) {
  const std::string ok = "revolute ok base side", ja = "revolute ja base a";
  for (const auto& [joints, why] : std::map<Names, std::string>{
           {{ok, ja, "revolute jb b b", "revolute jc b c"}, "joint 'jb' joins a link to itself"},
           {{ok, ja, "revolute jb c b", "revolute jc b c"}, "joints 'jb', 'jc' form a loop"},
           {{ok, ja, "revolute jb a b", "revolute jc base b"},
            "link 'b' has several parents, by the joints 'jb', 'jc'"},
           // The loop can be reached, so whoever follows it must end.
           {{ok, ja, "revolute jb a b", "revolute jc b a"},
            "link 'a' has several parents, by the joints 'ja', 'jc'"}}) {
    const RobotGeometry robot = robotOfJoints(joints);
    EXPECT_EQ(refusals(robot, "ok"), std::make_pair(std::string(), "robot description: " + why));
    EXPECT_EQ(refusals(robot, "jb").first, why);
    EXPECT_EQ(geometryWarnings(robot).size(), 1U) << why;
  }
}

TEST(RobotPosesTest, AllLinksFollowTheJointsFromTheFrameThatIsAskedFor) {
  const RobotGeometry robot = robotOf(kRobot);
  RobotPoses from_base(robot, ""), from_tool(robot, "tool");
  Names names;
  for (const RobotJoint& joint : from_base.joints()) names.push_back(joint.name);
  EXPECT_EQ(names, (Names{"bend", "extend", "roll", "shoulder", "wag"}));
  EXPECT_EQ(from_base.links().size(), 11U);
  EXPECT_EQ(from_base.movedCount(), 10U);
  EXPECT_EQ(from_base.links().back(), "base");
  const std::map<std::string, double> positions = {{"bend", 0.6},     {"extend", 0.4}, {"roll", -2},
                                                   {"shoulder", 1.2}, {"wag", 0.9},    {"none", 7}};
  const Eigen::Isometry3d arm =
      origin(1, 2, 3, 0.1, 0.2, 0.3) * turned(1.2, Eigen::Vector3d(0, 0.6, 0.8));
  const Eigen::Isometry3d wheel =
      arm * origin(0, 0, 1, 0, 0, 1.5) * turned(-2, Eigen::Vector3d::UnitX());
  const double follow = 0.25 - 2 * 1.2;
  const Eigen::Isometry3d tool =
      wheel * origin(0, 1, 0, 0, 1, 0) * Eigen::Translation3d(0, 0, 0.4) *
      turned(follow, Eigen::Vector3d::UnitZ()) * Eigen::Translation3d(3 * follow + 1, 0, 0) *
      origin(0, 0, 0.5, -0.4, 0, 0);
  const Eigen::Isometry3d tail = tool * turned(0.9, Eigen::Vector3d::UnitY());
  const auto at_base = from_base.at(positions), at_tool = from_tool.at(positions);
  for (const auto& [link, place] :
       std::map<std::string, Eigen::Isometry3d>{{"base", Eigen::Isometry3d::Identity()},
                                                {"arm", arm},
                                                {"tool", tool},
                                                {"cart", tool},
                                                {"tail", tail},
                                                {"side", turned(0.6, Eigen::Vector3d::UnitX())}}) {
    expectNear(at_base.at(link).matrix(), place, link.c_str());
    expectNear(at_tool.at(link).matrix(), tool.inverse() * place, link.c_str());
  }
  expectNear(from_base.at({}).at("wheel").matrix(),
             origin(1, 2, 3, 0.1, 0.2, 0.3) * origin(0, 0, 1, 0, 0, 1.5), "at zero");
}

TEST(RobotPosesTest, NamesAreThoseOfTheUrdf) {
  const RobotGeometry robot = robotOf(
      R"(<robot name="%nr"><link name="base"/><link name="%narm"/>
      <joint name="%nslide" type="prismatic"><parent link="base"/><child link="%narm"/>
      <axis xyz="1 0 0"/><limit lower="0" upper="1" effort="1" velocity="1"/></joint></robot>)");
  EXPECT_NEAR(RobotPoses(robot, "base").at({{"%nslide", 0.3}}).at("%narm").translation().x(), 0.3,
              1e-12);
  EXPECT_EQ(refusal([&] { RobotPoses(robot, "arm"); }), "frame 'arm' is no link of robot '%nr'");
  EXPECT_EQ(RobotPoses(robotOf("<robot name='r'><link name='only'/></robot>"), "").links(),
            Names{"only"});
}

TEST(RobotKinematics, JointsOfSeveralRobotsHaveTheirPrefix) {
  const RobotGeometry robots = loadRobots({{kRobot, "", "left/", {}}, {kRobot, "", "right/", {}}},
                                          {}, [](const std::string& uri) { return uri; });
  EXPECT_EQ(robots.joints.size(), 2 * joints().size());
  const JointMotion motion(robots.joints, {"right/shoulder"});
  EXPECT_EQ(motion.presentLinks().front(), "right/base");
  for (const std::string& link : motion.movedLinks()) EXPECT_EQ(link.substr(0, 6), "right/");
  EXPECT_EQ(std::count(motion.movedLinks().begin(), motion.movedLinks().end(), "right/second"), 1);
  EXPECT_EQ(
      std::count(motion.presentLinks().begin(), motion.presentLinks().end(), "right/follower"), 0)
      << "it mimics the shoulder of the same robot";
  EXPECT_EQ(refusal([&] { JointMotion(robots.joints, {"shoulder"}); }).substr(0, 33),
            "the robot has no joint 'shoulder'");
}

}  // namespace
}  // namespace deformable_contact_monitor
