// Tests what is special to the CUDA backend; the detector suite shows that its results are correct.
#include "cuda/cuda_detector.h"

#include <gtest/gtest.h>

#include <random>
#include <thread>

#include "core/cpu_detector.h"
#include "cuda/device/cuda_error.h"
#include "pair_sets.h"
#include "random_scenes.h"
#include "scenes.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

// Null where there is no device; then what must happen is that making one says why.
std::unique_ptr<Detector> makeOrSayWhy(const CudaSettings& settings = CudaSettings()) {
  try {
    return makeCudaDetector(settings);
  } catch (const CudaError& error) {
    EXPECT_FALSE(isCudaRequired()) << error.what();
    EXPECT_GT(std::string(error.what()).size(), 20U) << error.what();
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    return nullptr;
  }
}

TEST(CudaDetector, ADeviceThatIsNotThereIsRefused) {
  CudaSettings settings;
  settings.device = 1000;
  EXPECT_THROW(makeCudaDetector(settings), CudaError);
}

// Layers of cloth through each other: many contacts.
Scene denseScene() {
  Scene scene;
  for (int i = 0; i < 6; ++i) {
    scene.addBody("layer",
                  clothGrid(40, 1, 0.004F * static_cast<float>(i), i % 2 == 0 ? 0.05F : -0.05F));
    for (int k = 0; k < i; ++k) {
      scene.setPairEnabled(static_cast<BodyId>(k), static_cast<BodyId>(i), true);
    }
  }
  return scene;
}

TEST(CudaDetector, WithLittleMemoryTheCountStaysExactAndTheListIsPartOfIt) {
  CudaSettings settings;
  settings.memory_limit_bytes = 1 << 16;
  const auto detector = makeOrSayWhy(settings);
  if (detector == nullptr) return;
  const Scene scene = denseScene();
  const auto all = makeCpuDetector()->detect(scene, Options()).contacts;
  ASSERT_GT(all.size(), 3000U);
  for (int i = 0; i < 3; ++i) {
    const DetectionResult& result = detector->detect(scene, Options());
    EXPECT_EQ(result.contacts.size() + result.left_out, all.size());
    EXPECT_GT(result.left_out, 0U);
    EXPECT_TRUE(isOrdered(result.contacts));
    EXPECT_TRUE(
        std::includes(all.begin(), all.end(), result.contacts.begin(), result.contacts.end()));
  }
}

// Random triangles in a box, every vertex within a unit of the first.
Scene denseScene(int count, float margin_m) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(0, 1);
  TriangleMesh mesh;
  for (int i = 0; i < count; ++i) {
    const float corner[3] = {2 * unit(random), 2 * unit(random), 2 * unit(random)};
    for (std::uint32_t v = 0; v < 3; ++v) {
      mesh.triangles.push_back(static_cast<std::uint32_t>(mesh.vertexCount()));
      for (const float start : corner) mesh.vertices.push_back(start + unit(random));
    }
  }
  Scene scene = selfScene(mesh);
  scene.setMargin(0, margin_m);
  return scene;
}

// Checks that the list is part of all contacts, each with its separation, and that it says how many
// it leaves out.
void expectPartOf(const DetectionResult& all, const DetectionResult& result) {
  EXPECT_EQ(all.contacts.size(), result.contacts.size() + result.left_out);
  EXPECT_TRUE(isOrdered(result.contacts));
  ASSERT_EQ(all.separations_m.empty() ? 0 : result.contacts.size(), result.separations_m.size());
  std::size_t k = 0;
  for (std::size_t i = 0; i < result.contacts.size(); ++i, ++k) {
    while (k < all.contacts.size() && all.contacts[k] < result.contacts[i]) ++k;
    ASSERT_TRUE(k < all.contacts.size() && all.contacts[k] == result.contacts[i]) << i;
    if (!all.separations_m.empty()) {
      ASSERT_EQ(all.separations_m[k], result.separations_m[i]) << i;
    }
  }
}

std::unique_ptr<Detector> makeLimited(std::uint64_t bytes) {
  CudaSettings settings;
  settings.memory_limit_bytes = bytes;
  return makeOrSayWhy(settings);
}

// Checks some cycles of a detector that has room for part of the contacts. Returns how many it
// lists.
std::size_t listedBy(Detector& detector, const Scene& scene) {
  const auto cpu = makeCpuDetector();
  const DetectionResult& all = cpu->detect(scene, Options());
  std::size_t listed = 0;
  for (int i = 0; i < 3; ++i) {
    const DetectionResult& result = detector.detect(scene, Options());
    expectPartOf(all, result);
    EXPECT_GT(result.left_out, 0U);
    listed = result.contacts.size();
  }
  return listed;
}

// The first cycle finds too few contacts to tell how long the list will be, so passes start again.
TEST(CudaDetector, PassesThatOutgrowTheListOfContactsStartAgain) {
  for (const float margin_m : {0.0F, 0.05F}) {
    const auto detector = makeLimited(40000);
    if (detector == nullptr) return;
    Scene scene = denseScene(500, margin_m);
    EXPECT_EQ(714U, listedBy(*detector, scene));
    // Huge triangles are on a list of their own, whose blocks take turns too.
    scene.addBody("huge", {{-99, -99, 1.5F, 199, -99, 1.4F, 50, 199, 1.6F, -99, 99, 1, 199, 99,
                            1.1F, 50, -199, 0.9F},
                           {0, 1, 2, 3, 4, 5}});
    scene.setPairEnabled(0, 1, true);
    scene.setMargin(1, margin_m);
    EXPECT_EQ(714U, listedBy(*detector, scene));
  }
}

// Many contacts are ordered by rows, few as a whole.
TEST(CudaDetector, PassesGiveManyContactsTheirSeparations) {
  const auto detector = makeLimited(160000);
  if (detector == nullptr) return;
  EXPECT_EQ(2857U, listedBy(*detector, denseScene(1000, 0.05F)));
}

// Not even one work unit's candidates fit: what was examined is true, and the rest is said. With a
// margin the sweep itself decides nothing.
TEST(CudaDetector, WithNextToNoMemoryTheResultIsCutOffAndSaysSo) {
  for (const float margin_m : {0.001F, 0.05F}) {
    Scene scene = denseScene(500, margin_m);
    scene.addBody("huge", {{-99, -99, 1.5F, 199, -99, 1.4F, 50, 199, 1.6F}, {0, 1, 2}});
    scene.setPairEnabled(0, 1, true);
    const auto all = makeCpuDetector()->detect(scene, Options()).contacts;
    for (const std::uint64_t limit : {1, 64, 1024}) {
      CudaSettings settings;
      settings.memory_limit_bytes = limit;
      const auto detector = makeOrSayWhy(settings);
      if (detector == nullptr) return;
      for (int i = 0; i < 3; ++i) {
        const DetectionResult& result = detector->detect(scene, Options());
        EXPECT_TRUE(result.cut_off) << limit;
        EXPECT_EQ(result.cut_off_because, "memory_limit_mib");
        EXPECT_GT(result.contacts.size(), 0U);
        EXPECT_LT(result.contacts.size() + result.left_out, all.size());
        EXPECT_EQ(result.separations_m.size(), result.contacts.size());
        EXPECT_TRUE(isOrdered(result.contacts));
        EXPECT_TRUE(
            std::includes(all.begin(), all.end(), result.contacts.begin(), result.contacts.end()));
      }
    }
  }
}

TEST(CudaDetector, IsWholeAgainOnceTheMemoryDoes) {
  CudaSettings settings;
  settings.memory_limit_bytes = 64;
  const auto detector = makeOrSayWhy(settings);
  if (detector == nullptr) return;
  EXPECT_TRUE(detector->detect(denseScene(500, 0.05F), Options()).cut_off);
  const Scene crossing =
      pairScene(meshOf({{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}}),
                meshOf({{{{0.2F, 0.2F, -1}, {0.2F, 0.3F, 1}, {0.3F, 0.2F, 1}}}}));
  const DetectionResult& result = detector->detect(crossing, Options());
  EXPECT_FALSE(result.cut_off);
  EXPECT_TRUE(result.cut_off_because.empty());
  EXPECT_EQ(result.contacts.size(), 1U);
}

TEST(CudaDetector, RepeatsGiveTheSameSetAHundredTimes) {
  const auto detector = makeOrSayWhy();
  if (detector == nullptr) return;
  Scene scene = denseScene();
  const std::vector<float> vertices = scene.body(0).mesh.vertices;
  const auto expected = makeCpuDetector()->detect(scene, Options()).contacts;
  ASSERT_GT(expected.size(), 3000U);
  for (int i = 0; i < 100; ++i) {
    scene.setVertices(0, vertices.data(), vertices.size() / 3);
    ASSERT_TRUE(samePairs(expected, detector->detect(scene, Options()).contacts)) << i;
  }
}

TEST(CudaDetector, SeveralInOneProcessOnThreadsOfTheirOwn) {
  if (makeOrSayWhy() == nullptr) return;
  std::vector<std::thread> threads;
  std::vector<int> wrong(4, 0);
  for (unsigned k = 0; k < wrong.size(); ++k) {
    threads.emplace_back([k, &wrong] {
      const auto detector = makeCudaDetector();
      for (std::uint32_t seed = 0; seed < 30; ++seed) {
        const Scene scene = largeRandomScene((seed + 7 * k) % 16);
        const auto expected = makeCpuDetector()->detect(scene, Options()).contacts;
        if (detector->detect(scene, Options()).contacts != expected) ++wrong[k];
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, std::vector<int>(wrong.size(), 0));
}

// The state of a warm start does not fit after a jump: it must cost time, never contacts.
TEST(CudaDetector, ScenesThatJumpGrowAndShrink) {
  const auto detector = makeOrSayWhy();
  if (detector == nullptr) return;
  Scene scene = selfScene(clothGrid(60, 1, 0, 0.3F));
  scene.addBody("other", clothGrid(30, 1, 0.1F, 0));
  scene.setPairEnabled(0, 1, true);
  const std::vector<float> vertices = scene.body(0).mesh.vertices;
  Options options;
  options.clusters = 12;
  for (const float scale : {1.0F, 100.0F, 1e-3F, 1.0F, 1e20F, 1e-20F, 1.0F}) {
    for (const float shift : {0.0F, 50.0F}) {
      std::vector<float> moved = vertices;
      for (float& x : moved) x = x * scale + shift;
      scene.setVertices(0, moved.data(), moved.size() / 3);
      const auto expected = makeCpuDetector()->detect(scene, options).contacts;
      for (int i = 0; i < 2; ++i) {
        ASSERT_TRUE(samePairs(expected, detector->detect(scene, options).contacts))
            << "scale " << scale << ", shift " << shift;
      }
    }
  }
}

// Boxes are rounded in a frame, which must follow what moves without a cold start: else nearly
// every box would meet every other one.
TEST(CudaDetector, TheFrameOfRoundedBoxesFollowsAScene) {
  const auto detector = makeOrSayWhy();
  if (detector == nullptr) return;
  Scene scene = selfScene(clothGrid(60, 1, 0, 0.3F));
  const std::vector<float> vertices = scene.body(0).mesh.vertices;
  const auto work = [&](float shift, float scale) {
    std::vector<float> moved = vertices;
    for (float& x : moved) x = x * scale + shift;
    scene.setVertices(0, moved.data(), moved.size() / 3);
    return detector->detect(scene, Options()).counters.interval_overlaps;
  };
  work(0, 1);
  const auto at_first = static_cast<double>(work(0, 1));
  work(15, 1);
  EXPECT_NEAR(static_cast<double>(work(15, 1)), at_first, 0.2 * at_first) << "moved";
  for (int i = 0; i < 60; ++i) work(15, 0.01F);
  EXPECT_NEAR(static_cast<double>(work(15, 0.01F)), at_first, 0.2 * at_first) << "shrunk";
}

// Lists of neighbours do not lead from piece to piece, nor from where it was to where it is.
TEST(CudaDetector, TrianglesAreInFewClustersEvenAtFirst) {
  const auto detector = makeOrSayWhy();
  if (detector == nullptr) return;
  Options options;
  options.clusters = 300;
  Scene scene = selfScene(sizedTo(clothGrid(20, 1, 0, 0.1F), 60000));
  std::vector<float> moved = scene.body(0).mesh.vertices;
  for (std::size_t i = 0; i < moved.size(); i += 3) moved[i] += 30;
  for (int i = 0; i < 2; ++i) {
    const Counters& counters = detector->detect(scene, options).counters;
    EXPECT_EQ(counters.clusters, 300U);
    EXPECT_LT(counters.cluster_entries, 3 * counters.clustered) << "cycle " << i;
    scene.setVertices(0, moved.data(), moved.size() / 3);
  }
}

TEST(CudaDetector, TimesItsStagesOnRequest) {
  CudaSettings settings;
  settings.time_stages = true;
  const auto detector = makeOrSayWhy(settings);
  if (detector == nullptr) return;
  const Scene scene = denseScene();
  const auto expected = makeCpuDetector()->detect(scene, Options()).contacts;
  const DetectionResult& result = detector->detect(scene, Options());
  EXPECT_TRUE(samePairs(expected, result.contacts));
  EXPECT_EQ(result.stages_ms.size(), 8U);
  for (const auto& [name, ms] : result.stages_ms) EXPECT_GT(ms, 0) << name;
}

}  // namespace
}  // namespace deformable_contact_monitor
