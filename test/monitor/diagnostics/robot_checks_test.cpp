// Tests how a robot is described at start, and with which robot the monitor does not start.
#include "monitor/diagnostics/robot_checks.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "refusal.h"

namespace deformable_contact_monitor {
namespace {

// One triangle, 0.5 m high, and two links whose files are missing.
RobotGeometry robot() {
  RobotGeometry robot;
  robot.links = {
      {"hand", "hand.stl", {{0, 0, 0, 0.25F, 0, 0, 0, 0, 0.5F}, {0, 1, 2}}, ""},
      {"arm", "arm.stl", TriangleMesh(), "link 'arm': arm.stl: no such file"},
      {"foot", "foot.stl", TriangleMesh(), "link 'foot': foot.stl: no such file"},
  };
  return robot;
}

std::string refusalOf(const MonitorParameters& parameters) {
  return refusal<std::runtime_error>([&parameters] { checkRobot(robot(), parameters); });
}

TEST(RobotChecksTest, WarnsOfLinksSizesAndTheSrdf) {
  RobotGeometry odd = robot();
  odd.links[0].mesh.vertices[3] = 900;
  std::vector<std::string> warnings = robotWarnings(odd, MonitorParameters());
  ASSERT_EQ(warnings.size(), 3U) << "without an SRDF, nothing is said of one";
  EXPECT_EQ(warnings[0], "link 'arm': arm.stl: no such file; the link is UNKNOWN");
  EXPECT_EQ(warnings[1], "link 'foot': foot.stl: no such file; the link is UNKNOWN");
  EXPECT_NE(warnings[2].find("if its file is in millimetres"), std::string::npos);
  odd.robots = {{"panda", {"hand", "arm", "foot"}, {}}};
  odd.robots[0].srdf.robot = "pr2";
  warnings = robotWarnings(odd, MonitorParameters());
  EXPECT_EQ(warnings.back(), "the SRDF is of robot 'pr2', but the robot is 'panda'");
}

TEST(RobotChecksTest, WarnsOfARobotWithoutLinks) {
  MonitorParameters parameters;
  parameters.robots = {{"one", "left/"}, {"two", "right/"}};
  RobotGeometry left;
  left.link_names = {"left/arm", "left/hand"};
  EXPECT_EQ(
      robotWarnings(left, parameters),
      std::vector<std::string>{"~robots: no link has the prefix 'right/'; one LinkMeshes must "
                               "have the links of all robots"});
  left.link_names.insert("right/hand");
  EXPECT_EQ(robotWarnings(left, parameters).size(), 0U);
}

TEST(RobotChecksTest, RigidObjectsAreNamesOfTheSrdfAndOfNoLink) {
  MonitorParameters parameters;
  parameters.rigids = {{"table", "table"}};
  EXPECT_EQ(refusalOf(parameters), "");
  RobotGeometry robot_on_table = robot();
  robot_on_table.robots = {{"", {"hand", "arm", "foot"}, {}}};
  robot_on_table.robots[0].srdf.disabled = {{"foot", "table", ""}};
  EXPECT_EQ(robotWarnings(robot_on_table, parameters).size(), 2U);
  EXPECT_EQ(robotWarnings(robot_on_table, MonitorParameters()).size(), 3U);
  parameters.rigids = {{"hand", "table"}};
  EXPECT_EQ(refusalOf(parameters),
            "'hand' is the name of a link and of a rigid object; rename the object");
}

TEST(RobotChecksTest, StrictListsAllThatIsMissingAtOnce) {
  MonitorParameters parameters;
  EXPECT_EQ(refusalOf(parameters), "");
  parameters.strict_geometry = true;
  EXPECT_EQ(refusalOf(parameters),
            "strict_geometry is on, but these links have no usable geometry:\n"
            "  link 'arm': arm.stl: no such file\n"
            "  link 'foot': foot.stl: no such file");
}

TEST(RobotChecksTest, ALinkAndAnObjectOfOneNameAreRefused) {
  MonitorParameters parameters;
  parameters.objects = {{"cloth", "", 0, true}, {"foot", "", 0, true}};
  EXPECT_EQ(refusalOf(parameters),
            "'foot' is the name of a link and of an object; rename the object");
}

TEST(RobotChecksTest, ALinkWithoutANameIsRefused) {
  RobotGeometry geometry = robot();
  geometry.links[0].link.clear();
  EXPECT_EQ(refusal<std::runtime_error>([&] { checkRobot(geometry, MonitorParameters()); }),
            "a link has no name");
}

TEST(RobotChecksTest, ALinkNamedAsAHeldPartIsRefused) {
  RobotGeometry geometry = robot();
  MonitorParameters parameters;
  parameters.objects = {{"cloth", "", 0, true}};
  geometry.links[0].link = "cloth:hem";
  EXPECT_NO_THROW(checkRobot(geometry, parameters));
  geometry.links[0].link = "cloth:held";
  EXPECT_EQ(refusal<std::runtime_error>([&] { checkRobot(geometry, parameters); }),
            "'cloth:held' is the name of a link and of the part of 'cloth' that ~attach_object "
            "makes; rename the object");
}

// Without a URDF, the longest prefix of a link's name says whose it is.
TEST(RobotChecksTest, LinksThatWereSentBelongToTheRobotOfTheirPrefix) {
  RobotGeometry sent;
  sent.link_names = {"a/hand", "a/b/hand", "hand", "a/b/arm"};
  Srdf srdf;
  srdf.disabled_links = {"hand"};
  setSrdfs({{"one", "a/"}, {"two", "a/b/"}, {"three", ""}}, {srdf, Srdf(), Srdf()}, &sent);
  ASSERT_EQ(sent.robots.size(), 3U);
  EXPECT_EQ(sent.robots[0].links, (std::set<std::string>{"a/b/hand", "a/b/arm"}));
  EXPECT_EQ(sent.robots[1].links, (std::set<std::string>{"a/hand"}));
  EXPECT_EQ(sent.robots[1].srdf.disabled_links, (std::set<std::string>{"a/hand"}));
  EXPECT_TRUE(sent.robots[0].srdf == Srdf());
  EXPECT_EQ(sent.robots[2].links, (std::set<std::string>{"hand"}));
  // Of two robots with one prefix, nobody knows which has the link.
  srdf.disabled = {{"hand", "arm", ""}};
  setSrdfs({{"one", "a/"}, {"two", "a/"}}, {srdf, srdf}, &sent);
  ASSERT_EQ(sent.robots.size(), 1U);
  EXPECT_EQ(sent.robots[0].srdf.disabled.size(), 2U);
  EXPECT_TRUE(sent.robots[0].srdf.disabled_links.empty());
}

TEST(RobotChecksTest, EachLinkIsDescribedWithItsSizeAndMargin) {
  MonitorParameters parameters;
  parameters.margin_m = 0.125F;
  EXPECT_EQ(describeLink(robot().links[0], parameters),
            "link 'hand': 1 triangles, 0.5 m long, margin 0.125 m, from hand.stl");
  parameters.link_margin_m = {{"hand", 0.01}};
  EXPECT_EQ(describeLink(robot().links[0], parameters),
            "link 'hand': 1 triangles, 0.5 m long, margin 0.01 m, from hand.stl");
  EXPECT_EQ(describeLink(robot().links[1], parameters),
            "link 'arm': arm.stl: no such file; the link is UNKNOWN");
}

}  // namespace
}  // namespace deformable_contact_monitor
