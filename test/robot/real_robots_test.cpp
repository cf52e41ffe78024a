// The Panda and the PR2, link by link.
#include <cmath>
#include <cstring>
#include <map>

#include "robot_test_support.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

RobotGeometry load(const std::string& urdf, GeometryKind kind) {
  RobotGeometryOptions options;
  options.kind = kind;
  return loadRobotGeometry(readText(testDataFile(urdf)), options, testDataResolver());
}

std::vector<std::string> namesOf(const RobotGeometry& robot) {
  std::vector<std::string> names;
  for (const LinkGeometry& link : robot.links) names.push_back(link.link);
  return names;
}

// Names in the order in which they stand in the text, by eye as it were.
std::vector<std::string> linksInText(const std::string& urdf) {
  std::vector<std::string> names;
  const std::string text = readText(testDataFile(urdf));
  for (std::size_t at = text.find("<link name=\""); at != std::string::npos;
       at = text.find("<link name=\"", at + 1)) {
    const std::size_t first = at + std::string("<link name=\"").size();
    names.push_back(text.substr(first, text.find('"', first) - first));
  }
  return names;
}

// A binary STL's corners, nine floats a triangle.
std::vector<float> readBinaryStl(const std::string& path) {
  const std::string bytes = readText(path);
  std::vector<float> corners;
  for (std::size_t at = 84; at + 50 <= bytes.size(); at += 50) {
    float triangle[9];
    std::memcpy(triangle, bytes.data() + at + 12, sizeof(triangle));
    corners.insert(corners.end(), triangle, triangle + 9);
  }
  return corners;
}

constexpr char kPanda[] = "robots/panda_description/urdf/panda.urdf";
constexpr char kPr2[] = "bags/pr2.urdf";

TEST(RealRobots, ThreePandasHaveTheLinksAndTheRulesOfOneEach) {
  DCM_REQUIRE_TEST_DATA();
  const std::string folder = "robots/panda_description/urdf/";
  const Srdf srdf = readSrdfFile(testDataFile(folder + "panda.srdf"));
  std::vector<RobotDescription> three;
  for (const char* prefix : {"a/", "b/", "c/"}) {
    three.push_back({readText(testDataFile(kPanda)), "panda.urdf", prefix, srdf});
  }
  const RobotGeometry one = load(kPanda, GeometryKind::kCollision);
  const RobotGeometry all = loadRobots(three, {}, testDataResolver());
  ASSERT_EQ(all.links.size(), 3 * one.links.size());
  for (std::size_t i = 0; i < all.links.size(); ++i) {
    const LinkGeometry& link = one.links[i % one.links.size()];
    EXPECT_EQ(all.links[i].link, three[i / one.links.size()].link_prefix + link.link);
    EXPECT_EQ(all.links[i].mesh.vertices, link.mesh.vertices);
    EXPECT_EQ(all.links[i].mesh.triangles, link.mesh.triangles);
  }
  for (const DescribedRobot& robot : all.robots) {
    EXPECT_EQ(robot.srdf.disabled.size(), srdf.disabled.size());
    EXPECT_TRUE(srdfWarnings(robot.srdf, robot.name, robot.links).empty());
  }
}

TEST(RealRobots, PandaCollisionMeshesAreTheFilesTriangleByTriangle) {
  DCM_REQUIRE_TEST_DATA();
  const RobotGeometry robot = load(kPanda, GeometryKind::kCollision);
  EXPECT_EQ(robot.robots.at(0).name, "panda");
  const std::vector<std::string> names{"panda_link0",      "panda_link1",      "panda_link2",
                                       "panda_link3",      "panda_link4",      "panda_link5",
                                       "panda_link6",      "panda_link7",      "panda_hand",
                                       "panda_leftfinger", "panda_rightfinger"};
  EXPECT_EQ(namesOf(robot), names);  // link8 has no geometry
  const std::string folder = "robots/panda_description/meshes/collision/";
  for (const LinkGeometry& link : robot.links) {
    SCOPED_TRACE(link.link);
    EXPECT_EQ(link.problem, "");
    const bool is_finger = link.link.find("finger") != std::string::npos;
    const std::string file = is_finger ? "finger" : link.link.substr(std::strlen("panda_"));
    EXPECT_EQ(link.source,
              "package://moveit_resources_panda_description/meshes/collision/" + file + ".stl");
    const std::vector<float> expected = readBinaryStl(testDataFile(folder + file + ".stl"));
    ASSERT_EQ(link.mesh.triangles.size(), expected.size() / 3);
    // The right finger is turned half round by rpy="0 0 3.14159265359".
    const bool is_turned = link.link == "panda_rightfinger";
    double worst_m = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const float actual = link.mesh.vertices[3 * link.mesh.triangles[i / 3] + i % 3];
      const float sign = is_turned && i % 3 < 2 ? -1.0F : 1.0F;
      worst_m = std::max(worst_m, std::abs(double{actual} - double{sign * expected[i]}));
    }
    EXPECT_LE(worst_m, is_turned ? 1e-9 : 0.0);
    EXPECT_LT(link.mesh.vertexCount(), link.mesh.triangleCount());  // equal vertices are one
    EXPECT_NO_THROW(validate(link.mesh, link.link));
  }
  EXPECT_TRUE(geometryWarnings(robot).empty());
}

TEST(RealRobots, PandaBoundingBoxes) {
  DCM_REQUIRE_TEST_DATA();
  for (const GeometryKind kind : {GeometryKind::kCollision, GeometryKind::kVisual}) {
    const RobotGeometry robot = load(kPanda, kind);
    ASSERT_EQ(robot.links.size(), 11U);
    // The data sheet's base: 0.2 m wide, the first joint's flange 0.14 m above the mounting plane.
    const Bounds base = boundsOf(robot.links[0].mesh);
    EXPECT_NEAR(base.high.z(), 0.14, 0.02);
    EXPECT_NEAR(base.low.z(), 0, 0.005);
    EXPECT_NEAR(base.high.y() - base.low.y(), 0.19, 0.02);
    // The hand is 0.2 m wide along y.
    const Bounds hand = boundsOf(robot.links[8].mesh);
    EXPECT_NEAR(hand.high.y() - hand.low.y(), 0.205, 0.01);
  }
}

TEST(RealRobots, VisualAndCollisionBoundsOfThePandaAgree) {
  DCM_REQUIRE_TEST_DATA();
  const RobotGeometry collision = load(kPanda, GeometryKind::kCollision);
  const RobotGeometry visual = load(kPanda, GeometryKind::kVisual);
  ASSERT_EQ(namesOf(collision), namesOf(visual));
  std::size_t triangles = 0;
  for (std::size_t i = 0; i < visual.links.size(); ++i) {
    SCOPED_TRACE(visual.links[i].link);
    triangles += visual.links[i].mesh.triangleCount();
    const Bounds a = boundsOf(collision.links[i].mesh), b = boundsOf(visual.links[i].mesh);
    EXPECT_LT((a.low - b.low).cwiseAbs().maxCoeff(), 0.02);  // a wrong up axis is far off
    EXPECT_LT((a.high - b.high).cwiseAbs().maxCoeff(), 0.02);
  }
  EXPECT_GT(triangles, 130000U);
}

TEST(RealRobots, Pr2LinksInDocumentOrderAllUsable) {
  DCM_REQUIRE_TEST_DATA();
  const std::vector<std::string> in_text = linksInText(kPr2);
  ASSERT_EQ(in_text.size(), 83U);
  for (const GeometryKind kind : {GeometryKind::kCollision, GeometryKind::kVisual}) {
    const RobotGeometry robot = load(kPr2, kind);
    const std::vector<std::string> names = namesOf(robot);
    ASSERT_GT(names.size(), 40U);
    auto at = in_text.begin();
    for (const std::string& name : names) {
      at = std::find(at, in_text.end(), name);
      ASSERT_NE(at, in_text.end()) << name << " is out of order";
    }
    for (const LinkGeometry& link : robot.links) {
      EXPECT_EQ(link.problem, "");
      EXPECT_GT(link.mesh.triangleCount(), 0U) << link.link;
    }
  }
}

TEST(RealRobots, Pr2BoundingBoxes) {
  DCM_REQUIRE_TEST_DATA();
  const RobotGeometry robot = load(kPr2, GeometryKind::kCollision);
  std::map<std::string, Bounds> bounds;
  for (const LinkGeometry& link : robot.links) bounds[link.link] = boundsOf(link.mesh);
  const auto size = [&](const std::string& link) {
    return Eigen::Vector3d(bounds.at(link).high - bounds.at(link).low);
  };
  EXPECT_LT((size("base_link") - Eigen::Vector3d(0.668, 0.668, 0.656)).cwiseAbs().maxCoeff(),
            0.002);
  EXPECT_LT(size("l_gripper_l_finger_tip_link").maxCoeff(), 0.08);
  EXPECT_TRUE(size("l_upper_arm_link").isApprox(size("r_upper_arm_link"), 1e-6));
  EXPECT_NEAR(size("l_upper_arm_link").x(), 0.45, 0.1);
}

}  // namespace
}  // namespace deformable_contact_monitor
