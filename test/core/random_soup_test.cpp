// Thousands of small random scenes, and some larger ones, as sets against the oracle.
// $DCM_FUZZ_SOUPS says how many.
#include <gtest/gtest.h>

#include <cstdlib>

#include "cgal_oracle.h"
#include "detector_suite.h"
#include "random_scenes.h"

namespace deformable_contact_monitor {
namespace {

const std::uint32_t kScenes = [] {
  const char* wanted = std::getenv("DCM_FUZZ_SOUPS");
  return wanted != nullptr ? static_cast<std::uint32_t>(std::atoi(wanted)) : 4000U;
}();

// Knobs that must not change any result, different for every seed.
Options knobs(std::uint32_t seed, AdjacentPairs adjacent) {
  Options options = withAdjacent(adjacent);
  options.fuzzifier = 1.05F + 0.1F * static_cast<float>(seed % 20);
  options.iterations = static_cast<int>(seed % 4);
  options.refresh_period = 1 + static_cast<int>(seed % 3);
  options.threads = 1 + static_cast<int>(seed % 2);
  return options;
}

std::uint64_t nonFiniteTriangles(const Scene& scene) {
  std::uint64_t count = 0;
  for (const Body& body : scene.bodies()) {
    for (std::size_t t = 0; t < body.mesh.triangleCount(); ++t) {
      bool finite = true;
      for (std::size_t k = 0; k < 9; ++k) {
        const std::size_t vertex = body.mesh.triangles[3 * t + k / 3];
        finite = finite && std::isfinite(body.mesh.vertices[3 * vertex + k % 3]);
      }
      count += !finite;
    }
  }
  return count;
}

class RandomSoup : public DetectorSuite {};

TEST_P(RandomSoup, EqualsTheOracleForAnyClusters) {
  for (std::uint32_t seed = 0; seed < kScenes; ++seed) {
    const Scene scene = randomScene(seed);
    for (const AdjacentPairs adjacent : kBothAdjacent) {
      const std::vector<TrianglePair> expected = oracleContacts(scene, adjacent);
      Options options = knobs(seed, adjacent);
      for (const int clusters : {1, 2, 7, 64, 0}) {
        options.clusters = clusters;
        const DetectionResult& result = detector_->detect(scene, options);
        ASSERT_TRUE(samePairs(expected, result.contacts))
            << "seed " << seed << ", clusters " << clusters << ", "
            << (adjacent == AdjacentPairs::kSkip ? "skip" : "beyond_shared");
        ASSERT_TRUE(result.guaranteed);
        if (GetParam().name == std::string("brute_force")) break;
      }
    }
  }
}

TEST_P(RandomSoup, ConservativeLosesNothingAndSaysWhatItAdds) {
  Options options;
  options.predicates = Predicates::kConservative;
  for (std::uint32_t seed = 0; seed < kScenes / 4; ++seed) {
    const Scene scene = randomScene(seed);
    const std::vector<TrianglePair> exact = oracleContacts(scene, AdjacentPairs::kBeyondShared);
    const DetectionResult& result = detector_->detect(scene, options);
    ASSERT_TRUE(isOrdered(result.contacts)) << "seed " << seed;
    ASSERT_TRUE(
        std::includes(result.contacts.begin(), result.contacts.end(), exact.begin(), exact.end()))
        << "seed " << seed;
    ASSERT_LE(result.contacts.size() - exact.size(), result.counters.undecided) << "seed " << seed;
  }
}

TEST_P(RandomSoup, CountsRejectedTriangles) {
  std::uint64_t rejected = 0;
  for (std::uint32_t seed = 0; seed < 300; ++seed) {
    Scene scene = randomScene(seed);
    for (BodyId b = 0; b < scene.bodyCount(); ++b) {
      scene.setPose(b, RigidTransform());
      scene.setPairEnabled(b, b, true);
    }
    const std::uint64_t expected = nonFiniteTriangles(scene);
    ASSERT_EQ(expected, detector_->detect(scene, Options()).counters.rejected) << "seed " << seed;
    rejected += expected;
  }
  EXPECT_GT(rejected, 100U);
}

INSTANTIATE_TEST_SUITE_P(, RandomSoup, ::testing::ValuesIn(allBackends()), backendName);

class LargeRandomSoup : public DetectorSuite {};

TEST_P(LargeRandomSoup, EqualsTheOracleForAnyClusters) {
  for (std::uint32_t seed = 0; seed < 16; ++seed) {
    const Scene scene = largeRandomScene(seed);
    for (const AdjacentPairs adjacent : kBothAdjacent) {
      const std::vector<TrianglePair> expected = oracleContacts(scene, adjacent);
      ASSERT_GT(expected.size(), 50U) << "seed " << seed;
      Options options = knobs(seed, adjacent);
      for (const int clusters : {1, 2, 7, 64, 500, 0}) {
        options.clusters = clusters;
        ASSERT_TRUE(samePairs(expected, contacts(scene, options)))
            << "seed " << seed << ", clusters " << clusters;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, LargeRandomSoup, ::testing::ValuesIn(productBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
