// Tests the times that the CPU backend reports for its stages.
#include "core/cpu_detector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "pair_sets.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

// A folded cloth and, if asked for, triangles so large that they go onto the list of their own.
Scene foldedCloth(int oversized) {
  TriangleMesh mesh = clothGrid(60, 1, 0, 0.1F);
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
    mesh.vertices[i] = std::abs(mesh.vertices[i] - 0.507F);
  }
  for (int i = 0; i < oversized; ++i) {
    const auto first = static_cast<std::uint32_t>(mesh.vertexCount());
    const float height = 0.001F * static_cast<float>(i);
    mesh.vertices.insert(mesh.vertices.end(), {-9, -9, height, 9, -9, height, 0, 9, height});
    mesh.triangles.insert(mesh.triangles.end(), {first, first + 1, first + 2});
  }
  return selfScene(mesh);
}

TEST(CpuDetector, TimesTheEightStagesInTheirOrder) {
  const auto detector = makeCpuDetector();
  for (const int threads : {1, 2}) {
    Options options;
    options.threads = threads;
    for (int cycle = 0; cycle < 2; ++cycle) {
      const DetectionResult& result = detector->detect(foldedCloth(20), options);
      ASSERT_EQ(20U, result.counters.large);
      std::vector<std::string> names;
      double sum_ms = 0;
      for (const auto& [name, ms] : result.stages_ms) {
        names.push_back(name);
        EXPECT_GT(ms, 0) << name;
        sum_ms += ms;
      }
      EXPECT_EQ((std::vector<std::string>{"transform", "cluster", "assign", "sort", "sweep",
                                          "oversized", "narrow_phase", "output"}),
                names);
      EXPECT_LE(result.detect_ms, sum_ms * 1.001);
      EXPECT_LE(sum_ms, result.round_trip_ms * 1.001);
    }
  }
}

TEST(CpuDetector, TakesNoTimeForLargeTrianglesWhereThereAreNone) {
  const auto detector = makeCpuDetector();
  const DetectionResult& result = detector->detect(foldedCloth(0), Options());
  ASSERT_EQ(0U, result.counters.large);
  const std::map<std::string, double> ms(result.stages_ms.begin(), result.stages_ms.end());
  EXPECT_EQ(0, ms.at("oversized"));
}

TEST(CpuDetector, WithLittleMemoryTheCountStaysExactAndTheListIsPartOfIt) {
  Scene scene = pairScene(clothGrid(120, 1, 0, 0.1F), clothGrid(121, 1, 0.001F, -0.1F));
  scene.setPairEnabled(0, 0, true);
  for (const float margin_m : {0.0F, 0.001F}) {
    scene.setMargin(0, margin_m);
    const auto all = makeCpuDetector()->detect(scene, Options()).contacts;
    ASSERT_GT(all.size(), 2500U);
    for (const std::uint64_t bytes : {1U, 60000U, 100000U}) {
      for (const int threads : {1, 2}) {
        Options options;
        options.threads = threads;
        const auto detector = makeCpuDetector({bytes});
        for (int cycle = 0; cycle < 2; ++cycle) {
          const DetectionResult& result = detector->detect(scene, options);
          EXPECT_EQ(all.size(), result.contacts.size() + result.left_out);
          EXPECT_GT(result.left_out, 0U);
          EXPECT_FALSE(result.cut_off) << "all were found";
          EXPECT_TRUE(isOrdered(result.contacts));
          EXPECT_TRUE(std::includes(all.begin(), all.end(), result.contacts.begin(),
                                    result.contacts.end()));
        }
      }
    }
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
