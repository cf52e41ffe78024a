// The nearest pair of two bodies, as every detector finds it.
#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "core/cpu_detector.h"
#include "core/detector.h"
#include "core/scene.h"
#include "random_scenes.h"
#include "reference/reference_detectors.h"

namespace deformable_contact_monitor {
namespace {

Options withNearest() {
  Options options;
  options.nearest = true;
  return options;
}

TEST(Nearest, IsThatOfBruteForceInRandomScenes) {
  const std::unique_ptr<Detector> exact = makeBruteForceDetector(), cpu = makeCpuDetector();
  std::size_t apart = 0, touching = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    Scene scene = randomScene(seed);
    std::mt19937 random(seed);
    for (BodyId id = 0; id < scene.bodyCount(); ++id) {
      scene.setMargin(id, static_cast<float>(random() % 4) * 0.5F);
    }
    const std::vector<NearestPair> expected = exact->detect(scene, withNearest()).nearest;
    ASSERT_EQ(expected, cpu->detect(scene, withNearest()).nearest) << "seed " << seed;
    for (const NearestPair& pair : expected) ++(pair.distance_m > 0 ? apart : touching);
  }
  EXPECT_GT(apart, 20U);
  EXPECT_GT(touching, 20U);
}

}  // namespace
}  // namespace deformable_contact_monitor
