// Descriptions made to do harm: whatever they say, an answer or a refusal, and not a word printed.
#include <console_bridge/console.h>

#include <random>
#include <stdexcept>

#include "robot/robot_geometry.h"
#include "robot_test_support.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

std::string noFiles(const std::string&) { throw std::runtime_error("no files here"); }

// Tells whether a description was read or rejected. The test fails if neither is the case.
enum class Outcome { kRead, kRefused };
Outcome tryToLoad(const std::string& urdf) {
  try {
    for (const GeometryKind kind : {GeometryKind::kCollision, GeometryKind::kVisual}) {
      RobotGeometryOptions options;
      options.kind = kind;
      for (const LinkGeometry& link : loadRobotGeometry(urdf, options, noFiles).links) {
        EXPECT_NE(link.problem.empty(), link.mesh.triangles.empty()) << link.link;
      }
    }
    return Outcome::kRead;
  } catch (const std::invalid_argument& e) {
    EXPECT_EQ(std::string(e.what()).find("robot description"), 0U) << e.what();
  }
  return Outcome::kRefused;
}

class HostileUrdf : public ::testing::Test {
 protected:
  void SetUp() override {
    ::testing::internal::CaptureStderr();
    ::testing::internal::CaptureStdout();
  }
  void TearDown() override {
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
  }
};

TEST_F(HostileUrdf, TextThatIsAPrintfFormat) {
  for (const std::string format : {"%s%s%s%s%s%s%s%s", "%n%n%n%n", "%999999999d", "%"}) {
    const auto collision = [&](const std::string& shape) {
      return "<collision><geometry>" + shape + "</geometry></collision>";
    };
    for (const std::string& content :
         {collision("<sphere radius=\"" + format + "\"/>"),
          collision("<box size=\"" + format + " 1 1\"/>"),
          collision("<cylinder radius=\"1\" length=\"" + format + "\"/>"),
          collision("<mesh filename=\"" + format + "\" scale=\"" + format + "\"/>"),
          "<collision><origin xyz=\"" + format + "\"/><geometry/></collision>"}) {
      const RobotGeometry robot = loadRobotGeometry(oneLinkUrdf(content), {}, noFiles);
      ASSERT_EQ(robot.links.size(), 1U) << content;
      EXPECT_NE(robot.links[0].problem, "") << content;
      EXPECT_EQ(robot.links[0].problem.find('\x1f'), std::string::npos) << content;
    }
    EXPECT_EQ(tryToLoad("<robot name=\"" + format + "\"><link name=\"" + format +
                        "\"><collision><geometry><box size=\"a 1 1\"/></geometry></collision>"
                        "</link><joint name=\"" +
                        format + "\" type=\"" + format + "\"/></robot>"),
              Outcome::kRefused);
  }
}

TEST_F(HostileUrdf, PercentSignsInNamesComeThrough) {
  const RobotGeometry robot = loadRobotGeometry(
      "<robot name=\"50%\"><link name=\"%20\"><collision><geometry>"
      "<mesh filename=\"package://a/b%20c.stl\"/></geometry></collision></link></robot>",
      {}, noFiles);
  EXPECT_EQ(robot.robots.at(0).name, "50%");
  EXPECT_EQ(robot.root_link, "%20");
  ASSERT_EQ(robot.links.size(), 1U);
  EXPECT_EQ(robot.links[0].link, "%20");
  EXPECT_EQ(robot.links[0].source, "package://a/b%20c.stl");
}

TEST_F(HostileUrdf, DeepNestingLongTextAndOddBytes) {
  std::string deep;
  for (int i = 0; i < 100000; ++i) deep += "<a>";
  EXPECT_EQ(tryToLoad("<robot name=\"r\">" + deep), Outcome::kRefused);
  const std::string long_name(1000000, 'x');
  EXPECT_EQ(tryToLoad("<robot name=\"r\"><link name=\"" + long_name + "\"/></robot>"),
            Outcome::kRead);
  EXPECT_EQ(
      tryToLoad("<robot name=\"r\"><link name=\"" + long_name + "\"><collision/></link></robot>"),
      Outcome::kRead);
  EXPECT_EQ(tryToLoad("<robot name=\"r\" version=\"99999999999999999999.0\"><link name=\"a\"/>"
                      "</robot>"),
            Outcome::kRefused);
  EXPECT_EQ(tryToLoad(std::string("<robot name=\"r\"><link name=\"a\0\"/></robot>", 37)),
            Outcome::kRefused);
  EXPECT_EQ(tryToLoad("<robot name=\"\xef\xef\xbf\"><link name=\"\xef\"/></robot>"),
            Outcome::kRead);
  EXPECT_EQ(tryToLoad("<!DOCTYPE r [<!ENTITY a \"b\"><!ENTITY c \"&a;&a;\">]><robot name=\"&c;\">"
                      "<link name=\"&c;&c;\"/></robot>"),
            Outcome::kRead);
}

TEST_F(HostileUrdf, DamagedPandasAreReadOrRefused) {
  DCM_REQUIRE_TEST_DATA();
  const std::string panda = readText(testDataFile("robots/panda_description/urdf/panda.urdf"));
  std::mt19937 dice(11);
  int read = 0, refused = 0;
  for (int i = 0; i < 4000; ++i) {
    std::string urdf = panda;
    for (int flips = 0; flips < 1 + i % 3; ++flips) {
      urdf[dice() % urdf.size()] ^= static_cast<char>(1U << (dice() % 8));
    }
    if (i % 10 == 0) urdf.resize(dice() % urdf.size());
    if (i % 10 == 1) urdf.insert(dice() % urdf.size(), urdf, dice() % urdf.size(), 200);
    tryToLoad(urdf) == Outcome::kRead ? ++read : ++refused;
  }
  EXPECT_GT(read, 400);
  EXPECT_GT(refused, 400);
}

TEST(ConsoleBridge, HandlerIsGivenBack) {
  console_bridge::OutputHandler* before = console_bridge::getOutputHandler();
  EXPECT_EQ(tryToLoad("<robot name=\"r\"><link name=\"a\"><collision/></link></robot>"),
            Outcome::kRead);
  EXPECT_EQ(tryToLoad("<robot name=\"r\"/>"), Outcome::kRefused);
  EXPECT_EQ(console_bridge::getOutputHandler(), before);
}

}  // namespace
}  // namespace deformable_contact_monitor
