// Tests which bodies are reported as open, too large or too far away.
#include "monitor/diagnostics/body_checks.h"

#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include "sample_report.h"

namespace deformable_contact_monitor {
namespace {

using Lines = std::vector<std::string>;

TEST(OpenBodiesTest, AreSaidOnceAndListedWhileTheyAre) {
  SampleReport sample;
  Containment& containment = sample.addContainment();
  containment.bodies = {{true, 1, 0}, {true, 3, 2}, {true, 1, 1}};
  OpenBodies bodies;
  EXPECT_EQ(
      bodies.look(sample.report),
      (Lines{
          "containment: 2 of 3 parts of 'base' are not closed, so nothing is reported as inside of "
          "them; close the surface where that matters",
          "containment: 1 of 1 parts of 'cloth' are not closed, so nothing is reported as inside "
          "of "
          "them; close the surface where that matters"}));
  EXPECT_EQ(bodies.list(), "base (2 of 3 parts), cloth (1 of 1 parts)");
  containment.bodies = {{true, 1, 0}, {false, 0, 0}, {true, 1, 0}};
  EXPECT_EQ(bodies.look(sample.report), Lines());
  EXPECT_EQ(bodies.list(), "base (2 of 3 parts)") << "it was not looked at";
  containment.bodies[2].open = 1;
  EXPECT_EQ(bodies.look(sample.report), Lines()) << "it was said";
  EXPECT_EQ(bodies.list(), "base (2 of 3 parts), cloth (1 of 1 parts)");
}

// A square with that side, around the origin.
TriangleMesh square(float side_m) {
  const float h = side_m / 2;
  return {{-h, -h, 0, h, -h, 0, h, h, 0}, {0, 1, 2}};
}

class SizeCheckTest : public ::testing::Test {
 protected:
  SizeCheckTest() {
    for (const auto& [name, kind, side_m] :
         {std::tuple<const char*, BodyKind, float>{"arm", BodyKind::kLink, 0.5F},
          {"cloth", BodyKind::kDeformable, 0.8F}}) {
      scene_.addBody(name, square(side_m));
      BodyStatus status;
      status.name = name;
      status.kind = kind;
      status.stamp = ros::Time(50);
      status.triggered = kind == BodyKind::kDeformable;
      report_.bodies.push_back(status);
    }
    report_.scene = &scene_;
  }

  void placeCloth(float side_m, double x_m) {
    scene_.setMesh(1, square(side_m));
    RigidTransform pose;
    pose.translation[0] = x_m;
    scene_.setPose(1, pose);
  }

  // Returns what a new check finds about the cloth.
  std::string finding() {
    const auto found = SizeCheck().look(report_, {});
    EXPECT_EQ(found.size(), 1U);
    EXPECT_EQ(found.at(0).first, "cloth");
    return found.at(0).second;
  }

  Scene scene_;
  CycleReport report_;
};

TEST_F(SizeCheckTest, UsualSizesAreNotOdd) {
  EXPECT_EQ(finding(), "");
  placeCloth(49, 0);
  EXPECT_EQ(finding(), "");
  placeCloth(0.8F, 49);
  EXPECT_EQ(finding(), "");
}

TEST_F(SizeCheckTest, AMeshInMillimetres) {
  placeCloth(800, 0);
  EXPECT_NE(finding().find("800 m long"), std::string::npos) << finding();
  placeCloth(51, 0);
  EXPECT_NE(finding(), "");
}

TEST_F(SizeCheckTest, AMeshFarAway) {
  placeCloth(0.8F, 52);
  EXPECT_NE(finding().find("m away from the robot"), std::string::npos) << finding();
}

TEST_F(SizeCheckTest, VerticesThatAreNotFiniteAreLeftOut) {
  TriangleMesh mesh = square(0.8F);
  mesh.vertices[0] = std::numeric_limits<float>::infinity();
  mesh.vertices[4] = std::numeric_limits<float>::quiet_NaN();
  scene_.setMesh(1, mesh);
  EXPECT_EQ(finding(), "");
  scene_.setMesh(1, {std::vector<float>(9, std::numeric_limits<float>::quiet_NaN()), {0, 1, 2}});
  EXPECT_EQ(finding(), "none of its 3 vertices is finite");
  scene_.setMesh(1, TriangleMesh());
  EXPECT_EQ(finding(), "");
}

TEST_F(SizeCheckTest, EachObjectIsLookedAtOnceASecond) {
  SizeCheck check;
  const std::chrono::steady_clock::time_point start;
  EXPECT_EQ(check.look(report_, start).size(), 1U);
  EXPECT_EQ(check.look(report_, start + std::chrono::milliseconds(900)).size(), 0U);
  EXPECT_EQ(check.look(report_, start + std::chrono::milliseconds(1000)).size(), 1U);
}

TEST_F(SizeCheckTest, WhatIsNotOfTheCycleIsNotLookedAt) {
  placeCloth(800, 0);
  report_.bodies[1].triggered = false;
  EXPECT_TRUE(SizeCheck().look(report_, {}).empty());
  report_.bodies[1].triggered = true;
  report_.bodies[1].unknown_because = "no transform";
  EXPECT_TRUE(SizeCheck().look(report_, {}).empty());
  report_.bodies[1].unknown_because = "";
  report_.bodies[0].stamp = ros::Time();
  EXPECT_TRUE(SizeCheck().look(report_, {}).empty()) << "no link was posed";
  report_.scene = nullptr;
  EXPECT_TRUE(SizeCheck().look(report_, {}).empty()) << "no detection ran";
}

}  // namespace
}  // namespace deformable_contact_monitor
