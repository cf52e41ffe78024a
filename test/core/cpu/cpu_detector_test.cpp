// What the CPU backend says of its stages.
#include "core/cpu/cpu_detector.h"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

// A folded cloth and, if asked for, triangles so large that they go onto the list of their own.
Scene foldedCloth(int large) {
  TriangleMesh mesh = clothGrid(60, 1, 0, 0.1F);
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
    mesh.vertices[i] = std::abs(mesh.vertices[i] - 0.507F);
  }
  for (int i = 0; i < large; ++i) {
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
      EXPECT_EQ((std::vector<std::string>{"pose", "cluster", "assign", "sort", "sweep", "large",
                                          "judge", "output"}),
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
  EXPECT_EQ(0, ms.at("large"));
}

}  // namespace
}  // namespace deformable_contact_monitor
