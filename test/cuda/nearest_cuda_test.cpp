// Nearest pairs of bodies on CUDA, beside brute force: warm and cold, in scenes that walk, from
// vertices that move, in swept motion, and with more near tiles than are listed.
#include <gtest/gtest.h>

#include <cfloat>
#include <chrono>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "core/body_distance.h"
#include "core/cpu_detector.h"
#include "core/rules/nearest.h"
#include "cuda/cuda_detector.h"
#include "cuda/device/cuda_error.h"
#include "nearest_pairs.h"
#include "random_scenes.h"
#include "reference/reference_detectors.h"
#include "scene_walk.h"
#include "scenes.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

class NearestOnCuda : public testing::Test {
 protected:
  void SetUp() override {
    options_.nearest = true;
    try {
      detector_ = makeCudaDetector();
    } catch (const CudaError& error) {
      ASSERT_FALSE(isCudaRequired()) << error.what();
    }
  }

  testing::AssertionResult isAsByBruteForce(const Scene& scene) {
    const std::vector<NearestPair> expected = brute_force_->detect(scene, options_).nearest;
    for (const NearestPair& pair : expected) ++(pair.distance_m > 0 ? apart_ : touching_);
    return sameNearest(expected, detector_->detect(scene, options_).nearest);
  }

  std::unique_ptr<Detector> detector_;  // null: there is no device
  const std::unique_ptr<Detector> brute_force_ = makeBruteForceDetector();
  Options options_;
  std::size_t apart_ = 0, touching_ = 0;
};

TEST_F(NearestOnCuda, IsThatOfBruteForceInRandomScenes) {
  if (detector_ == nullptr) return;
  constexpr float kMargins[] = {0, 0, 1e-40F, 0.1F, 0.5F, 10, 1e30F, FLT_MAX};
  for (std::uint32_t seed = 0; seed < 1000; ++seed) {
    Scene scene = randomScene(seed);
    for (BodyId id = 0; id < scene.bodyCount(); ++id) {
      scene.setMargin(id, kMargins[(seed / 3 + 5 * id) % 8]);
    }
    for (int cycle = 0; cycle < 3; ++cycle) {
      ASSERT_TRUE(isAsByBruteForce(scene)) << "seed " << seed << ", cycle " << cycle;
      RigidTransform pose = scene.body(0).pose;
      pose.translation[cycle] += 0.5;
      scene.setPose(0, pose);
    }
  }
  EXPECT_GT(apart_, 500U);
  EXPECT_GT(touching_, 500U);
}

// DCM_WALK_STEPS sets how many steps each walk takes, and DCM_WALK_SEED the first of four seeds.
TEST_F(NearestOnCuda, IsThatOfBruteForceInScenesThatWalk) {
  if (detector_ == nullptr) return;
  const std::uint32_t steps = numberFromEnvironment("DCM_WALK_STEPS", 150);
  const std::uint32_t first = numberFromEnvironment("DCM_WALK_SEED", 1);
  for (std::uint32_t seed = first; seed < first + 4; ++seed) {
    SceneWalk walk(seed);
    for (std::uint32_t step = 0; step < steps; ++step) {
      const std::string what = walk.step();
      options_ = walk.options();
      options_.nearest = true;
      options_.near_pairs = step % 2 == 0;
      ASSERT_TRUE(isAsByBruteForce(walk.scene()))
          << "seed " << seed << ", step " << step << ": " << what;
    }
  }
  EXPECT_GT(apart_, 50U);
  EXPECT_GT(touching_, 50U);
}

// Cycles of one shape run as a recorded graph, and start from the last cycle's nearest triangles.
TEST_F(NearestOnCuda, OfVerticesThatMove) {
  if (detector_ == nullptr) return;
  const auto cpu = makeCpuDetector();
  std::mt19937 random(7);
  Scene scene = pairScene(clothGrid(60, 1, 0, 0.05F), clothGrid(9, 0.2F, 0.3F, 0.02F));
  scene.setMargin(0, 2);
  std::vector<float> xyz(scene.body(0).mesh.vertices.begin(), scene.body(0).mesh.vertices.end());
  for (int cycle = 0; cycle < 60; ++cycle) {
    for (float& x : xyz) x += (static_cast<float>(random() % 1000) - 499.5F) * 2e-6F;
    if (cycle % 9 == 8) xyz[random() % xyz.size()] = cycle % 2 == 0 ? NAN : 1e30F;
    scene.setVertices(0, xyz.data(), xyz.size() / 3);
    RigidTransform pose;
    pose.translation[2] = cycle % 7 == 6 ? -0.3 : 0.001 * cycle;
    scene.setPose(1, pose);
    ASSERT_TRUE(sameNearest(cpu->detect(scene, options_).nearest,
                            detector_->detect(scene, options_).nearest))
        << cycle;
  }
}

TEST_F(NearestOnCuda, IsOfTheStampInSweptMotion) {
  if (detector_ == nullptr) return;
  options_.motion = Motion::kSwept;
  for (std::uint32_t seed = 0; seed < 300; ++seed) {
    Scene scene = randomScene(seed);
    for (BodyId id = 0; id < scene.bodyCount(); ++id) scene.setMargin(id, 2);
    RigidTransform from = scene.body(0).pose;
    from.translation[seed % 3] -= 1;
    scene.setEarlier(0, from);
    ASSERT_TRUE(isAsByBruteForce(scene)) << "seed " << seed;
  }
  EXPECT_GT(apart_ + touching_, 100U);
}

// Two stacks of slanted triangles, one between the other's, whose boxes all overlap: more pairs of
// tiles are near than the list has room for. One triangle is a little nearer than all others.
TEST_F(NearestOnCuda, WithMoreNearTilesThanAreListed) {
  if (detector_ == nullptr) return;
  constexpr std::uint32_t kCount = 12000, kNearer = 4711;
  const auto stack = [](float at) {
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < kCount; ++i) {
      const float x = at + static_cast<float>(i) * 0x1p-14F;
      triangles.push_back({{{x, 0, 0}, {x - 8, 8, 0}, {x - 8, 0, 8}}});
    }
    return triangles;
  };
  std::vector<Triangle> moved = stack(0x1p-15F);
  for (Vec3f& v : moved[kNearer].v) v.x -= 0x1p-17F;
  Scene scene = pairScene(meshOf(stack(0)), meshOf(moved));
  scene.setMargin(0, 10);
  const Triangle a = stack(0)[kNearer];
  const float nearest_m = comparedDistance(separation(a, moved[kNearer]));
  for (int cycle = 0; cycle < 3; ++cycle) {
    const std::vector<NearestPair>& found = detector_->detect(scene, options_).nearest;
    ASSERT_EQ(1U, found.size());
    EXPECT_EQ((TrianglePair{0, kNearer, 1, kNearer}), found[0].pair);
    EXPECT_EQ(nearest_m, found[0].distance_m);
    if (cycle == 1) detector_->reset();
  }
}

// A cycle that is cut off among its contacts has searched the nearest pairs before, and then tells
// how each two bodies stand.
TEST_F(NearestOnCuda, TellsHowBodiesStandWhereACycleIsCutOff) {
  if (detector_ == nullptr) return;
  Scene scene = pairScene(clothGrid(150, 1, 0, 0.1F), clothGrid(140, 1.1F, 0.013F, -0.1F));
  scene.setPairEnabled(0, 0, true);
  const BodyId near = scene.addBody("near", clothGrid(20, 0.2F, 0.3F, 0));
  const BodyId far = scene.addBody("far", clothGrid(20, 0.2F, 3, 0));
  for (const BodyId id : {near, far}) scene.setPairEnabled(0, id, true);
  scene.setMargin(0, 1);
  const std::vector<NearestPair> expected = makeCpuDetector()->detect(scene, options_).nearest;
  ASSERT_EQ(2U, expected.size());
  detector_->detect(scene, options_);
  double whole_us = 1000;  // of the last cycle that was not cut off; others may use the device too
  int cut_off = 0, known = 0;
  for (int i = 0; i < 200 || (known == 0 && i < 5000); ++i) {
    RigidTransform pose;
    pose.translation[0] = 1e-5 * i;
    scene.setPose(far, pose);
    Options options = options_;
    options.limits.deadline =
        std::chrono::steady_clock::now() +
        std::chrono::microseconds(static_cast<int>(whole_us * (i % 100) / 90));
    const DetectionResult& result = detector_->detect(scene, options);
    if (!result.cut_off) {
      whole_us = 1000 * result.round_trip_ms;
      ASSERT_TRUE(sameNearest(expected, result.nearest));
      continue;
    }
    ++cut_off;
    for (const NearestPair& pair : result.nearest) {
      EXPECT_TRUE(pair == expected[0] || pair == expected[1]);
    }
    for (const BodyDistance& distance : result.distances) {
      if (!distance.is_exact) continue;
      ++known;
      const PairDecision decision = decide(distance, scene, 0);
      EXPECT_EQ(distance.body_b == 1      ? PairDecision::kContact
                : distance.body_b == near ? PairDecision::kNear
                                          : PairDecision::kNone,
                decision);
    }
  }
  EXPECT_GT(cut_off, 0);
  EXPECT_GT(known, 0);
}

// With a tolerance, distances are there as on the CPU, and are exact.
TEST_F(NearestOnCuda, GivesDistancesWithATolerance) {
  if (detector_ == nullptr) return;
  Scene scene = pairScene(clothGrid(20, 1, 0, 0.1F), clothGrid(15, 1, 0.4F, 0));
  const BodyId far = scene.addBody("far", clothGrid(5, 1, 3, 0));
  scene.setPairEnabled(0, far, true);
  scene.setMargin(0, 1);
  for (const bool nearest : {false, true}) {
    Options options;
    options.tolerance_m = 0.01F;
    options.nearest = nearest;
    const DetectionResult& result = detector_->detect(scene, options);
    ASSERT_EQ(2U, result.distances.size());
    EXPECT_EQ(PairDecision::kNear, decide(result.distances[0], scene, 0.01F));
    EXPECT_EQ(PairDecision::kNone, decide(result.distances[1], scene, 0.01F));
    const std::vector<NearestPair> expected = makeCpuDetector()->detect(scene, options_).nearest;
    EXPECT_EQ(expected.at(0).pair, result.distances[0].witness);
    EXPECT_TRUE(sameNearest(nearest ? expected : std::vector<NearestPair>(), result.nearest));
  }
}

// A grid over a grid: every vertex is as near as any other.
TEST_F(NearestOnCuda, TiesGoToTheLeastTriangles) {
  if (detector_ == nullptr) return;
  for (const float gap_m : {0.0F, 0.25F}) {
    Scene scene = pairScene(clothGrid(40, 1, 0, 0), clothGrid(40, 1, gap_m, 0));
    scene.setMargin(0, 1);
    for (int cycle = 0; cycle < 3; ++cycle) {
      const std::vector<NearestPair>& found = detector_->detect(scene, options_).nearest;
      ASSERT_EQ(1U, found.size());
      EXPECT_EQ((TrianglePair{0, 0, 1, 0}), found[0].pair);
      EXPECT_EQ(gap_m, found[0].distance_m);
    }
    EXPECT_TRUE(isAsByBruteForce(pairScene(clothGrid(8, 1, 0, 0), clothGrid(8, 1, gap_m, 0))));
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
