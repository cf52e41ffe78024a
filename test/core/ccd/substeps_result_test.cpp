// Steps in which bodies turn: what is refused, left out, cut off and added up.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "refusal.h"
#include "test/core/ccd/swing_scene.h"

namespace deformable_contact_monitor {
namespace {

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

// The nearest pairs are those of the end of the step, whether bodies turn, move straight, or have
// vertices that take no part in sub-steps.
TEST_P(SubSteps, NearestPairsAreOfThePresent) {
  for (const float outlier : {0.0F, 1e30F}) {
    Swing swing;
    for (BodyId id = 0; id < swing.scene.bodyCount(); ++id) swing.scene.setMargin(id, 2);
    TriangleMesh sheet = swing.scene.body(swing.cloth).mesh;
    if (outlier > 0) sheet.vertices[0] = outlier;
    swing.scene.setVertices(swing.cloth, sheet.vertices.data(), sheet.vertexCount());
    Options options = timed();
    options.nearest = true;
    const StepResult& result = steps_.detect(swing.scene, swing.paths, 1e-4, options);
    EXPECT_GT(result.sub_steps, 1);
    EXPECT_EQ(outlier > 0, !result.outlying.empty());
    Scene present = swing.scene;
    for (BodyId id = 0; id < present.bodyCount(); ++id) {
      if (!swing.paths[id].empty()) present.setPose(id, swing.paths[id].back().pose);
    }
    Options now;
    now.nearest = true;
    const std::vector<NearestPair> expected = brute_->detect(present, now).nearest;
    EXPECT_GE(expected.size(), 2U);
    EXPECT_EQ(expected, result.detection.nearest);
    options.nearest = false;
    EXPECT_TRUE(steps_.detect(swing.scene, swing.paths, 1e-4, options).detection.nearest.empty());
  }
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
  void swapResult(DetectionResult& result) override { detector_.swapResult(result); }
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
  void swapResult(DetectionResult& result) override { result_.swap(result); }
  const DetectionResult& detect(const Scene&, const Options&) override {
    return result_ = script_.at(next_++ % script_.size());
  }

 private:
  std::vector<DetectionResult> script_;
  DetectionResult result_;
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
    part.stages_ms = {{"transform", 1}, {"narrow_phase", 2}};
    part.detect_ms = 4;
    part.memory_bytes = 100;
    part.memory_is_whole = true;
    part.detector_bytes = 70;
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
  EXPECT_EQ(all.first_times[1].low, std::nextafter(0.125F, 0.0F)) << "within the pads";
  EXPECT_EQ(all.first_times[1].high, std::nextafter(0.625F, 1.0F));
  EXPECT_LE(all.first_times[2].low, 0.0625F);
  EXPECT_NEAR(all.first_times[2].low, 0.0625F, 1e-7);
  EXPECT_EQ(all.first_times[2].high, 1);
  EXPECT_EQ(all.left_out, 3U);
  EXPECT_EQ(all.cut_off_because, "memory_limit_mib");
  EXPECT_TRUE(all.guaranteed);
  EXPECT_EQ(all.counters.candidates, 40U);
  EXPECT_EQ(all.counters.largest_cluster, 5U);
  const std::vector<std::pair<std::string, double>> stages{{"transform", 4}, {"narrow_phase", 8}};
  EXPECT_EQ(all.stages_ms, stages);
  EXPECT_EQ(all.detect_ms, 16);
  EXPECT_EQ(all.memory_bytes, 100U);
  EXPECT_TRUE(all.memory_is_whole);
  EXPECT_EQ(all.detector_bytes, 70U);
}

}  // namespace
}  // namespace deformable_contact_monitor
