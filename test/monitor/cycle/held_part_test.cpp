// Tests which triangles a radius holds, and what is refused.
#include "monitor/cycle/held_part.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <limits>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "loop_fixture.h"
#include "reference/reference_detectors.h"

namespace deformable_contact_monitor {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

TriangleMesh randomMesh(std::mt19937& dice, int triangles, float size) {
  // Coordinates of a coarse grid make exact distances frequent.
  std::uniform_int_distribution<int> place(-64, 64), edge(-4, 4);
  TriangleMesh mesh;
  for (int t = 0; t < triangles; ++t) {
    const int at[3] = {place(dice), place(dice), place(dice)};
    for (std::uint32_t corner = 0; corner < 3; ++corner) {
      for (const int x : at) {
        mesh.vertices.push_back(size * static_cast<float>(x + edge(dice)) / 64);
      }
      mesh.triangles.push_back(3 * static_cast<std::uint32_t>(t) + corner);
    }
  }
  return mesh;
}

// The triangles of body 0 in contacts that brute force lists for a margin of the radius.
std::vector<std::uint32_t> listed(Scene scene, float radius_m) {
  scene.setMargin(0, radius_m);
  for (BodyId id = 1; id < scene.bodyCount(); ++id) scene.setPairEnabled(0, id, true);
  Options options;
  options.near_pairs = options.nearest = true;
  const std::unique_ptr<Detector> detector = makeBruteForceDetector();
  std::set<std::uint32_t> triangles;
  for (const TrianglePair& pair : detector->detect(scene, options).contacts) {
    triangles.insert(pair.triangle_a);
  }
  return {triangles.begin(), triangles.end()};
}

TEST(TrianglesWithin, AreThoseThatADetectorListsForThatMargin) {
  std::mt19937 dice(43);
  std::size_t some = 0, held = 0;
  for (int i = 0; i < 300; ++i) {
    const float size = i % 3 == 0 ? 1e-3F : 1;
    Scene scene;
    scene.addBody("cloth", randomMesh(dice, 80, size));
    scene.addBody("finger", randomMesh(dice, i % 80, size));
    scene.addBody("thumb", randomMesh(dice, 2, size));
    RigidTransform pose;
    pose.translation[0] = size * static_cast<double>(i % 5) / 8;
    scene.setPose(1, pose);
    if (i % 4 == 0) scene.setPose(0, pose);
    if (i % 5 == 0) scene.setRadius(2, size / 32);
    const float radius_m = size * static_cast<float>(1 + i % 16) / 64;
    const std::vector<std::uint32_t> within = trianglesWithin(scene, 0, radius_m);
    ASSERT_EQ(within, listed(scene, radius_m)) << "scene " << i;
    some += !within.empty() && within.size() < 80;
    held += within.size();
  }
  EXPECT_GT(some, 250U);
  EXPECT_GT(held, 1000U);
}

TEST(TrianglesWithin, HiddenTrianglesAreNearToNothing) {
  Scene scene;
  scene.addBody("cloth", {{0, 0, 0, 1, 0, 0, 0, 1, kNaN, 0, 1, 0}, {0, 1, 2, 0, 1, 3}});
  scene.addBody("finger", {{0, 0, 1, 1, 0, 1, 0, 1, 1, 0, 0, kInfinity}, {0, 1, 3, 0, 1, 2}});
  EXPECT_EQ(trianglesWithin(scene, 0, 1), std::vector<std::uint32_t>{1});
  EXPECT_TRUE(trianglesWithin(scene, 0, .999F).empty());
}

// A cloth of two triangles, 1 m apart, and a finger at the first one.
class HoldTest : public ::testing::Test {
 protected:
  HoldTest() {
    parameters_.reference_frame = "base";
    parameters_.objects = {{"cloth", "", 0, true}};
    const TriangleMesh mesh{{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2}};
    robot_.links = {{"finger", "", mesh, ""}, {"lost", "", TriangleMesh(), "no such file"}};
    addTransform(&buffer_, "finger", 5);
    addTransform(&buffer_, "camera", 5);
    auto message = boost::make_shared<DeformableMesh>();
    message->header.frame_id = "camera";
    message->header.stamp = ros::Time(5);
    message->vertices = {0, 0, 0, 1, 0, 0, 0, 1, 0, 3, 0, 0, 4, 0, 0, 3, 1, 0};
    mesh_.message = message;
    mesh_.topology = std::make_shared<const Topology>(Topology{1, 6, {0, 1, 2, 3, 4, 5}});
  }

  std::shared_ptr<const HeldPart> find(const std::vector<std::string>& links, float radius_m) {
    return findHeldPart({"cloth", mesh_, links, radius_m}, robot_, parameters_,
                        TransformLookup(buffer_, "base"));
  }

  std::string refusal(const std::vector<std::string>& links, float radius_m = .5F) {
    try {
      find(links, radius_m);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  }

  MonitorParameters parameters_;
  RobotGeometry robot_;
  TransformBuffer buffer_{[] { return ros::Time(50); }};
  IncomingMesh mesh_;
};

TEST_F(HoldTest, ItIsAtTheStampOfTheMesh) {
  const auto held = find({"finger", "tool_frame"}, .5F);
  EXPECT_EQ(held->triangles, std::vector<std::uint32_t>{0});
  EXPECT_EQ(held->topology, mesh_.topology);
  EXPECT_EQ(held->stamp, ros::Time(5));
  EXPECT_EQ(held->radius_m, .5F);
  EXPECT_EQ(find({"finger"}, 2)->triangles.size(), 2U);
}

TEST_F(HoldTest, WhatIsNotKnownIsRefusedByName) {
  EXPECT_EQ(refusal({"lost", "finger"}), "lost: no such file");
  EXPECT_EQ(refusal({"tool_frame"}),
            "none of these links has geometry that is looked at, so nothing is within a radius of "
            "them: tool_frame");
  parameters_.frame_prefix = "left/";
  EXPECT_EQ(refusal({"finger"}).find("finger: "), 0U) << refusal({"finger"});
  parameters_.frame_prefix = "";
  auto message = boost::make_shared<DeformableMesh>(*mesh_.message);
  message->header.frame_id = "nowhere";
  mesh_.message = message;
  EXPECT_EQ(refusal({"finger"}).find("cloth: "), 0U) << refusal({"finger"});
  message->header.frame_id = "base";
  message->vertices = {9, 0, 0, 9, 1, 0, 9, 0, 1, 9, 0, 0, 9, 1, 0, 9, 0, 1};
  EXPECT_EQ(refusal({"finger"}), "no triangle of cloth lies within 0.5 m of finger");
}

TEST_F(HoldTest, TheRadiusIsFromTheSurfaceOfAnObjectThatHasOne) {
  EXPECT_EQ(find({"finger"}, .5F)->triangles.size(), 1U);
  parameters_.objects[0].radius_m = 1.6F;
  EXPECT_EQ(find({"finger"}, .5F)->triangles.size(), 2U);
}

TEST_F(HoldTest, RadiusAndSettingsAreChecked) {
  EXPECT_EQ(holdProblem("cloth", .01F, parameters_), "");
  for (const float bad : {kNaN, kInfinity, -.5F}) {
    EXPECT_NE(holdProblem("cloth", bad, parameters_).find("must be a finite number >= 0 [m]"),
              std::string::npos);
  }
  parameters_.objects[0].type = MeshType::kPointCloud;
  EXPECT_NE(holdProblem("cloth", .01F, parameters_).find("for a point_cloud without faces"),
            std::string::npos);
  parameters_.objects[0].type = MeshType::kPoints;
  EXPECT_EQ(holdProblem("cloth", .01F, parameters_),
            "a radius is not supported for points, which may come in another order");
  parameters_.objects[0].type = MeshType::kPolyline;
  EXPECT_EQ(holdProblem("cloth", .01F, parameters_), "");
  parameters_.objects[0].type = MeshType::kPointCloud;
  parameters_.objects[0].faces = std::make_shared<const PointTriangles>();
  EXPECT_EQ(holdProblem("cloth", .01F, parameters_), "");
  parameters_.objects[0].parts.resize(127);
  EXPECT_EQ(holdProblem("cloth", .01F, parameters_), "");
  parameters_.objects[0].parts.resize(128);
  EXPECT_EQ(holdProblem("cloth", .01F, parameters_),
            "a radius is not supported for an object with 128 parts, must be at most 127");
  parameters_.objects[0].parts.clear();
  parameters_.detector.tolerance_m = .01F;
  parameters_.containment = true;
  parameters_.objects.push_back({"cloth:held", "", 0, true});
  EXPECT_EQ(
      holdProblem("cloth", .01F, parameters_),
      "a radius is not supported with tolerance_m above 0, and not with containment: true, and "
      "not for 'cloth' beside the object 'cloth:held'");
}

TEST_F(HoldTest, OnlyFramesThatAreLookedUpAreAwaited) {
  const std::vector<std::string> links = {"finger", "base"};
  const auto frames = framesOfHold({"cloth", mesh_, links, .5F}, parameters_);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].frame, "camera");
  EXPECT_EQ(frames[1].link, "finger");
}

// A MeshInput offers its newest mesh to the thread that serves ~attach_object.
TEST_F(HoldTest, TheNewestAcceptedMeshIsSeen) {
  MeshInput input("cloth", MeshLimits());
  std::string why_not;
  const auto take = [&](double stamp_s) {
    auto message = boost::make_shared<DeformableMesh>(*mesh_.message);
    message->header.stamp = ros::Time(stamp_s);
    message->triangles = mesh_.topology->triangles;
    input.store({message});
    IncomingMesh taken;
    input.take(ros::Time(), &taken);
  };
  EXPECT_FALSE(input.newest(&why_not));
  EXPECT_EQ(why_not, "no mesh yet");
  take(50);
  take(50.125);
  take(50);
  ASSERT_TRUE(input.newest(&why_not));
  EXPECT_EQ(input.newest(&why_not)->stamp(), ros::Time(50.125));
  EXPECT_NE(input.newest(&why_not)->topology, nullptr);
  take(0);
  EXPECT_FALSE(input.newest(&why_not));
  EXPECT_EQ(why_not, "mesh refused: header.stamp is zero");
  take(50.25);
  EXPECT_TRUE(input.newest(&why_not));
  input.forget();
  EXPECT_FALSE(input.newest(&why_not));
}

}  // namespace
}  // namespace deformable_contact_monitor
