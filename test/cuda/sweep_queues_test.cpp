// The queues between the steps of a warp in the sweep (cuda/stages/sweep_triangles.cu). How full
// they get depends on how many pairs each step keeps, and most of all at the end of a warp's work.
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "core/cpu_detector.h"
#include "cuda/cuda_detector.h"
#include "cuda/device/cuda_error.h"
#include "pair_sets.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

std::vector<float> randomVertices(std::size_t count, std::mt19937& random) {
  std::uniform_real_distribution<float> any(0, 1);
  std::vector<float> vertices(3 * count);
  for (float& x : vertices) x = any(random);
  return vertices;
}

// Bodies that lie across themselves, moving: random triangles of few vertices. The fewer there are,
// the more pairs share one. Nearly all pairs of boxes meet, and most pairs pass each filter.
Scene tangledBodies(std::uint32_t bodies, std::uint32_t triangles, std::uint32_t vertices,
                    std::mt19937& random) {
  Scene scene;
  for (std::uint32_t body = 0; body < bodies; ++body) {
    TriangleMesh mesh;
    mesh.vertices = randomVertices(vertices, random);
    while (mesh.triangles.size() < 3 * std::size_t{triangles}) {
      const std::uint32_t a = random() % vertices, b = random() % vertices, c = random() % vertices;
      if (a != b && b != c && c != a) mesh.triangles.insert(mesh.triangles.end(), {a, b, c});
    }
    const BodyId id = scene.addBody("body", std::move(mesh));
    scene.setEarlier(id, RigidTransform(), randomVertices(vertices, random));
    scene.setPairEnabled(id, id, true);
  }
  return scene;
}

// Once, the queue of candidates had too few places when both filters added to it at the very end.
// It wrote into the memory of the next warp, or beyond the memory of the block.
TEST(SweepQueues, HoldWhatTheFiltersKeep) {
  std::unique_ptr<Detector> on_gpu;
  try {
    on_gpu = makeCudaDetector();
  } catch (const CudaError& error) {
    ASSERT_FALSE(isCudaRequired()) << error.what();
    return;
  }
  const std::unique_ptr<Detector> on_cpu = makeCpuDetector();
  std::mt19937 random(1);
  for (const std::uint32_t vertices : {12, 16, 24, 40}) {
    const Scene scene = tangledBodies(40, 150, vertices, random);
    for (const Motion motion : {Motion::kSwept, Motion::kInstant}) {
      for (const AdjacentPairs adjacent : {AdjacentPairs::kBeyondShared, AdjacentPairs::kSkip}) {
        Options options;
        options.motion = motion;
        options.adjacent = adjacent;
        const std::vector<TrianglePair> expected = on_cpu->detect(scene, options).contacts;
        EXPECT_GT(expected.size(), 1000U);
        for (int run = 0; run < 3; ++run) {  // which warp takes what differs
          ASSERT_TRUE(samePairs(expected, on_gpu->detect(scene, options).contacts))
              << vertices << " vertices, " << toString(motion) << ", " << toString(adjacent);
        }
      }
    }
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
