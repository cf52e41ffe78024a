// Steps in which bodies turn: what belongs to sub-steps, and what does not.
#include "core/substeps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cfloat>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "pair_sets.h"
#include "refusal.h"
#include "scenes.h"
#include "test/core/swept/swept_suite.h"

namespace deformable_contact_monitor {
namespace {

RigidTransform turnedAboutZ(double angle, double z = 0) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {{c, -s, 0, s, c, 0, 0, 0, 1}, {0, 0, z}};
}

RigidTransform movedBy(double x, double y, double z) {
  return {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {x, y, z}};
}

// A finger of two triangles, 5 cm high, 0.8 m from the axis that it turns about.
TriangleMesh finger() {
  return meshOf({{{{0.8F, 0, 0}, {0.85F, 0, 0}, {0.8F, 0, 0.05F}}},
                 {{{0.85F, 0, 0}, {0.85F, 0, 0.05F}, {0.8F, 0, 0.05F}}}});
}

// The finger swings through a cloth that hangs across its way and moves a little; a box beside it
// slides. Pairs: finger and cloth, box and cloth, cloth and itself.
struct Swing {
  Scene scene;
  BodyId link, cloth, box;
  std::vector<BodyPath> paths;

  Swing() {
    link = scene.addBody("finger", finger());
    TriangleMesh sheet = clothGrid(12, 0.6F, 0, 0.004F);
    for (std::size_t i = 0; i < sheet.vertices.size(); i += 3) {  // into x z, at y = 4 cm
      const Vec3f v = sheet.vertex(i / 3);
      sheet.vertices[i] = v.x + 0.5F;
      sheet.vertices[i + 1] = v.z + 0.04F;
      sheet.vertices[i + 2] = v.y - 0.3F;
    }
    std::vector<float> earlier = sheet.vertices;
    for (std::size_t i = 1; i < earlier.size(); i += 3) earlier[i] -= 0.003F;
    cloth = scene.addBody("cloth", sheet);
    scene.setEarlier(cloth, RigidTransform(), earlier);
    box = scene.addBody("box", meshOf({{{{0.6F, 0, 0}, {0.65F, 0, 0}, {0.6F, 0, 0.1F}}}}));
    scene.setPose(box, movedBy(0, 0.05, 0));
    scene.setEarlier(box, RigidTransform());
    scene.setPose(link, turnedAboutZ(0.1));
    scene.setEarlier(link, RigidTransform());
    paths = {{{0, RigidTransform()}, {1, turnedAboutZ(0.1)}}, {}, {}};
    scene.setPairEnabled(link, cloth, true);
    scene.setPairEnabled(box, cloth, true);
    scene.setPairEnabled(cloth, cloth, true);
  }
};

Options timed() {
  Options options;
  options.motion = Motion::kSwept;
  options.first_times = true;
  return options;
}

class SubSteps : public DetectorSuite {
 protected:
  std::unique_ptr<Detector> brute_ = makeBruteForceDetector();
  SubStepDetector steps_{*detector_};
};

::testing::AssertionResult sameTimes(const DetectionResult& expected,
                                     const DetectionResult& actual) {
  if (expected.first_times.size() != actual.first_times.size()) {
    return ::testing::AssertionFailure()
           << expected.first_times.size() << " and " << actual.first_times.size() << " times";
  }
  for (std::size_t i = 0; i < expected.first_times.size(); ++i) {
    if (expected.first_times[i].low != actual.first_times[i].low ||
        expected.first_times[i].high != actual.first_times[i].high) {
      return ::testing::AssertionFailure() << "times of " << expected.contacts[i] << " differ";
    }
  }
  return ::testing::AssertionSuccess();
}

// Those of a pair of bodies, and what belongs to them.
DetectionResult pairOf(const DetectionResult& all, BodyId a, BodyId b) {
  DetectionResult some;
  for (std::size_t i = 0; i < all.contacts.size(); ++i) {
    if (all.contacts[i].body_a != a || all.contacts[i].body_b != b) continue;
    some.contacts.push_back(all.contacts[i]);
    some.first_times.push_back(all.first_times[i]);
    if (!all.within_pad.empty()) some.within_pad.push_back(all.within_pad[i]);
  }
  return some;
}

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

// In bodies that turn, that move straight, and that are in pairs of both kinds.
TEST_P(SubSteps, RejectedTrianglesCountOnce) {
  Swing swing;
  for (const BodyId id : {swing.link, swing.cloth, swing.box}) {
    TriangleMesh mesh = swing.scene.body(id).mesh;
    mesh.vertices[0] = NAN;
    swing.scene.setVertices(id, mesh.vertices.data(), mesh.vertexCount());
  }
  const std::uint64_t expected = brute_->detect(swing.scene, timed()).counters.rejected;
  ASSERT_GE(expected, 3U);
  const StepResult& result = steps_.detect(swing.scene, swing.paths, 1e-4, timed());
  EXPECT_EQ(result.detection.counters.rejected, expected);
  EXPECT_TRUE(result.outlying.empty());
}

// One vertex at 1e30 would make all pads 1e23 m.
TEST_P(SubSteps, AnOutlierCostsItsOwnTrianglesAlone) {
  Swing swing;
  const std::vector<TrianglePair> all =
      pairOf(steps_.detect(swing.scene, swing.paths, 1e-4, timed()).detection, 0, 1).contacts;
  TriangleMesh sheet = swing.scene.body(swing.cloth).mesh;
  sheet.vertices[0] = 1e30F;
  swing.scene.setVertices(swing.cloth, sheet.vertices.data(), sheet.vertexCount());
  const StepResult& result = steps_.detect(swing.scene, swing.paths, 1e-4, timed());
  EXPECT_LT(result.pad_m, 2e-4);
  EXPECT_EQ(result.outlying, std::vector<BodyId>{swing.cloth});
  EXPECT_GT(result.detection.counters.rejected, 0U);
  EXPECT_TRUE(samePairs(all, pairOf(result.detection, 0, 1).contacts));
}

TEST_P(SubSteps, WhatIsWrongIsNamed) {
  const Swing swing;
  const auto ofPath = [&](const BodyPath& path) {
    std::vector<BodyPath> paths = swing.paths;
    paths[swing.link] = path;
    return refusal([&] { steps_.detect(swing.scene, paths, 1e-4, Options()); });
  };
  const RigidTransform id;
  EXPECT_EQ(ofPath({{0, id}}), "finger: its path has one sample alone");
  EXPECT_EQ(ofPath({{0.1, id}, {1, id}}), "finger: its path does not go from 0 to 1");
  EXPECT_EQ(ofPath({{0, id}, {0.9, id}}), "finger: its path does not go from 0 to 1");
  EXPECT_EQ(ofPath({{0, id}, {0.5, id}, {0.5, id}, {1, id}}),
            "finger: its path does not ascend at sample 2");
  EXPECT_EQ(ofPath({{0, id}, {NAN, id}, {1, id}}), "finger: its path does not ascend at sample 1");
  RigidTransform bad;
  bad.translation[1] = INFINITY;
  EXPECT_EQ(ofPath({{0, id}, {0.5, bad}, {1, id}}),
            "finger: its path has a non-finite number in sample 1");
  for (const double first : {-1.0, 0.0, 1.1}) {
    bad = RigidTransform();
    bad.rotation[0] = first;
    EXPECT_EQ(ofPath({{0, id}, {1, bad}}), "finger: its path has no rotation in sample 1");
  }
  EXPECT_EQ(refusal([&] {
              steps_.detect(swing.scene, {{}, {}}, 1e-4, Options());
            }),
            "2 paths for 3 bodies");
  for (const double tolerance_m : {-1e-4, double{NAN}, double{INFINITY}}) {
    EXPECT_NE(refusal([&] { steps_.detect(swing.scene, swing.paths, tolerance_m, Options()); }),
              "");
  }
}

TEST_P(SubSteps, VerticesOnADeviceAreRefusedByName) {
  float somewhere[3] = {0, 0, 0};
  Swing swing;
  swing.scene.setDeviceVertices(swing.link, somewhere,
                                swing.scene.body(swing.link).mesh.vertexCount());
  EXPECT_EQ(refusal([&] { steps_.detect(swing.scene, swing.paths, 1e-4, Options()); }),
            "finger: its vertices are on a device, where its path cannot be looked at");
}

// Passes on what another finds, but stops after so many calls.
class Stopping : public Detector {
 public:
  Stopping(Detector& detector, int calls, std::atomic<bool>* stop)
      : detector_(detector), before_(calls), stop_(stop) {}
  std::string backend() const override { return "stopping"; }
  void reset() override {}
  const DetectionResult& detect(const Scene& scene, const Options& options) override {
    if (calls_++ == before_) *stop_ = true;
    return detector_.detect(scene, options);
  }
  int calls() const { return calls_; }

 private:
  Detector& detector_;
  int before_, calls_ = 0;
  std::atomic<bool>* stop_;
};

TEST_P(SubSteps, AStopInTheMiddleKeepsWhatWasFoundAndSaysSo) {
  const Swing swing;
  const std::vector<TrianglePair> all =
      steps_.detect(swing.scene, swing.paths, 1e-5, timed()).detection.contacts;
  std::size_t before = 0;
  for (const int calls : {0, 1, 4, 6}) {
    std::atomic<bool> stop{false};
    Stopping stopping(*detector_, calls, &stop);
    SubStepDetector steps(stopping);
    Options options = timed();
    options.limits.stop = &stop;
    const DetectionResult& found = steps.detect(swing.scene, swing.paths, 1e-5, options).detection;
    EXPECT_TRUE(found.cut_off);
    EXPECT_EQ(found.cut_off_because, "stopped");
    EXPECT_EQ(stopping.calls(), calls + 1);
    EXPECT_TRUE(isOrdered(found.contacts));
    EXPECT_TRUE(
        std::includes(all.begin(), all.end(), found.contacts.begin(), found.contacts.end()));
    EXPECT_LT(found.contacts.size(), all.size());
    EXPECT_GE(found.contacts.size(), before);
    before = found.contacts.size();
  }
  EXPECT_GT(before, 0U);
  Options late = timed();
  late.limits.deadline = SteadyTime::min();
  EXPECT_TRUE(steps_.detect(swing.scene, swing.paths, 1e-5, late).detection.isOutOfTime());
  EXPECT_EQ(steps_.detect(swing.scene, swing.paths, 1e-5, timed()).detection.contacts, all);
}

// Says what it was told to, in turn.
class Scripted : public Detector {
 public:
  explicit Scripted(std::vector<DetectionResult> script) : script_(std::move(script)) {}
  std::string backend() const override { return "scripted"; }
  void reset() override {}
  const DetectionResult& detect(const Scene&, const Options&) override {
    return script_.at(next_++ % script_.size());
  }

 private:
  std::vector<DetectionResult> script_;
  std::size_t next_ = 0;
};

TEST_P(SubSteps, ResultsAreOne) {
  const TrianglePair p(0, 0, 1, 0), q(0, 0, 1, 1), r(0, 1, 1, 0);
  std::vector<DetectionResult> script(4);  // of quarters of the step
  script[0].contacts = {q, r};
  script[0].within_pad = {1, 1};
  script[0].first_times = {{0.5F, 1}, {0.25F, 1}};
  script[1].contacts = {p, r};
  script[1].within_pad = {0, 1};
  script[1].first_times = {{0.1F, 0.1000001F}, {0, 1}};
  script[2].contacts = {p, q};
  script[2].within_pad = {1, 0};
  script[2].first_times = {{0, 1}, {0.5F, 0.5F}};
  script[3].left_out = 3;
  script[3].cutOff("memory_limit_mib");
  for (DetectionResult& part : script) {
    part.guaranteed = true;
    part.counters.candidates = 10;
    part.counters.largest_cluster = 5;
    part.stages_ms = {{"pose", 1}, {"judge", 2}};
    part.detect_ms = 4;
    part.memory_bytes = 100;
  }
  Scripted scripted(script);
  SubStepDetector steps(scripted);
  Scene scene = pairScene(
      meshOf({{{{1, 0, 0}, {0, 0, 0}, {0, 0, 0}}}, {{{1, 0, 0}, {0, 0, 0}, {0, 0, 0}}}}), finger());
  BodyPath path;  // one piece each
  for (int k = 0; k <= 4; ++k) path.push_back({k / 4.0, turnedAboutZ(0.1 * (k % 2))});
  const StepResult& result = steps.detect(scene, {path, {}}, 2e-3, timed());
  ASSERT_EQ(result.sub_steps, 4);
  const DetectionResult& all = result.detection;
  EXPECT_EQ(all.contacts, (std::vector<TrianglePair>{p, q, r}));
  EXPECT_EQ(all.within_pad, (std::vector<std::uint8_t>{0, 0, 1}));
  EXPECT_NEAR(all.first_times[0].low, 0.275, 1e-7);
  EXPECT_LE(all.first_times[0].low, 0.25 + 0.25 * double{0.1F});
  EXPECT_GE(all.first_times[0].high, 0.25 + 0.25 * double{0.1000001F});
  EXPECT_EQ(all.first_times[1].low, std::nextafter(0.625F, 0.0F));
  EXPECT_EQ(all.first_times[1].high, std::nextafter(0.625F, 1.0F));
  EXPECT_LE(all.first_times[2].low, 0.0625F);
  EXPECT_NEAR(all.first_times[2].low, 0.0625F, 1e-7);
  EXPECT_EQ(all.first_times[2].high, 1);
  EXPECT_EQ(all.left_out, 3U);
  EXPECT_EQ(all.cut_off_because, "memory_limit_mib");
  EXPECT_TRUE(all.guaranteed);
  EXPECT_EQ(all.counters.candidates, 40U);
  EXPECT_EQ(all.counters.largest_cluster, 5U);
  const std::vector<std::pair<std::string, double>> stages{{"pose", 4}, {"judge", 8}};
  EXPECT_EQ(all.stages_ms, stages);
  EXPECT_EQ(all.detect_ms, 16);
  EXPECT_EQ(all.memory_bytes, 100U);
}

INSTANTIATE_TEST_SUITE_P(, SubSteps, ::testing::ValuesIn(sweptBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
