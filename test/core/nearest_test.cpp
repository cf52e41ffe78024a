// The nearest pair of two bodies: every backend finds that of brute force, to the bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cfloat>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "detector_suite.h"
#include "nearest_fixture.h"
#include "random_scenes.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

using NearestSuite = NearestTest;

TEST_P(NearestSuite, IsThatOfBruteForceInRandomScenes) {
  std::size_t apart = 0, touching = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE(seed);
    Scene scene = randomScene(seed);
    std::mt19937 random(seed);
    static constexpr float kMargins[] = {0, 0.1F, 0.5F, 1, 10, 1e-42F, 1e20F, FLT_MAX};
    for (BodyId id = 0; id < scene.bodyCount(); ++id) scene.setMargin(id, kMargins[random() % 8]);
    for (const NearestPair& pair : expectSame(scene)) ++(pair.distance_m > 0 ? apart : touching);
  }
  EXPECT_GT(apart, 50U);
  EXPECT_GT(touching, 50U);
}

TEST_P(NearestSuite, IsTheLeastOfThousandsOfTies) {
  // Of two flat grids each triangle is as near as the others.
  for (const float gap : {0.02F, 0.1F, 1e-3F}) {
    SCOPED_TRACE(gap);
    Scene scene = within(1, pairScene(clothGrid(17, 1, 0, 0), clothGrid(13, 1, gap, 0)));
    EXPECT_EQ(1U, expectSame(scene).size());
    scene.setMesh(0, shuffled(scene.body(0).mesh, 1));
    expectSame(scene);
    scene.setMesh(1, shuffled(scene.body(1).mesh, 2));
    expectSame(scene);
    for (int i = 0; i < 4; ++i) {
      turn(scene, i);
      expectSame(scene);
    }
  }
  // Grids in one plane, which touch all over; and side by side.
  Scene flat = within(1, pairScene(clothGrid(12, 1, 0, 0), clothGrid(9, 1, 0, 0)));
  ASSERT_EQ(1U, expectSame(flat).size());
  RigidTransform beside;
  beside.translation[0] = 1.25;
  flat.setPose(1, beside);
  ASSERT_EQ(0.25F, expectSame(flat).at(0).distance_m);
}

TEST_P(NearestSuite, IsTheLeastOfCubesFaceToFaceAndOfDuplicates) {
  const TriangleMesh cube = cubeGrid(4);
  Scene scene = within(3, pairScene(shuffled(cube, 3), shuffled(cube, 4)));
  for (const double at : {2.0, 1.5, 1.0, 1.0 + 0x1p-20, 0.5}) {
    SCOPED_TRACE(at);
    RigidTransform pose;
    pose.translation[2] = at;
    scene.setPose(1, pose);
    ASSERT_EQ(1U, expectSame(scene).size());
    pose.translation[0] = at;  // over an edge
    scene.setPose(1, pose);
    ASSERT_EQ(1U, expectSame(scene).size());
  }
  const Triangle low{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  const Triangle high{{{0.1F, 0.1F, 0.3F}, {1, 0, 0.7F}, {0, 1, 0.5F}}};
  Scene twins = within(1, pairScene(meshOf(std::vector<Triangle>(70, low)),
                                    meshOf(std::vector<Triangle>(90, high))));
  const NearestPair nearest = expectSame(twins).at(0);
  EXPECT_EQ(0U, nearest.pair.triangle_a);
  EXPECT_EQ(0U, nearest.pair.triangle_b);
}

// Distances that differ by some steps of float32, of thousands of triangles. A bound that is a
// millionth too large leaves out the nearest ones.
TEST_P(NearestSuite, IsTheNearestOfAlmostTies) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(seed);
    Scene scene = within(1, almostTied(seed, 33));
    if (seed % 3 != 0) turn(scene, static_cast<int>(seed));
    expectSame(scene);
    roughen(scene, 1, seed + 100);
    expectSame(scene);
  }
}

TEST_P(NearestSuite, IsThatOfBruteForceAtAnyScale) {
  for (const int exponent : {-148, -126, -100, -60, -1, 0, 1, 60, 100, 120}) {
    SCOPED_TRACE(exponent);
    Scene scene = pairScene(scaled(clothGrid(9, 1, 0, 0.1F), exponent),
                            scaled(clothGrid(11, 1, 0.25F, 0.05F), exponent));
    for (const float margin_m : {FLT_MAX, std::ldexp(0.2F, exponent), 0.0F, 1e-44F}) {
      scene.setMargin(0, margin_m);
      expectSame(scene);
    }
  }
}

TEST_P(NearestSuite, IsThatOfBruteForceWithFarAndRejectedVertices) {
  static constexpr float kStrange[] = {1e30F, -3e38F, 1e-40F, NAN, INFINITY, -INFINITY, FLT_MAX};
  for (unsigned seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    Scene scene = pairScene(clothGrid(8, 1, 0, 0.1F), clothGrid(7, 1, 0.3F, 0.1F));
    scene.setMargin(1, seed % 5 == 0 ? FLT_MAX : 10);
    if (seed % 2 == 0) turn(scene, static_cast<int>(seed));
    for (BodyId id = 0; id < 2; ++id) {
      std::vector<float> vertices = scene.body(id).mesh.vertices;
      for (std::size_t n = random() % 40; n > 0; --n) {
        vertices[random() % vertices.size()] = kStrange[random() % 7];
      }
      scene.setVertices(id, vertices.data(), vertices.size() / 3);
    }
    expectSame(scene);
  }
  Scene none = within(10, pairScene(clothGrid(3, 1, 0, 0), clothGrid(3, 1, 1, 0)));
  const std::vector<float> nowhere(none.body(0).mesh.vertices.size(), NAN);
  none.setVertices(0, nowhere.data(), nowhere.size() / 3);
  EXPECT_TRUE(expectSame(none).empty());
  none.setMesh(0, {});
  EXPECT_TRUE(expectSame(none).empty());
  none.setMesh(1, {});
  EXPECT_TRUE(expectSame(none).empty());
}

TEST_P(NearestSuite, EndsAtTheMarginItself) {
  Scene scene = pairScene(clothGrid(5, 1, 0, 0), clothGrid(4, 1, 0.3F, 0));
  scene.setMargin(0, 0.3F);
  ASSERT_EQ(1U, expectSame(scene).size());
  EXPECT_EQ(0.3F, detector_->detect(scene, withNearest()).nearest[0].distance_m);
  scene.setMargin(0, std::nextafter(0.3F, 0.0F));
  EXPECT_TRUE(expectSame(scene).empty());
  scene.setMargin(1, 0.3F);  // the larger one counts
  EXPECT_EQ(1U, expectSame(scene).size());
  scene.setMargin(0, 0);
  scene.setMargin(1, 0);
  EXPECT_TRUE(expectSame(scene).empty());
}

// What the last cycle found is of use only while triangles are the same ones.
TEST_P(NearestSuite, ForgetsWhatChanged) {
  std::mt19937 random(7);
  Scene scene = within(2, pairScene(clothGrid(20, 1, 0, 0.1F), cubeGrid(3)));
  scene.addBody("third", clothGrid(3, 1, 3, 0.1F));
  scene.setPairEnabled(0, 2, true);
  const auto unit = [&random] { return static_cast<double>(random()) * 0x1p-32; };
  for (int i = 0; i < 120; ++i) {
    SCOPED_TRACE(i);
    RigidTransform pose;
    for (double& t : pose.translation) t = 3 * unit() - 1.5;
    scene.setPose(1, pose);
    if (i % 5 == 1) scene.setMesh(0, clothGrid(2 + static_cast<int>(random() % 20), 1, 0, 0.2F));
    if (i % 7 == 2) scene.setMesh(1, shuffled(cubeGrid(1 + i % 4), random()));
    if (i % 11 == 3) scene.setMesh(2, {});
    if (i % 11 == 6) scene.setMesh(2, clothGrid(4, 1, 1, 0.3F));
    if (i % 13 == 4) scene.setPairEnabled(0, 1, !scene.pairEnabled(0, 1));
    if (i % 17 == 5) scene.setPairEnabled(1, 2, !scene.pairEnabled(1, 2));
    if (i % 19 == 6) detector_->reset();
    expectSame(scene);
  }
}

TEST_P(NearestSuite, LeavesContactsAsTheyWere) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    Scene scene = randomScene(seed);
    for (BodyId id = 0; id < scene.bodyCount(); ++id) scene.setMargin(id, 0.5F);
    const DetectionResult all = detector_->detect(scene, Options());
    Options options = withNearest();
    options.near_pairs = true;
    const DetectionResult both = detector_->detect(scene, options);
    EXPECT_TRUE(samePairs(all.contacts, both.contacts));
    EXPECT_TRUE(sameBits(all.separations_m, both.separations_m));
    options.near_pairs = false;
    const DetectionResult touching = detector_->detect(scene, options);
    EXPECT_EQ(both.nearest, touching.nearest);
    EXPECT_TRUE(touching.separations_m.empty());
    std::vector<TrianglePair> expected;
    for (std::size_t i = 0; i < all.contacts.size(); ++i) {
      if (all.touches(i)) expected.push_back(all.contacts[i]);
    }
    EXPECT_TRUE(samePairs(expected, touching.contacts));
    EXPECT_TRUE(all.nearest.empty());
  }
}

TEST_P(NearestSuite, IsOfThePresentInSweptMotion) {
  std::size_t swept_through = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    Scene scene = within(1, pairScene(clothGrid(6, 1, 0, 0.05F), clothGrid(5, 1, 0.2F, 0.05F)));
    RigidTransform below;
    below.translation[2] = seed % 2 == 0 ? -0.5 : 0;
    scene.setEarlier(1, below);
    if (seed % 3 == 0) turn(scene, static_cast<int>(seed));
    if (seed % 5 == 0) roughen(scene, 0, seed);
    Options swept = withNearest();
    swept.motion = Motion::kSwept;
    const std::vector<NearestPair> now = exact_->detect(scene, withNearest()).nearest;
    const DetectionResult& found = detector_->detect(scene, swept);
    EXPECT_EQ(now, found.nearest);
    swept_through += !found.contacts.empty() && found.nearest.at(0).distance_m > 0;
  }
  EXPECT_GT(swept_through, 10U);
}

// Conservative predicates list more contacts, and an overlap of 0 loses some; distances stay exact.
TEST_P(NearestSuite, IsExactWhateverThePredicatesAndTheOverlap) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    Scene scene = randomScene(seed);
    for (BodyId id = 0; id < scene.bodyCount(); ++id) scene.setMargin(id, 1);
    const std::vector<NearestPair> expected = exact_->detect(scene, withNearest()).nearest;
    Options options = withNearest();
    options.predicates = Predicates::kConservative;
    options.overlap = seed % 2 == 0 ? 1 : 0;
    EXPECT_EQ(expected, detector_->detect(scene, options).nearest);
  }
}

TEST_P(NearestSuite, IsMissingWhereTheCycleWasStopped) {
  const Scene scene = within(1, pairScene(clothGrid(9, 1, 0, 0), clothGrid(8, 1, 0.3F, 0)));
  const std::atomic<bool> stop{true};
  Options options = withNearest();
  options.limits.stop = &stop;
  const DetectionResult& result = detector_->detect(scene, options);
  EXPECT_TRUE(result.nearest.empty());
  EXPECT_TRUE(result.cut_off);
}

TEST_P(NearestSuite, IsAPartOfWhatIsSwapped) {
  const Scene scene = within(1, pairScene(clothGrid(9, 1, 0, 0), clothGrid(8, 1, 0.3F, 0)));
  const std::vector<NearestPair> expected = detector_->detect(scene, withNearest()).nearest;
  DetectionResult taken;
  detector_->swapResult(taken);
  EXPECT_EQ(1U, expected.size());
  EXPECT_EQ(expected, taken.nearest);
  EXPECT_TRUE(detector_->detect(scene, Options()).nearest.empty());
}

INSTANTIATE_TEST_SUITE_P(, NearestSuite, ::testing::ValuesIn(productBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
