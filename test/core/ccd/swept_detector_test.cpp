// Detection between two states: what the stages make of a step.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/common/scene_queries.h"
#include "core/detector_pool.h"
#include "random_scenes.h"
#include "scenes.h"
#include "swept/swept_oracle.h"
#include "swept/swept_scenes.h"
#include "swept_suite.h"

namespace deformable_contact_monitor {
namespace {

class SweptSuite : public DetectorSuite {
 protected:
  DetectionResult detect(const Scene& scene, const Options& options) {
    return detector_->detect(scene, options);
  }
};

std::vector<TrianglePair> expectedOf(const Scene& scene,
                                     AdjacentPairs adjacent = AdjacentPairs::kBeyondShared) {
  return oracleSweptContacts(earlierScene(scene), scene, adjacent);
}

bool sameTimes(const std::vector<FirstContact>& a, const std::vector<FirstContact>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const FirstContact& x, const FirstContact& y) {
                      return x.low == y.low && x.high == y.high;
                    });
}

// However it is said that nothing moves.
TEST_P(SweptSuite, WithoutMotionItIsTheInstantResult) {
  std::size_t found = 0;
  for (std::uint32_t seed = 0; seed < 60; ++seed) {
    Scene scene = randomScene(seed);
    for (BodyId id = 0; id < scene.bodyCount(); ++id) {
      scene.setMargin(id, 0);
      const Body& body = scene.body(id);
      if (seed % 3 == 1) scene.setEarlier(id, body.pose);
      if (seed % 3 == 2) scene.setEarlier(id, body.pose, body.mesh.vertices);
    }
    for (const AdjacentPairs adjacent : kBothAdjacent) {
      const DetectionResult still = detect(scene, withAdjacent(adjacent));
      Options options = sweptOptions(adjacent);
      options.first_times = true;
      const DetectionResult swept = detect(scene, options);
      EXPECT_TRUE(samePairs(still.contacts, swept.contacts)) << "seed " << seed;
      EXPECT_EQ(still.counters.rejected, swept.counters.rejected);
      EXPECT_EQ(seed % 3 != 0, swept.without_step.empty() && scene.bodyCount() > 0);
      EXPECT_EQ(swept.contacts.size(), swept.first_times.size());
      for (const FirstContact& first : swept.first_times) EXPECT_EQ(0, first.high);
      found += swept.contacts.size();
    }
  }
  EXPECT_GT(found, 1000U);
}

TEST_P(SweptSuite, AVertexIsSharedIffItIsInBothStates) {
  // Two triangles of one body that touch in one corner at the end, and come there along one way or
  // two.
  const Triangle a{{{0, 0, 0}, {-1, -1, 0}, {-1, 1, 0}}}, b{{{-0.0F, 0, 0}, {1, -1, 0}, {1, 1, 0}}};
  for (const bool together : {true, false}) {
    Scene scene = selfScene(meshOf({a, b}));
    Triangle before = b;
    before.v[0].x = together ? 0.0F : 0.5F;
    scene.setEarlier(0, RigidTransform(), meshOf({a, before}).vertices);
    for (const AdjacentPairs adjacent : kBothAdjacent) {
      EXPECT_EQ(together ? 0U : 1U, contacts(scene, sweptOptions(adjacent)).size());
      EXPECT_TRUE(samePairs(expectedOf(scene, adjacent), contacts(scene, sweptOptions(adjacent))));
    }
  }
}

TEST_P(SweptSuite, TrianglesThatAreNotFiniteInEitherStateAreRejectedAndCounted) {
  Scene scene = pairScene(clothGrid(4, 1, 0, 0), clothGrid(4, 1, 0.5F, 0));
  std::vector<float> before = scene.body(1).mesh.vertices;
  for (std::size_t i = 2; i < before.size(); i += 3) before[i] = -0.5F;
  before[0] = NAN;  // of one or two triangles
  scene.setEarlier(1, RigidTransform(), before);
  TriangleMesh mesh = scene.body(0).mesh;
  mesh.vertices.back() = INFINITY;
  scene.setVertices(0, mesh.vertices.data(), mesh.vertexCount());
  const DetectionResult result = detect(scene, sweptOptions());
  EXPECT_GE(result.counters.rejected, 2U);
  EXPECT_LE(result.counters.rejected, 4U);
  EXPECT_TRUE(samePairs(expectedOf(scene), result.contacts));
  EXPECT_GT(result.contacts.size(), 30U);
  EXPECT_EQ(std::vector<BodyId>{0}, result.without_step);
  std::size_t rejected = 0;
  for (const RejectedTriangles& of : rejectedTriangles(scene, Motion::kSwept)) rejected += of.count;
  EXPECT_EQ(result.counters.rejected, rejected);

  // The same where no partner is near.
  scene.setPose(1, translationBy(0, 0, 9));
  scene.setEarlier(1, translationBy(0, 0, 9), before);
  EXPECT_EQ(result.counters.rejected, detect(scene, sweptOptions()).counters.rejected);
}

TEST_P(SweptSuite, GeometryIsRefused) {
  Options options = sweptOptions();
  options.geometry = true;
  EXPECT_THROW(detector_->detect(Scene(), options), std::invalid_argument);
}

TEST_P(SweptSuite, WhatIsApartAtBothEndsMayHavePassed) {
  Scene scene = pairScene(clothGrid(10, 1, 0, 0), clothGrid(3, 0.1F, 0, 0));
  scene.setPose(1, translationBy(0.4, 0.4, 2));
  scene.setEarlier(1, translationBy(0.4, 0.4, -2));
  EXPECT_TRUE(contacts(scene).empty());
  const auto passed = contacts(scene, sweptOptions());
  EXPECT_FALSE(passed.empty());
  EXPECT_TRUE(samePairs(expectedOf(scene), passed));
}

INSTANTIATE_TEST_SUITE_P(, SweptSuite, ::testing::ValuesIn(sweptBackends()), backendName);

class SweptProducts : public DetectorSuite {};

// No stage loses a contact, whatever the settings: bodies that shake, that have poses, and that
// meet themselves and each other.
TEST_P(SweptProducts, IsTheSameForAnyClustersAndThreads) {
  for (unsigned seed = 1; seed <= 2; ++seed) {
    Scene scene = pairScene(clothGrid(9, 1, 0, 0.2F), clothGrid(8, 0.9F, 0.02F, -0.2F));
    scene.setPairEnabled(0, 0, true);
    scene.setEarlier(0, RigidTransform(), shaken(scene.body(0).mesh, 0.1F, seed));
    scene.setEarlier(1, translationBy(0.3, 0, 0.1), shaken(scene.body(1).mesh, 0.02F, seed + 9));
    for (const AdjacentPairs adjacent : kBothAdjacent) {
      Options options = sweptOptions(adjacent);
      options.first_times = true;
      const std::vector<TrianglePair> expected = expectedOf(scene, adjacent);
      ASSERT_GT(expected.size(), 300U);
      const DetectionResult first = makeBruteForceDetector()->detect(scene, options);
      for (const int clusters : {0, 1, 7, 100}) {
        for (const int threads : {1, 2}) {
          options.clusters = clusters;
          options.threads = threads;
          const DetectionResult& result = detector_->detect(scene, options);
          EXPECT_TRUE(samePairs(expected, result.contacts)) << clusters;
          EXPECT_TRUE(sameTimes(first.first_times, result.first_times)) << clusters;
          EXPECT_TRUE(result.within_pad.empty());
          EXPECT_TRUE(result.guaranteed);
        }
      }
    }
  }
}

// Below 1 contacts may be lost, and none is made up; one cluster loses none.
TEST_P(SweptProducts, OverlapTradesContacts) {
  Scene scene = pairScene(clothGrid(40, 1, 0, 0.2F), clothGrid(40, 0.9F, 0.02F, -0.2F));
  scene.setEarlier(0, RigidTransform(), shaken(scene.body(0).mesh, 0.03F, 1));
  Options options = sweptOptions();
  options.clusters = 800;  // small beside tiles of triangles too
  const std::vector<TrianglePair> all = contacts(scene, options);
  std::size_t found = all.size();
  for (const float overlap : {1.0F, 0.5F, 0.0F}) {
    options.overlap = overlap;
    const DetectionResult& result = detector_->detect(scene, options);
    EXPECT_EQ(overlap == 1, result.guaranteed);
    EXPECT_TRUE(
        std::includes(all.begin(), all.end(), result.contacts.begin(), result.contacts.end()));
    EXPECT_LE(result.contacts.size(), found);
    EXPECT_GT(result.contacts.size(), all.size() / 2);
    found = result.contacts.size();
  }
  EXPECT_LT(found, all.size());
  options.clusters = 1;
  EXPECT_TRUE(samePairs(all, contacts(scene, options)));
}

TEST_P(SweptProducts, InstantAndSweptOfTheSamePairsDoNotTakeTurnsOnOneDetector) {
  PoolSettings settings;
  settings.cpu = GetParam().make;
  const auto detector = makeDetectorPool(settings);
  Scene scene = pairScene(clothGrid(40, 1, 0, 0.03F), clothGrid(30, 1, 0.01F, 0.03F));
  scene.setEarlier(1, translationBy(0, 0, 0.1));
  for (int round = 0; round < 3; ++round) {
    for (const Motion motion : {Motion::kInstant, Motion::kSwept}) {
      Options options;
      options.motion = motion;
      const DetectionResult& result = detector->detect(scene, options);
      EXPECT_EQ(round == 0, result.started_cold) << round;
      EXPECT_TRUE(
          samePairs(makeBruteForceDetector()->detect(scene, options).contacts, result.contacts));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, SweptProducts, ::testing::ValuesIn(sweptProductBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
