// Swept motion on CUDA, beyond what the suite asks of every backend (test/core/swept).
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <vector>

#include "core/cpu_detector.h"
#include "cuda/cuda_detector.h"
#include "cuda/device/cuda_error.h"
#include "pair_sets.h"
#include "scenes.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

// Two wavy cloths that pass through one another and themselves, and a small body that is posed.
Scene passingCloths(float way) {
  Scene scene;
  const BodyId low = scene.addBody("low", clothGrid(30, 1, 0, 0.1F));
  const BodyId high = scene.addBody("high", clothGrid(25, 1, 0.05F, 0.08F));
  const BodyId patch = scene.addBody("patch", clothGrid(6, 0.2F, 0, 0.01F));
  std::vector<float> earlier = scene.body(high).mesh.vertices;
  for (std::size_t i = 0; i < earlier.size(); ++i) {
    earlier[i] += i % 3 == 2 ? way : 0.01F * static_cast<float>(i % 7);
  }
  scene.setEarlier(high, RigidTransform(), earlier);
  RigidTransform before, after;
  before.translation[2] = -0.3;
  after.translation[0] = 0.5;
  after.translation[2] = 0.2;
  scene.setPose(patch, after);
  scene.setEarlier(patch, before);
  for (const BodyId a : {low, high, patch}) {
    for (const BodyId b : {low, high, patch}) scene.setPairEnabled(a, b, true);
  }
  return scene;
}

Options swept() {
  Options options;
  options.motion = Motion::kSwept;
  return options;
}

// Has no detector where there is no device; then only the error is tested.
class SweptCuda : public ::testing::Test {
 protected:
  void SetUp() override {
    try {
      detector_ = makeCudaDetector();
    } catch (const CudaError& error) {
      EXPECT_FALSE(isCudaRequired()) << error.what();
    }
    cpu_ = makeCpuDetector();
  }
  std::vector<TrianglePair> expected(const Scene& scene, const Options& options) {
    return cpu_->detect(scene, options).contacts;
  }

  std::unique_ptr<Detector> detector_, cpu_;
};

TEST_F(SweptCuda, MotionsTakeTurnsOnOneDetector) {
  if (detector_ == nullptr) return;
  const Scene scene = passingCloths(-0.2F);
  for (int turn = 0; turn < 3; ++turn) {
    for (const Options& options : {Options(), swept(), swept(), Options()}) {
      EXPECT_TRUE(samePairs(expected(scene, options), detector_->detect(scene, options).contacts));
    }
  }
}

TEST_F(SweptCuda, WithLittleMemoryTheCountStaysExactAndTheListIsPartOfIt) {
  if (detector_ == nullptr) return;
  const Scene scene = passingCloths(-0.2F);
  const std::vector<TrianglePair> all = expected(scene, swept());
  CudaSettings settings;
  settings.memory_limit_bytes = 64 << 10;
  const auto little = makeCudaDetector(settings);
  for (int turn = 0; turn < 2; ++turn) {
    const DetectionResult& found = little->detect(scene, swept());
    EXPECT_FALSE(found.cut_off);
    EXPECT_LT(found.contacts.size(), all.size());
    EXPECT_EQ(found.contacts.size() + found.left_out, all.size());
    EXPECT_TRUE(
        std::includes(all.begin(), all.end(), found.contacts.begin(), found.contacts.end()));
  }
}

TEST_F(SweptCuda, FirstTimesAreAsNarrowAsPromisedAndOverlapTheCpus) {
  if (detector_ == nullptr) return;
  Scene scene = passingCloths(-0.2F);
  scene.setPad(1, 0.001F);
  Options options = swept();
  options.first_times = true;
  const DetectionResult& found = detector_->detect(scene, options);
  const DetectionResult& on_cpu = cpu_->detect(scene, options);
  ASSERT_TRUE(samePairs(on_cpu.contacts, found.contacts));
  ASSERT_EQ(found.first_times.size(), found.contacts.size());
  EXPECT_EQ(found.within_pad, on_cpu.within_pad);
  std::size_t by_pad = 0;
  for (std::size_t i = 0; i < found.contacts.size(); ++i) {
    const FirstContact &a = found.first_times[i], &b = on_cpu.first_times[i];
    EXPECT_LE(a.low, b.high);
    EXPECT_LE(b.low, a.high);
    by_pad += found.within_pad[i];
    if (found.within_pad[i] == 0) {
      EXPECT_LE(a.high - a.low, 0x1p-20F);
    }
  }
  EXPECT_GT(by_pad, 0U);
}

// Symmetric about a plane in which vertices slide: ties that the host decides.
TEST_F(SweptCuda, TiesAreLeftToTheHost) {
  if (detector_ == nullptr) return;
  Scene scene;
  const BodyId id = scene.addBody("plane", clothGrid(12, 12, 0, 0));
  const BodyId other = scene.addBody("sliding", clothGrid(12, 12, 0, 0));
  std::vector<float> earlier = scene.body(other).mesh.vertices;
  for (std::size_t i = 0; i < earlier.size(); i += 3) earlier[i] += 14;
  scene.setEarlier(other, RigidTransform(), earlier);
  scene.setPairEnabled(id, other, true);
  for (const bool times : {false, true}) {
    Options options = swept();
    options.first_times = times;
    EXPECT_TRUE(samePairs(expected(scene, options), detector_->detect(scene, options).contacts));
  }
  EXPECT_GT(detector_->detect(scene, swept()).contacts.size(), 1000U);
}

TEST_F(SweptCuda, ACommonMotionCostsNothing) {
  if (detector_ == nullptr) return;
  Scene scene = passingCloths(-0.05F);
  const std::uint64_t candidates = detector_->detect(scene, swept()).counters.candidates;
  for (const BodyId id : {0U, 1U, 2U}) {  // the frame of reference moves
    const Body& body = scene.body(id);
    RigidTransform pose = body.earlier ? body.earlier->pose : body.pose;
    std::vector<float> vertices;
    if (body.earlier) vertices = body.earlier->vertices;
    pose.translation[1] += 30;
    scene.setEarlier(id, pose, vertices);
  }
  const DetectionResult& found = detector_->detect(scene, swept());
  EXPECT_TRUE(samePairs(expected(scene, swept()), found.contacts));
  EXPECT_LT(found.counters.candidates, candidates + candidates / 2);
}

TEST_F(SweptCuda, AStopEndsIt) {
  if (detector_ == nullptr) return;
  const Scene scene = passingCloths(-0.2F);
  std::atomic<bool> stop{true};
  Options options = swept();
  options.limits.stop = &stop;
  EXPECT_TRUE(detector_->detect(scene, options).cut_off);
  stop = false;
  EXPECT_TRUE(samePairs(expected(scene, swept()), detector_->detect(scene, options).contacts));
}

}  // namespace
}  // namespace deformable_contact_monitor
