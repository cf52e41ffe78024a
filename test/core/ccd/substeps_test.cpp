// Steps in which bodies turn: what belongs to sub-steps, and what does not.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "test/core/ccd/swing_scene.h"

namespace deformable_contact_monitor {
namespace {

TEST_P(SubSteps, AFingerThatSwingsThroughAClothIsSeenAtItsTime) {
  Swing swing;
  Options instant;
  for (const double angle : {0.0, 0.1}) {
    Swing at = swing;
    at.scene.setPose(at.link, turnedAboutZ(angle));
    if (angle == 0)
      at.scene.setVertices(at.cloth, swing.scene.body(1).earlier->vertices.data(),
                           swing.scene.body(1).mesh.vertexCount());
    EXPECT_TRUE(brute_->detect(at.scene, instant).contacts.empty()) << angle;
  }
  const StepResult& result = steps_.detect(swing.scene, swing.paths, 1e-5, timed());
  const DetectionResult found = pairOf(result.detection, swing.link, swing.cloth);
  ASSERT_GT(found.contacts.size(), 4U);
  EXPECT_EQ(result.sub_steps, 11);
  float first = 1;
  for (const FirstContact& time : found.first_times) first = std::min(first, time.low);
  // sin(0.1 t) 0.85 = 0.037 + 0.003 t, but for the waves.
  EXPECT_NEAR(first, 0.45, 0.06);
}

// The tip at (1, 0, 0) moves on an arc of 0.019 rad, which is taken for one straight line. The arc
// is on the edge of the plate at half of it, and from then on beyond it. The line gets there at
// 0.875.
TEST_P(SubSteps, TheFirstTimeOfATipThatTurnsIsNotLate) {
  constexpr double kAngle = 0.019, kArc = 0.5, kLine = 0.875;
  const Vec3d on_arc{std::cos(kArc * kAngle), std::sin(kArc * kAngle), 0};
  const Vec3d on_line{1 - kLine * (1 - std::cos(kAngle)), kLine * std::sin(kAngle), 0};
  const Vec3d along = on_line - on_arc;
  TriangleMesh plate =
      meshOf({{{toFloat(on_arc - along), toFloat(on_line + along), Vec3f{2, 0.01F, 0}}}});
  const TriangleMesh tip = meshOf({{{{1, 0, -0.1F}, {1, 0, 0.1F}, {1, 0, 0.1F}}}});
  Scene scene = pairScene(tip, plate);
  const std::vector<BodyPath> paths{{{0, RigidTransform()}, {1, turnedAboutZ(kAngle)}}, {}};
  const StepResult& result = steps_.detect(scene, paths, 1e-4, timed());
  ASSERT_EQ(result.sub_steps, 1);
  ASSERT_EQ(result.detection.contacts.size(), 1U);
  EXPECT_EQ(result.detection.within_pad[0], 0);
  EXPECT_LE(result.detection.first_times[0].low, kArc + 1e-3);
  EXPECT_GT(result.detection.first_times[0].low, 0.1);
  EXPECT_NEAR(result.detection.first_times[0].high, kLine, 1e-2);
}

TEST_P(SubSteps, WhatMovesStraightHasOneExactStepBesideWhatTurns) {
  const Swing swing;
  Scene without = swing.scene;
  without.setPairEnabled(swing.link, swing.cloth, false);
  const DetectionResult expected = brute_->detect(without, timed());
  const DetectionResult linear = brute_->detect(swing.scene, timed());
  const StepResult& result = steps_.detect(swing.scene, swing.paths, 1e-5, timed());
  ASSERT_GT(expected.contacts.size(), 3U);
  const DetectionResult straight = pairOf(result.detection, swing.cloth, swing.box);
  EXPECT_TRUE(samePairs(pairOf(expected, swing.cloth, swing.box).contacts, straight.contacts));
  EXPECT_TRUE(sameTimes(pairOf(expected, swing.cloth, swing.box), straight));
  EXPECT_EQ(std::count(straight.within_pad.begin(), straight.within_pad.end(), 0),
            static_cast<std::ptrdiff_t>(straight.contacts.size()));
  EXPECT_TRUE(sameTimes(pairOf(expected, swing.cloth, swing.cloth),
                        pairOf(result.detection, swing.cloth, swing.cloth)));
  EXPECT_EQ(result.detection.counters.triangles, swing.scene.triangleCount());
  EXPECT_TRUE(result.detection.guaranteed);
}

// Also of a path that goes straight, in as many samples as you like.
TEST_P(SubSteps, WithoutATurnItIsThePlainStep) {
  Swing swing;
  swing.scene.setPose(swing.link, movedBy(0, 0.08, 0.01));
  swing.paths[swing.link] = {
      {0, RigidTransform()}, {0.25, movedBy(0, 0.02, 0.0025)}, {1, movedBy(0, 0.08, 0.01)}};
  const DetectionResult expected = brute_->detect(swing.scene, timed());
  for (const double tolerance_m : {1e-4, 1e-9}) {
    const StepResult& result = steps_.detect(swing.scene, swing.paths, tolerance_m, timed());
    EXPECT_TRUE(samePairs(expected.contacts, result.detection.contacts));
    EXPECT_TRUE(sameTimes(expected, result.detection));
    EXPECT_TRUE(result.detection.within_pad.empty());
    EXPECT_EQ(result.sub_steps, 1);
    EXPECT_EQ(result.pad_m, 0);
  }
}

TEST_P(SubSteps, WithToleranceZeroAllMoveStraight) {
  const Swing swing;
  const DetectionResult expected = brute_->detect(swing.scene, timed());
  const StepResult& result = steps_.detect(swing.scene, swing.paths, 0, timed());
  ASSERT_GT(pairOf(expected, swing.link, swing.cloth).contacts.size(), 4U);
  EXPECT_TRUE(samePairs(expected.contacts, result.detection.contacts));
  EXPECT_TRUE(sameTimes(expected, result.detection));
  EXPECT_EQ(result.sub_steps, 1);
  EXPECT_EQ(result.pad_m, 0);
}

// The path's ends stand for the poses of the scene, whatever the tolerance.
TEST_P(SubSteps, ThePathSaysWhereTheBodyIs) {
  const Swing swing;
  Swing other = swing;
  other.scene.setPose(other.link, movedBy(7, 7, 7));
  other.scene.clearEarlier(other.link);
  for (const double tolerance_m : {0.0, 1e-4}) {
    const DetectionResult expected =
        steps_.detect(swing.scene, swing.paths, tolerance_m, timed()).detection;
    const DetectionResult& found =
        steps_.detect(other.scene, other.paths, tolerance_m, timed()).detection;
    EXPECT_TRUE(samePairs(expected.contacts, found.contacts));
    EXPECT_TRUE(sameTimes(expected, found));
    EXPECT_TRUE(found.without_step.empty());
  }
  other.scene.clearEarlier(other.box);
  EXPECT_EQ(steps_.detect(other.scene, other.paths, 1e-4, timed()).detection.without_step,
            std::vector<BodyId>{other.box});
}

TEST_P(SubSteps, ZeroMotionIsTheStaticSetWithoutPads) {
  Swing swing;
  const RigidTransform inside = turnedAboutZ(0.05);
  swing.paths[swing.link] = {{0, inside}, {0.5, inside}, {1, inside}};
  swing.scene.setPose(swing.link, inside);
  for (const BodyId id : {swing.link, swing.cloth, swing.box}) {
    swing.scene.setEarlier(id, swing.scene.body(id).pose);
  }
  const DetectionResult expected = brute_->detect(swing.scene, Options());
  ASSERT_GT(expected.contacts.size(), 2U);
  const StepResult& result = steps_.detect(swing.scene, swing.paths, 1e-4, timed());
  EXPECT_TRUE(samePairs(expected.contacts, result.detection.contacts));
  EXPECT_TRUE(result.detection.within_pad.empty());
  EXPECT_EQ(result.pad_m, 0);
}

TEST_P(SubSteps, ContactsOfBothEndsAreInTheStep) {
  for (const double angle : {0.03, 0.045, 0.05, 0.06}) {
    Swing swing;
    swing.scene.setPose(swing.link, turnedAboutZ(angle));
    swing.paths[swing.link].back().pose = turnedAboutZ(angle);
    const std::vector<TrianglePair> now = brute_->detect(swing.scene, Options()).contacts;
    const std::vector<TrianglePair> all =
        steps_.detect(swing.scene, swing.paths, 1e-5, timed()).detection.contacts;
    EXPECT_TRUE(std::includes(all.begin(), all.end(), now.begin(), now.end())) << angle;
  }
}

// In its own frame it does not move. On straight ways over half a turn it would pass through its
// axis, all of it.
TEST_P(SubSteps, ALinkThatTurnsTouchesItselfWhereItDoes) {
  const TriangleMesh mesh =
      meshOf({{{{0.8F, 0, 0}, {0.85F, 0, 0}, {0.8F, 0, 0.05F}}},
              {{{0.8F, 0.01F, 0}, {0.85F, 0.01F, 0}, {0.8F, 0.01F, 0.05F}}},
              {{{0.82F, -0.1F, 0.02F}, {0.82F, 0.1F, 0.02F}, {0.83F, 0, 0.021F}}}});
  Scene scene = selfScene(mesh);
  const std::vector<TrianglePair> expected = brute_->detect(scene, Options()).contacts;
  ASSERT_EQ(expected.size(), 2U);  // of 3
  const StepResult& result =
      steps_.detect(scene, {{{0, RigidTransform()}, {1, turnedAboutZ(M_PI)}}}, 1e-4, timed());
  EXPECT_TRUE(samePairs(expected, result.detection.contacts));
}

// Instantiates the tests of substeps_result_test.cpp too.
INSTANTIATE_TEST_SUITE_P(, SubSteps, ::testing::ValuesIn(sweptBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
