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

// Of so many pairs the device looks for roots at once, with and without times.
TEST_F(SweptCuda, ManyPairsAndTheirTimesAreThoseOfTheCpu) {
  if (detector_ == nullptr) return;
  Scene scene;
  const BodyId low = scene.addBody("low", clothGrid(40, 1, 0, 0.1F));
  const BodyId high = scene.addBody("high", clothGrid(40, 1, 0.2F, 0.08F));
  std::vector<float> earlier = scene.body(high).mesh.vertices;
  for (std::size_t i = 0; i < earlier.size(); ++i) {
    earlier[i] += i % 3 == 2 ? -0.4F : 0.02F * static_cast<float>(i % 7);
  }
  scene.setEarlier(high, RigidTransform(), earlier);
  scene.setPairEnabled(low, high, true);
  scene.setPairEnabled(high, high, true);
  for (const bool times : {false, true}) {
    Options options = swept();
    options.first_times = times;
    const DetectionResult& found = detector_->detect(scene, options);
    const DetectionResult& on_cpu = cpu_->detect(scene, options);
    EXPECT_GT(on_cpu.contacts.size(), 25000U);
    EXPECT_TRUE(samePairs(on_cpu.contacts, found.contacts));
    ASSERT_EQ(found.first_times.size(), times ? found.contacts.size() : 0);
    for (std::size_t i = 0; i < found.first_times.size(); ++i) {
      const FirstContact &a = found.first_times[i], &b = on_cpu.first_times[i];
      ASSERT_LE(a.low, b.high) << i;
      ASSERT_LE(b.low, a.high) << i;
      ASSERT_LE(a.high - a.low, 0x1p-20F) << i;
    }
  }
}

// Two flat sheets, one of which slides in their plane, so that all its first contacts are ties.
Scene slidingSheets(float width) {
  Scene scene;
  const BodyId id = scene.addBody("plane", clothGrid(6, 6, 0, 0));
  const BodyId other = scene.addBody("sliding", clothGrid(6, 6, 0, 0));
  for (const BodyId body : {id, other}) {
    std::vector<float> vertices = scene.body(body).mesh.vertices;
    for (std::size_t i = 1; i < vertices.size(); i += 3) vertices[i] *= width;
    scene.setVertices(body, vertices.data(), vertices.size() / 3);
  }
  std::vector<float> earlier = scene.body(other).mesh.vertices;
  for (std::size_t i = 0; i < earlier.size(); i += 3) earlier[i] += 7;
  scene.setEarlier(other, RigidTransform(), earlier);
  scene.setPairEnabled(id, other, true);
  return scene;
}

// Some ties are decided on the device, and others on the host: with narrow sheets the exponents are
// too far apart for the device's integers.
TEST_F(SweptCuda, TiesAreThoseOfTheCpu) {
  if (detector_ == nullptr) return;
  for (const float width : {1.0F, 0x1p-50F}) {
    const Scene scene = slidingSheets(width);
    for (const bool times : {false, true}) {
      Options options = swept();
      options.first_times = times;
      const DetectionResult& found = detector_->detect(scene, options);
      EXPECT_TRUE(samePairs(expected(scene, options), found.contacts));
      EXPECT_GT(found.contacts.size(), 100U);
      for (const FirstContact& first : found.first_times) {
        EXPECT_LE(first.high - first.low, 0x1p-20F);
      }
    }
  }
}

TEST_F(SweptCuda, ACommonMotionCostsLittle) {
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
  // The scene reaches over both states, so positions along the diagonals are coarser, and tell
  // fewer triangles apart (core/rules/diagonal_box.h).
  EXPECT_LT(found.counters.candidates, 2 * candidates);
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
