// Only what a step can need is posed, clustered and swept; and one outlier costs only itself.
#include <gtest/gtest.h>

#include <vector>

#include "scenes.h"
#include "swept_suite.h"

namespace deformable_contact_monitor {
namespace {

class SweptWork : public DetectorSuite {
 protected:
  // Returns the counters of one cycle, after checking that it finds what brute force finds.
  Counters work(const Scene& scene, const Options& options) {
    const DetectionResult& result = detector_->detect(scene, options);
    EXPECT_TRUE(
        samePairs(makeBruteForceDetector()->detect(scene, options).contacts, result.contacts));
    return result.counters;
  }
};

// Two cloths of 800 triangles that lie in each other and travel 21 units together.
TEST_P(SweptWork, WhatTravelsTogetherCostsLittleMoreThanStandingStill) {
  Scene scene = pairScene(clothGrid(20, 1, 0, 0.1F), clothGrid(20, 1, 0.01F, -0.1F));
  scene.setPairEnabled(0, 0, true);
  for (const double share : {1.0, 0.7}) {  // the second cloth: 0.7 of the way beside the first
    scene.setEarlier(0, translationBy(-12, 12, -12), shaken(scene.body(0).mesh, 0.002F, 1));
    scene.setEarlier(1, translationBy(-12 + 0.001 * share, 12, -12));
    const Counters still = work(scene, Options()), swept = work(scene, sweptOptions());
    ASSERT_GT(still.candidates, 500U);
    EXPECT_LT(swept.interval_overlaps, 2 * still.interval_overlaps);
    EXPECT_LT(swept.cluster_entries, 3 * still.cluster_entries / 2);
    EXPECT_LT(swept.candidates, 9 * (still.candidates + 1600));
    EXPECT_EQ(0U, swept.large);
  }
}

// Their swept boxes overlap, but not at any time.
TEST_P(SweptWork, BodiesThatFollowOneAnotherAreCulled) {
  Scene scene = pairScene(clothGrid(20, 1, 0, 0.1F), clothGrid(20, 1, 0, 0.1F));
  scene.setPose(0, translationBy(5, 0, 0));
  scene.setEarlier(0, translationBy(0, 0, 0));
  scene.setPose(1, translationBy(7, 0, 0));
  scene.setEarlier(1, translationBy(2, 0, 0));
  Counters counters = work(scene, sweptOptions());
  if (detector_->backend() == "cpu") {  // CUDA poses to find out
    EXPECT_EQ(0U, counters.posed);
  }
  EXPECT_EQ(1600U, counters.culled);
  // Pads bring them together.
  scene.setPad(0, 0.6F);
  scene.setPad(1, 0.6F);
  counters = detector_->detect(scene, sweptOptions()).counters;
  EXPECT_EQ(1600U, counters.posed);
}

TEST_P(SweptWork, TrianglesThatNoPartnerComesToAreCulled) {
  Scene scene = pairScene(clothGrid(40, 1, 0, 0.1F), clothGrid(4, 0.1F, 0, 0));
  scene.setPose(1, translationBy(0.4, 0.4, 0));
  scene.setEarlier(1, translationBy(0.4, 0.4, -1));
  const Counters counters = work(scene, sweptOptions());
  EXPECT_GT(counters.culled, 2500U);
  EXPECT_GT(counters.interval_overlaps, 0U);
}

// Large ones that move, among small ones.
TEST_P(SweptWork, LargeTrianglesThatPass) {
  TriangleMesh mesh = clothGrid(30, 1, 0, 0.1F);
  std::vector<float> before = shaken(mesh, 0.01F, 5);
  for (int i = 0; i < 6; ++i) {
    const auto first = static_cast<std::uint32_t>(mesh.vertexCount());
    const float height = 0.05F * static_cast<float>(i);
    for (const float x : {-9.0F, 9.0F, 0.0F}) {
      mesh.vertices.insert(mesh.vertices.end(), {x, x == 0 ? 9.0F : -9.0F, height});
      before.insert(before.end(), {x, x == 0 ? 9.0F : -9.0F, 0.1F - height});
    }
    mesh.triangles.insert(mesh.triangles.end(), {first, first + 1, first + 2});
  }
  Scene scene = selfScene(mesh);
  scene.setEarlier(0, RigidTransform(), before);
  for (const AdjacentPairs adjacent : kBothAdjacent) {
    const Counters counters = work(scene, sweptOptions(adjacent));
    EXPECT_EQ(6U, counters.large);
  }
}

// One vertex that was far off, and one that will be.
TEST_P(SweptWork, OneFastOutlierCostsOnlyItself) {
  for (const float far : {1e3F, 1e30F}) {
    Scene scene = selfScene(clothGrid(30, 1, 0, 0.3F));
    std::vector<float> before = shaken(scene.body(0).mesh, 0.01F, 3);
    scene.setEarlier(0, RigidTransform(), before);
    const Counters usual = work(scene, sweptOptions());
    before[0] = far;
    scene.setEarlier(0, RigidTransform(), before);
    std::vector<float> now = scene.body(0).mesh.vertices;
    now[now.size() - 1] = -far;
    scene.setVertices(0, now.data(), now.size() / 3);
    const Counters counters = work(scene, sweptOptions());
    EXPECT_GE(counters.large, 2U);
    EXPECT_LE(counters.large, 6U);
    EXPECT_LT(counters.interval_overlaps, 3 * usual.interval_overlaps / 2 + 6 * 1800);
    EXPECT_LT(counters.candidates, usual.candidates + 6 * 1800);
  }
}

INSTANTIATE_TEST_SUITE_P(, SweptWork, ::testing::ValuesIn(sweptProductBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
