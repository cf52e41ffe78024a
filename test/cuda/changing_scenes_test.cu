// Tests what the CUDA backend keeps of a scene that changes, and what it builds anew.
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/cpu_detector.h"
#include "cuda/cuda_detector.h"
#include "device_test.h"
#include "pair_sets.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

class ChangingScenes : public DeviceTest {};

// A cloth of 7 200 triangles, with itself and with a body of 128; and a detector that knows it.
struct KnownCloth {
  Scene scene = selfScene(clothGrid(60, 1, 0, 0.3F));
  Options options;
  std::unique_ptr<Detector> detector = makeCudaDetector();

  KnownCloth() {
    scene.addBody("small", clothGrid(8, 0.3F, 0.1F, 0));
    scene.setPairEnabled(0, 1, true);
    options.clusters = 12;
    EXPECT_TRUE(detect().started_cold);
  }
  const DetectionResult& detect() { return detector->detect(scene, options); }
};

// Bodies that come and go beside a cloth leave its clusters as they are.
TEST_F(ChangingScenes, ASmallChangeIsNoColdStart) {
  if (!hasDevice()) return;
  KnownCloth known;
  Scene& scene = known.scene;
  for (const int cells : {7, 8, 9, 0, 9}) {
    scene.setMesh(1, cells > 0 ? clothGrid(cells, 0.3F, 0.1F, 0) : TriangleMesh());
    const DetectionResult& result = known.detect();
    EXPECT_FALSE(result.started_cold) << cells;
    EXPECT_TRUE(
        samePairs(makeCpuDetector()->detect(scene, known.options).contacts, result.contacts));
  }
  scene.setMesh(1, clothGrid(50, 0.3F, 0.1F, 0));
  EXPECT_TRUE(known.detect().started_cold) << "much is new";
  scene.setMesh(0, clothGrid(60, 100, 0, 0.3F));
  EXPECT_TRUE(known.detect().started_cold) << "it is of another size";
}

// A small change is no reason to inspect the scene again. Many of them add up, because the clusters
// would otherwise fit the scene less and less.
TEST_F(ChangingScenes, SmallChangesAddUpToAnInspection) {
  if (!hasDevice()) return;
  KnownCloth known;
  Scene& scene = known.scene;
  std::vector<float> shrunk = scene.body(0).mesh.vertices;
  for (float& x : shrunk) x *= 0.2F;
  scene.setVertices(0, shrunk.data(), shrunk.size() / 3);
  EXPECT_FALSE(known.detect().started_cold) << "motion alone";
  std::vector<bool> cold;
  for (const int cells : {9, 8, 9, 8, 9}) {
    scene.setMesh(1, clothGrid(cells, 0.3F, 0.1F, 0));
    const DetectionResult& result = known.detect();
    cold.push_back(result.started_cold);
    EXPECT_TRUE(
        samePairs(makeCpuDetector()->detect(scene, known.options).contacts, result.contacts));
  }
  // 128 to 162 triangles a change; a sixteenth of all is 459.
  EXPECT_EQ(cold, std::vector<bool>({false, false, true, false, false}));
}

// One cluster is looked at in one way while its tiles are few, in another where they are not.
TEST_F(ChangingScenes, OneClusterMayGrowAndShrink) {
  if (!hasDevice()) return;
  const auto detector = makeCudaDetector();
  Options options;
  options.clusters = 1;
  Scene scene = selfScene(sizedTo(clothGrid(60, 1, 0, 0.3F), 100000));
  scene.addBody("other", clothGrid(2, 1, 0.1F, 0));
  scene.setPairEnabled(0, 1, true);
  for (const int cells : {2, 150, 2}) {
    scene.setMesh(1, clothGrid(cells, 1, 0.1F, 0));
    const auto expected = makeCpuDetector()->detect(scene, Options()).contacts;
    for (int i = 0; i < 3; ++i) {
      ASSERT_TRUE(samePairs(expected, detector->detect(scene, options).contacts)) << cells;
    }
  }
}

// Two cloths, of which one comes down through the other: ever more triangles are within reach, and
// are worth ever more clusters. Those come from samples; the scene is not looked at again.
TEST_F(ChangingScenes, NewClustersAreNoColdStart) {
  if (!hasDevice()) return;
  const auto detector = makeCudaDetector();
  constexpr int kCells = 250;
  Scene scene = pairScene(clothGrid(kCells, 1, 0, 0.02F), clothGrid(kCells, 1, 0, -0.02F));
  std::set<std::uint64_t> clusters;
  for (const double shift : {0.9, 0.5, 0.3, 0.1, 0.0, 0.5, 0.95}) {
    RigidTransform pose;
    pose.translation[0] = shift;
    scene.setPose(1, pose);
    const auto expected = makeCpuDetector()->detect(scene, Options()).contacts;
    for (int i = 0; i < 3; ++i) {
      const DetectionResult& result = detector->detect(scene, Options());
      EXPECT_EQ(result.started_cold, shift == 0.9 && i == 0) << shift;
      ASSERT_TRUE(samePairs(expected, result.contacts)) << shift;
      ASSERT_FALSE(expected.empty()) << shift;
      const Counters& counters = result.counters;
      clusters.insert(counters.clusters);
      if (i == 0 || counters.clusters == 1) continue;  // those of the scene before
      EXPECT_LT(5 * counters.largest_cluster, counters.clustered) << shift << ", cycle " << i;
    }
  }
  EXPECT_GE(clusters.size(), 3U) << "their number was to change";
}

// More of them than one kernel copies at a time.
TEST_F(ChangingScenes, ManyBodiesMayDeformAtOnce) {
  if (!hasDevice()) return;
  const auto detector = makeCudaDetector();
  constexpr int kBodies = 50;
  Scene scene;
  for (int b = 0; b < kBodies; ++b) {
    scene.addBody("cloth " + std::to_string(b), TriangleMesh());
    if (b > 0) scene.setPairEnabled(static_cast<BodyId>(b - 1), static_cast<BodyId>(b), true);
  }
  std::size_t found = 0;
  for (const float apart : {0.02F, 0.03F, 0.025F}) {
    for (int b = 0; b < kBodies; ++b) {
      const TriangleMesh mesh = clothGrid(5 + b % 4, 1, apart * static_cast<float>(b), 0.05F);
      if (apart == 0.02F) scene.setMesh(static_cast<BodyId>(b), mesh);
      scene.setVertices(static_cast<BodyId>(b), mesh.vertices.data(), mesh.vertexCount());
    }
    const DetectionResult& result = detector->detect(scene, Options());
    ASSERT_TRUE(samePairs(makeCpuDetector()->detect(scene, Options()).contacts, result.contacts));
    found += result.contacts.size();
  }
  EXPECT_GT(found, 1000U);
}

}  // namespace
}  // namespace deformable_contact_monitor
