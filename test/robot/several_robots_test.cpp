// Tests how several robot descriptions become the links of one monitor: names with prefixes, SRDFs,
// and the names that are rejected.
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "refusal.h"
#include "robot/robot_geometry.h"
#include "robot_test_support.h"

namespace deformable_contact_monitor {
namespace {

using Names = std::vector<std::string>;

// A robot of the links "base" and "tip". The tip is a mesh file.
std::string urdf(const std::string& name) {
  return "<robot name='" + name + "'><link name='base'><collision><geometry><box size='1 1 1'/>" +
         "</geometry></collision></link><link name='tip'><collision><geometry><mesh filename='" +
         "/tip.obj'/></geometry></collision></link><link name='bare'/>" +
         "<joint name='a' type='fixed'><parent link='base'/><child link='tip'/></joint>" +
         "<joint name='b' type='fixed'><parent link='base'/><child link='bare'/></joint></robot>";
}

std::string noFile(const std::string& uri) { throw std::runtime_error("no files here: " + uri); }

RobotGeometry load(const std::vector<RobotDescription>& robots,
                   const RobotGeometryOptions& options = {}) {
  return loadRobots(robots, options, noFile);
}

std::vector<RobotDescription> threeArms() {
  std::vector<RobotDescription> arms;
  for (const char* prefix : {"PSM1/", "PSM2/", ""}) {
    arms.push_back({urdf("psm"), "parameter '/psm'", prefix, {}});
  }
  return arms;
}

Names linksOf(const RobotGeometry& robot) {
  Names names;
  for (const LinkGeometry& link : robot.links) names.push_back(link.link);
  return names;
}

TEST(SeveralRobots, LinksHaveTheirPrefixesInTheOrderOfTheRobots) {
  const RobotGeometry all = load(threeArms());
  EXPECT_EQ(linksOf(all), (Names{"PSM1/base", "PSM1/tip", "PSM2/base", "PSM2/tip", "base", "tip"}));
  EXPECT_EQ(all.link_names.size(), 9U);
  EXPECT_EQ(all.link_names.count("PSM2/bare"), 1U);
  EXPECT_EQ(all.root_link, "PSM1/base");
  EXPECT_EQ(all.links[3].problem, "link 'PSM2/tip': /tip.obj: no files here: /tip.obj");
  ASSERT_EQ(all.robots.size(), 3U);
  EXPECT_EQ(all.robots[1].name, "psm");
  EXPECT_EQ(all.robots[1].links, (std::set<std::string>{"PSM2/base", "PSM2/tip", "PSM2/bare"}));
}

TEST(SeveralRobots, OptionsNameLinksWithTheirPrefix) {
  RobotGeometryOptions options;
  options.links = {"PSM2/base", "tip", "PSM1/tip"};
  options.ignored_links = {"PSM1/tip"};
  EXPECT_EQ(linksOf(load(threeArms(), options)), (Names{"PSM2/base", "tip"}));
  options.links = {"PSM2/bse"};
  EXPECT_EQ(refusal([&] { load(threeArms(), options); }),
            "links: 'PSM2/bse' (did you mean 'PSM2/base'?): no such link in robot 'psm' with "
            "frame_prefix 'PSM1/', 'psm' with frame_prefix 'PSM2/', 'psm'");
}

TEST(SeveralRobots, EachSrdfGetsThePrefixOfItsRobot) {
  std::vector<RobotDescription> arms = threeArms();
  arms[1].srdf.robot = "psm";
  arms[1].srdf.disabled = {{"base", "tip", "Adjacent"}};
  arms[1].srdf.enabled = {{"tip", "bare", ""}, {"table", "tip", ""}};
  arms[1].srdf.disabled_links = {"bare"};
  const RobotGeometry all = load(arms);
  EXPECT_TRUE(all.robots[0].srdf == Srdf());
  const Srdf& srdf = all.robots[1].srdf;
  EXPECT_EQ(srdf.robot, "psm");
  EXPECT_EQ(srdf.disabled[0].a + " " + srdf.disabled[0].b, "PSM2/base PSM2/tip");
  EXPECT_EQ(srdf.disabled[0].reason, "Adjacent");
  EXPECT_EQ(srdf.enabled[0].a + " " + srdf.enabled[0].b, "PSM2/tip PSM2/bare");
  EXPECT_EQ(srdf.enabled[1].a + " " + srdf.enabled[1].b, "table PSM2/tip") << "a rigid object";
  EXPECT_EQ(srdf.disabled_links, (std::set<std::string>{"PSM2/bare"}));
}

TEST(SeveralRobots, LinksOfOneNameAreRejected) {
  std::vector<RobotDescription> arms = threeArms();
  arms[2].link_prefix = "PSM1/";
  EXPECT_EQ(refusal([&] { load(arms); }),
            "robots: 'PSM1/base' is a link of robots[0], 'psm' with frame_prefix 'PSM1/', and of "
            "robots[2], 'psm' with frame_prefix 'PSM1/'; give each robot its own frame_prefix");
}

TEST(SeveralRobots, AMalformedDescriptionIsNamed) {
  std::vector<RobotDescription> arms = threeArms();
  arms[1] = {"<robot/>", "parameter '/left/psm'", "PSM2/", {}};
  EXPECT_EQ(refusal([&] { load(arms); }).find("parameter '/left/psm': robot description, line 1: "),
            0U);
}

}  // namespace
}  // namespace deformable_contact_monitor
