// PartResults of several devices: by themselves and together, as sets; on stand-ins, and on the
// devices that there are, several partitions on one where they are too few.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "core/mesh_file.h"
#include "cuda/device/cuda_error.h"
#include "cuda/partitions/partition_bounds.h"
#include "cuda/partitions/partitioned_detector.h"
#include "nearest_pairs.h"
#include "pair_sets.h"
#include "partition_stand_in.h"
#include "random_scenes.h"
#include "reference/reference_detectors.h"
#include "scene_walk.h"
#include "scenes.h"
#include "swept/swept_scenes.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kMostPartitions = 5;

const std::uint32_t kScenes = [] {
  const char* wanted = std::getenv("DCM_PARTITIONED_SCENES");
  return wanted != nullptr ? static_cast<std::uint32_t>(std::atoi(wanted)) : 60U;
}();

struct Maker {
  const char* name;
  std::unique_ptr<PartitionDetector> (*make)(const CudaSettings&);
};

std::ostream& operator<<(std::ostream& out, const Maker& maker) { return out << maker.name; }

std::unique_ptr<PartitionDetector> makeStandIn(const CudaSettings& /*settings*/) {
  return std::make_unique<PartitionStandIn>();
}

// How many there are; without any, stand-ins have one number as well as another.
int deviceCount() {
  CudaSettings settings;
  try {
    for (;; ++settings.device) makeCudaPartitionDetector(settings);
  } catch (const CudaError&) {
    return std::max(1, settings.device);
  }
}

std::vector<Maker> makers() {
  std::vector<Maker> all = {{"stand_in", makeStandIn}};
  try {
    makeCudaPartitionDetector(CudaSettings());
    all.push_back({"cuda", makeCudaPartitionDetector});
  } catch (const CudaError&) {
    if (isCudaRequired()) throw;
  }
  return all;
}

// Bit by bit, but for what fills up an item.
::testing::AssertionResult sameLists(const DetectionResult& a, const DetectionResult& b) {
  const ::testing::AssertionResult same = samePairs(a.contacts, b.contacts);
  if (!same) return same;
  const ::testing::AssertionResult as_far = sameBits(a.separations_m, b.separations_m);
  if (!as_far) return as_far;
  const testing::AssertionResult as_near = sameNearest(a.nearest, b.nearest);
  if (!as_near) return as_near;
  if (a.within_pad != b.within_pad) return ::testing::AssertionFailure() << "within_pad";
  if (a.geometry.size() != b.geometry.size() || a.first_times.size() != b.first_times.size()) {
    return ::testing::AssertionFailure() << "geometry or times are missing";
  }
  for (std::size_t i = 0; i < a.geometry.size(); ++i) {
    const PairGeometry &g = a.geometry[i], &h = b.geometry[i];
    const bool equal = g.point_a == h.point_a && g.point_b == h.point_b && g.normal == h.normal &&
                       g.separation_m == h.separation_m && g.flags == h.flags;
    if (!equal) return ::testing::AssertionFailure() << "geometry of " << a.contacts[i];
  }
  for (std::size_t i = 0; i < a.first_times.size(); ++i) {
    const FirstContact &s = a.first_times[i], &t = b.first_times[i];
    if (s.low != t.low || s.high != t.high) {
      return ::testing::AssertionFailure() << "time of " << a.contacts[i];
    }
  }
  return ::testing::AssertionSuccess();
}

// Returns how many enabled pairs are of two different bodies.
std::size_t pairsOfTwo(const Scene& scene) {
  const std::vector<std::pair<BodyId, BodyId>> pairs = scene.enabledPairs();
  return static_cast<std::size_t>(std::count_if(
      pairs.begin(), pairs.end(), [](const auto& pair) { return pair.first != pair.second; }));
}

class PartResults : public ::testing::TestWithParam<Maker> {
 protected:
  static std::unique_ptr<Detector> shared(std::size_t count) {
    static const int kDevices = deviceCount();
    CudaSettings settings;
    for (std::size_t s = 0; s < count; ++s) {
      settings.devices.push_back(static_cast<int>(s) % kDevices);
    }
    settings.shared_from_triangles = 0;
    return makePartitionedDetector(settings, GetParam().make);
  }

  std::unique_ptr<PartitionDetector> one_ = GetParam().make(CudaSettings());
};

// Cut by the bounds, which stand at vertices, so that ties are common, across each of the axes.
TEST_P(PartResults, HaveEachContactOnce) {
  const auto reference = makeBruteForceDetector();
  std::size_t found = 0, dealt_out = 0;
  for (std::uint32_t seed = 0; seed < kScenes; ++seed) {
    Scene scene = randomScene(seed);
    for (BodyId b = 0; seed % 3 == 0 && b < scene.bodyCount(); ++b) {
      scene.setMargin(b, 0.3F * static_cast<float>(b));
    }
    Options options;
    options.adjacent = seed % 2 == 0 ? AdjacentPairs::kSkip : AdjacentPairs::kBeyondShared;
    options.clusters = static_cast<int>(seed % 8);
    const std::vector<TrianglePair> expected = reference->detect(scene, options).contacts;
    for (std::size_t count = 1; count <= kMostPartitions; ++count) {
      std::vector<ScenePartition> cut = PartitionBounds().cut(scene, count);
      std::vector<TrianglePair> all;
      for (ScenePartition& partition : cut) {
        partition.axis = static_cast<int>((static_cast<std::uint32_t>(partition.axis) + seed) % 3);
        one_->setPartition(partition);
        const std::vector<TrianglePair>& its = one_->detect(scene, options).contacts;
        ASSERT_TRUE(isOrdered(its)) << "seed " << seed;
        all.insert(all.end(), its.begin(), its.end());
        dealt_out += its.empty() || its.size() == expected.size() ? 0 : 1;
      }
      std::sort(all.begin(), all.end());
      ASSERT_TRUE(samePairs(expected, all)) << "seed " << seed << ", " << count << " partitions";
      found += all.size();
    }
  }
  EXPECT_GT(found, 100U);
  EXPECT_GT(dealt_out, 100U);
}

TEST_P(PartResults, ReadVerticesSoonestWhereOneDoes) {
  const auto detector = shared(3);
  EXPECT_EQ(&detector->vertexMemory(), &one_->vertexMemory());
  Scene scene = randomScene(1);
  scene.useMemory(detector->vertexMemory());
  const std::vector<TrianglePair> expected = one_->detect(scene, Options()).contacts;
  EXPECT_FALSE(expected.empty());
  EXPECT_TRUE(samePairs(expected, detector->detect(scene, Options()).contacts));
}

// Long-lived detectors on a scene of which bodies come and go and all else changes, with cold
// starts.
TEST_P(PartResults, PartitionsFindWhatOneFinds) {
  std::vector<std::unique_ptr<Detector>> detectors;
  for (std::size_t count = 2; count <= kMostPartitions; ++count) detectors.push_back(shared(count));
  std::size_t found = 0, long_steps = 0;
  for (std::uint32_t seed = 0; seed < 1 + kScenes / 50; ++seed) {
    SceneWalk walk(seed);
    for (int i = 0; i < 60; ++i) {
      const std::string step = walk.step();
      Options options = walk.options();
      options.geometry = i % 3 == 0;
      options.nearest = i % 4 == 0;
      options.tolerance_m = i % 6 == 4 ? 0.01F : 0;
      options.overlap = 1;
      options.predicates = Predicates::kExact;
      // What the CPU makes of clusters is random_walk_test's; in strange scenes they take long.
      if (GetParam().make == makeStandIn) options.clusters = 1;
      const DetectionResult& expected = one_->detect(walk.scene(), options);
      // Stand-ins find all contacts again for each partition, so they take long where nearly all
      // pairs touch. Two such steps are enough: their lists are merged in several parts.
      const bool is_long = GetParam().make == makeStandIn && expected.contacts.size() > 50'000;
      if (is_long && ++long_steps > 2) continue;
      for (const auto& detector : detectors) {
        if (i % 20 == 19) detector->reset();
        const DetectionResult& result = detector->detect(walk.scene(), options);
        ASSERT_TRUE(sameLists(expected, result)) << "seed " << seed << ", " << i << ": " << step;
        ASSERT_FALSE(result.cut_off);
        ASSERT_EQ(options.tolerance_m > 0 ? pairsOfTwo(walk.scene()) : 0, result.distances.size());
        ASSERT_EQ(expected.guaranteed, result.guaranteed);
        ASSERT_EQ(expected.counters.triangles, result.counters.triangles);
        ASSERT_EQ(expected.counters.rejected, result.counters.rejected);
        ASSERT_EQ(expected.counters.culled, result.counters.culled);
      }
      found += expected.contacts.size();
    }
  }
  EXPECT_GT(found, 100U);
  EXPECT_LT(long_steps, 20 * (1 + kScenes / 50));
}

TEST_P(PartResults, OfSteps) {
  constexpr float kPads[] = {0, 0, 0, 1e-30F, 0.01F, 0.25F, 1e30F};
  std::vector<std::unique_ptr<Detector>> detectors;
  for (std::size_t count = 2; count <= kMostPartitions; ++count) detectors.push_back(shared(count));
  std::size_t found = 0;
  for (std::uint32_t seed = 0; seed < kScenes; ++seed) {
    Scene scene = seed % 10 == 9 ? largeSweptScene(seed) : randomSweptScene(seed);
    for (BodyId b = 0; b < scene.bodyCount(); ++b) scene.setPad(b, kPads[(seed + 3 * b) % 7]);
    Options options;
    options.motion = Motion::kSwept;
    options.first_times = seed % 2 == 0;
    options.adjacent = seed % 3 == 0 ? AdjacentPairs::kSkip : AdjacentPairs::kBeyondShared;
    options.clusters = static_cast<int>(seed % 8);
    const DetectionResult& expected = one_->detect(scene, options);
    for (const auto& detector : detectors) {
      ASSERT_TRUE(sameLists(expected, detector->detect(scene, options))) << "seed " << seed;
    }
    found += expected.contacts.size();
  }
  EXPECT_GT(found, 100U);
}

// In a plane, folded over itself.
Scene foldedScene() {
  TriangleMesh folded = clothGrid(12, 1, 0, 0);
  for (std::size_t i = 0; i < folded.vertices.size(); i += 3) {
    folded.vertices[i] = std::fabs(folded.vertices[i] - 0.5F);
  }
  return selfScene(folded);
}

TEST_P(PartResults, OfLargerScenes) {
  const auto reference = makeCpuDetector();
  std::vector<Scene> scenes = {largeRandomScene(1), largeRandomScene(2), foldedScene(),
                               selfScene(clothGrid(60, 1, 0, 0.3F))};
  if (testDataIsThere() && GetParam().name == std::string("cuda")) {
    scenes.push_back(selfScene(readMeshFile(testDataFile("cloth-ball/cloth_ball92.ply"))));
  }
  for (const AdjacentPairs adjacent : {AdjacentPairs::kSkip, AdjacentPairs::kBeyondShared}) {
    Options options;
    options.adjacent = adjacent;
    for (const Scene& scene : scenes) {
      const std::vector<TrianglePair> expected = reference->detect(scene, options).contacts;
      for (std::size_t count = 2; count <= kMostPartitions; ++count) {
        const auto detector = shared(count);
        // Bounds move meanwhile.
        for (int cycle = 0; cycle < 20; ++cycle) {
          ASSERT_TRUE(samePairs(expected, detector->detect(scene, options).contacts))
              << count << " partitions, cycle " << cycle;
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, PartResults, ::testing::ValuesIn(makers()),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace deformable_contact_monitor
