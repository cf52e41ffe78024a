// One detector from cycle to cycle: modes that take turns, bodies and triangles that come and go,
// what a step without an earlier state says, and what has no part in swept motion.
#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <vector>

#include "refusal.h"
#include "scenes.h"
#include "swept_expected.h"

namespace deformable_contact_monitor {
namespace {

class SweptCycles : public SweptFixture {
 protected:
  // Each contact of the step, as a detector that starts from nothing finds them.
  static std::vector<TrianglePair> anew(const Scene& scene, const Options& options) {
    return GetParam().make()->detect(scene, options).contacts;
  }

  void expectAsAnew(const Scene& scene, const Options& options, const std::string& what) {
    const std::vector<TrianglePair> found = contacts(scene, options);
    ASSERT_TRUE(samePairs(anew(scene, options), found)) << what;
  }
};

// A cloth that falls through another one, which stands.
Scene fallingCloth() {
  Scene scene = pairScene(clothGrid(8, 4, 0, 0.1F), clothGrid(8, 4, -1, 0.1F));
  scene.setEarlier(1, RigidTransform(), clothGrid(8, 4, 1, 0.1F).vertices);
  return scene;
}

TEST_P(SweptCycles, ModesTakeTurns) {
  for (std::uint32_t seed = 0; seed < 200 && !HasFatalFailure(); ++seed) {
    const Scene scene = randomSweptScene(seed);
    const std::string what = "seed " + std::to_string(seed);
    Options instant = withAdjacent(kBothAdjacent[seed % 2]);
    instant.geometry = seed % 3 == 0;
    expectAsAnew(scene, instant, what + ", instant");
    expectAsAnew(scene, sweptOptions(kBothAdjacent[seed % 2]), what + ", swept");
    expectAsAnew(scene, instant, what + ", instant again");
    expectAsAnew(scene, timedOptions(kBothAdjacent[seed % 2]), what + ", swept with times");
  }
}

TEST_P(SweptCycles, WhatThePreviousCycleLeftIsNotInTheResult) {
  Scene scene = fallingCloth();
  scene.setMargin(0, 0.5F);
  scene.setPad(1, 0.25F);
  Options instant;
  instant.geometry = true;
  const std::size_t near = detector_->detect(scene, instant).contacts.size();
  EXPECT_EQ(near, 0U);
  const DetectionResult& result = detector_->detect(scene, timedOptions());
  EXPECT_GT(result.contacts.size(), 100U);
  EXPECT_TRUE(result.separations_m.empty());
  EXPECT_TRUE(result.geometry.empty());
  EXPECT_EQ(result.first_times.size(), result.contacts.size());
  EXPECT_EQ(result.within_pad.size(), result.contacts.size());
  EXPECT_EQ(result.without_step, std::vector<BodyId>{0});
  detector_->detect(scene, sweptOptions());
  EXPECT_TRUE(result.first_times.empty());
  detector_->detect(scene, Options());
  EXPECT_TRUE(result.within_pad.empty());
  EXPECT_TRUE(result.without_step.empty());
}

TEST_P(SweptCycles, MarginsPlayNoPart) {
  Scene scene = fallingCloth();
  const std::vector<TrianglePair> before = swept(scene);
  scene.setMargin(0, 0.5F);
  scene.setMargin(1, 100);
  EXPECT_TRUE(samePairs(before, swept(scene)));
  EXPECT_TRUE(detector_->detect(scene, sweptOptions()).separations_m.empty());
}

TEST_P(SweptCycles, ABodyWithoutAnEarlierStateStandsStillAndIsNamed) {
  Scene scene = fallingCloth();
  const BodyId apart = scene.addBody("no pair of its", clothGrid(2, 1, 0, 0));
  EXPECT_EQ(detector_->detect(scene, sweptOptions()).without_step, std::vector<BodyId>{0});
  EXPECT_GT(swept(scene).size(), 100U);
  scene.clearEarlier(1);
  EXPECT_EQ(detector_->detect(scene, sweptOptions()).without_step, (std::vector<BodyId>{0, 1}));
  EXPECT_TRUE(swept(scene).empty());
  scene.setEarlier(0, RigidTransform());
  scene.setEarlier(1, RigidTransform(), clothGrid(8, 4, 1, 0.1F).vertices);
  EXPECT_TRUE(detector_->detect(scene, sweptOptions()).without_step.empty());
  EXPECT_GT(swept(scene).size(), 100U);
  scene.setPairEnabled(apart, 0, true);
  EXPECT_EQ(detector_->detect(scene, sweptOptions()).without_step, std::vector<BodyId>{apart});
}

// Each change alone, with what a detector keeps for the next cycle.
TEST_P(SweptCycles, ScenesChange) {
  Scene scene = fallingCloth();
  const Options options = timedOptions();
  scene.setEarlier(1, RigidTransform(), clothGrid(8, 4, -0.95F, 0.1F).vertices);
  expectAsAnew(scene, options, "at first");
  EXPECT_TRUE(swept(scene).empty());
  scene.setEarlier(1, RigidTransform(), clothGrid(8, 4, 1, 0.1F).vertices);
  expectAsAnew(scene, options, "another earlier state");
  EXPECT_GT(swept(scene).size(), 100U);
  RigidTransform up;
  up.translation[2] = 3;
  scene.setEarlier(1, up);
  expectAsAnew(scene, options, "an earlier pose");
  EXPECT_GT(swept(scene).size(), 100U);
  scene.setPose(1, up);
  expectAsAnew(scene, options, "the pose has come to it");
  EXPECT_TRUE(swept(scene).empty());
  const TriangleMesh next = clothGrid(8, 4, -5, 0.1F);
  scene.setVertices(1, next.vertices.data(), next.vertexCount());
  expectAsAnew(scene, options, "other vertices, the earlier ones are they too");
  scene.setEarlier(1, up, clothGrid(8, 4, 0.5F, 0.1F).vertices);
  expectAsAnew(scene, options, "vertices of both states");
  EXPECT_GT(swept(scene).size(), 100U);
  scene.setMesh(1, clothGrid(3, 4, -5, 0.1F));
  expectAsAnew(scene, options, "other triangles, which have no earlier state");
  EXPECT_EQ(detector_->detect(scene, options).without_step, (std::vector<BodyId>{0, 1}));
  const BodyId added = scene.addBody("a third one", clothGrid(4, 4, -3, 0.1F));
  scene.setEarlier(added, up);
  for (const BodyId other : {0U, 1U, added}) scene.setPairEnabled(added, other, true);
  expectAsAnew(scene, options, "a body more");
  scene.setPairEnabled(0, 1, false);
  expectAsAnew(scene, options, "a pair less");
  detector_->reset();
  expectAsAnew(scene, options, "after a reset");
}

TEST_P(SweptCycles, ScenesOfAllSizesTakeTurns) {
  const Scene large = fallingCloth();
  for (std::uint32_t seed = 0; seed < 60 && !HasFatalFailure(); ++seed) {
    const Scene small = randomSweptScene(seed);
    expectAsAnew(small, sweptOptions(), "seed " + std::to_string(seed));
    if (seed % 8 == 0) expectAsAnew(large, sweptOptions(), "the large one");
    if (seed % 8 == 4) expectAsAnew(large, Options(), "the large one, instant");
  }
  expectAsAnew(Scene(), sweptOptions(), "nothing");
  Scene empty = pairScene(TriangleMesh(), TriangleMesh());
  empty.setEarlier(0, RigidTransform());
  expectAsAnew(empty, sweptOptions(), "bodies without triangles");
}

TEST_P(SweptCycles, WhatIsOfOneModeAloneIsRefusedInTheOther) {
  const Scene scene = fallingCloth();
  const auto refused = [&](const Options& options) {
    return refusal([&] { detector_->detect(scene, options); });
  };
  Options geometry = sweptOptions();
  geometry.geometry = true;
  EXPECT_EQ(refused(geometry), "geometry is of one moment, motion is swept");
  Options times;
  times.first_times = true;
  EXPECT_EQ(refused(times), "first_times is of a step, motion is instant");
  geometry.overlap = 2;
  EXPECT_NE(refused(geometry).find("overlap is 2"), std::string::npos);
  EXPECT_NE(refused(geometry).find("; geometry is of one moment"), std::string::npos);
  EXPECT_GT(swept(scene).size(), 100U);
}

// All pairs found until the stop are contacts, and the next cycle is complete.
TEST_P(SweptCycles, AStepThatIsStoppedSaysSo) {
  const Scene scene = fallingCloth();
  const std::vector<TrianglePair> all = swept(scene);
  const std::atomic<bool> stop{true};
  Options options = timedOptions();
  options.limits.stop = &stop;
  const DetectionResult& result = detector_->detect(scene, options);
  EXPECT_TRUE(result.cut_off);
  EXPECT_EQ(result.cut_off_because, "stopped");
  EXPECT_TRUE(includes(all, result.contacts));
  EXPECT_EQ(result.contacts.size(), result.first_times.size());
  EXPECT_TRUE(samePairs(all, swept(scene)));
  EXPECT_FALSE(detector_->detect(scene, sweptOptions()).cut_off);
}

INSTANTIATE_TEST_SUITE_P(, SweptCycles, ::testing::ValuesIn(sweptBackends()), backendName);

class SweptTrade : public SweptFixture {};

// Below 1 contacts may be lost, and none is made up.
TEST_P(SweptTrade, LessOverlapIsNotGuaranteed) {
  const Scene scene = fallingCloth();
  const std::vector<TrianglePair> all = swept(scene);
  for (const float overlap : {0.0F, 0.5F}) {
    Options options = sweptOptions();
    options.clusters = 16;
    options.overlap = overlap;
    const DetectionResult& result = detector_->detect(scene, options);
    EXPECT_TRUE(includes(all, result.contacts));
    EXPECT_FALSE(result.guaranteed);
  }
}

INSTANTIATE_TEST_SUITE_P(, SweptTrade, ::testing::ValuesIn(sweptProductBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
