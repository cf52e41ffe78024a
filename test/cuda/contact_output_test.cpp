// How contacts come to the host, where their number and their rows change from cycle to cycle.
#include <gtest/gtest.h>

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

struct Case {
  float margin_m;
  bool geometry;
  Motion motion;
};

class ContactOutput : public ::testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    options_.geometry = GetParam().geometry;
    options_.motion = GetParam().motion;
    options_.first_times = GetParam().motion == Motion::kSwept;
    try {
      detector_ = makeCudaDetector();
    } catch (const CudaError& error) {
      EXPECT_FALSE(isCudaRequired()) << error.what();
    }
  }

  // The CPU's contacts in its order, and what comes with each. Returns how many there are.
  std::size_t expectTheCpus(const Scene& scene) {
    const DetectionResult& expected = cpu_->detect(scene, options_);
    const DetectionResult& found = detector_->detect(scene, options_);
    EXPECT_TRUE(samePairs(expected.contacts, found.contacts));
    EXPECT_TRUE(sameBits(expected.separations_m, found.separations_m));
    EXPECT_EQ(0U, found.left_out);
    EXPECT_FALSE(found.cut_off);
    EXPECT_EQ(options_.geometry ? found.contacts.size() : 0, found.geometry.size());
    for (std::size_t i = 0; i < found.geometry.size(); ++i) {
      const Vec3f a = expected.geometry.at(i).point_a, b = found.geometry[i].point_a;
      EXPECT_TRUE(a.x == b.x && a.y == b.y && a.z == b.z) << i;
    }
    EXPECT_EQ(expected.first_times.size(), found.first_times.size());
    for (std::size_t i = 0; i < found.first_times.size(); ++i) {
      EXPECT_LE(found.first_times[i].low, expected.first_times.at(i).high) << i;
      EXPECT_GE(found.first_times[i].high, expected.first_times.at(i).low) << i;
    }
    return found.contacts.size();
  }

  Options options_;
  std::unique_ptr<Detector> cpu_ = makeCpuDetector();
  std::unique_ptr<Detector> detector_;  // null: there is no device
};

void lift(Scene& scene, BodyId body, float height_m) {
  RigidTransform pose;
  pose.translation[2] = height_m;
  scene.setPose(body, pose);
}

// Bodies that do not take part, one without triangles, and waves through each other.
TEST_P(ContactOutput, FollowsANumberThatJumps) {
  if (!detector_) return;
  Scene scene;
  scene.addBody("beside", clothGrid(3, 1, 0, 0));
  scene.addBody("lower", clothGrid(90, 1, 0, 0.05F));
  scene.addBody("empty", {});
  scene.addBody("upper", clothGrid(80, 1, 0, -0.05F));
  scene.setPairEnabled(1, 3, true);
  scene.setPairEnabled(1, 2, true);
  scene.setMargin(1, GetParam().margin_m);
  std::vector<std::size_t> numbers;
  for (const float height_m : {0.09F, 0.0F, 0.5F, 0.0F, 0.5F, 0.5F, 0.095F, 0.0F, 0.09F}) {
    lift(scene, 3, height_m);
    numbers.push_back(expectTheCpus(scene));
  }
  EXPECT_EQ(0U, numbers[2]);
  EXPECT_GT(numbers[0], 0U);
  EXPECT_GT(numbers[1], 2000U);
  EXPECT_EQ(numbers[1], numbers[7]);
}

// Needles through one large triangle, which is the lower or the higher one of all their contacts.
TEST_P(ContactOutput, HasRowsOfAnyLength) {
  if (!detector_) return;
  const TriangleMesh large = meshOf({{{{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}}}});
  for (const bool large_first : {true, false}) {
    for (const int needles : {2000, 2048, 2049, 7000, 5}) {
      std::vector<Triangle> through;
      for (int i = 0; i < needles; ++i) {
        const float x = 0.0005F * static_cast<float>((i * 619) % needles), y = 0.0003F;
        through.push_back({{{x, 0, -1}, {x + y, 0, 1}, {x, y, 1}}});
      }
      Scene scene =
          large_first ? pairScene(large, meshOf(through)) : pairScene(meshOf(through), large);
      scene.setMargin(0, GetParam().margin_m);
      const BodyId moving = large_first ? 0 : 1;
      EXPECT_EQ(static_cast<std::size_t>(needles), expectTheCpus(scene));
      lift(scene, moving, 3);
      EXPECT_EQ(0U, expectTheCpus(scene));
      lift(scene, moving, 0.25F);
      EXPECT_EQ(static_cast<std::size_t>(needles), expectTheCpus(scene));
    }
  }
}

// A copied result belongs to the caller.
TEST_P(ContactOutput, CopiesOutliveTheDetector) {
  if (!detector_) return;
  const Scene scene = selfScene(clothGrid(40, 1, 0, 0.3F));
  const DetectionResult copy = detector_->detect(scene, options_);
  TrianglePairs moved = DetectionResult(detector_->detect(scene, options_)).contacts;
  detector_.reset();
  EXPECT_TRUE(samePairs(cpu_->detect(scene, options_).contacts, copy.contacts));
  EXPECT_TRUE(copy.contacts == moved);
}

// The device reads vertices where the scene has them, and nobody notices.
TEST_P(ContactOutput, VerticesMayLieInTheDetectorsMemory) {
  if (!detector_) return;
  Scene scene = selfScene(clothGrid(50, 1, 0, 0.3F));
  scene.useMemory(detector_->vertexMemory());
  scene.addBody("other", clothGrid(30, 1, 0, -0.1F));
  scene.setPairEnabled(0, 1, true);
  std::vector<float> vertices = scene.body(0).mesh.vertices;
  for (int cycle = 0; cycle < 8; ++cycle) {
    for (std::size_t i = 2; i < vertices.size(); i += 3) vertices[i] *= cycle % 2 == 0 ? -1 : 0.5F;
    scene.setVertices(0, vertices.data(), vertices.size() / 3);
    const Scene plain = scene;
    EXPECT_GT(expectTheCpus(scene), 0U);
    EXPECT_EQ(expectTheCpus(scene), expectTheCpus(plain));
  }
}

INSTANTIATE_TEST_SUITE_P(, ContactOutput,
                         ::testing::Values(Case{0, false, Motion::kInstant},
                                           Case{0, true, Motion::kInstant},
                                           Case{0.002F, false, Motion::kInstant},
                                           Case{0.002F, true, Motion::kInstant},
                                           Case{0, false, Motion::kSwept}));

}  // namespace
}  // namespace deformable_contact_monitor
