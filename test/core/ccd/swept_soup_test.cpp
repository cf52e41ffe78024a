// Thousands of small random scenes in two states, as sets against the oracle; and against exact
// tests at single times. $DCM_FUZZ_SOUPS says how many.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <set>

#include "cgal_oracle.h"
#include "swept/swept_triangle.h"
#include "swept_expected.h"

namespace deformable_contact_monitor {
namespace {

const std::uint32_t kScenes = [] {
  const char* wanted = std::getenv("DCM_FUZZ_SOUPS");
  return wanted != nullptr ? static_cast<std::uint32_t>(std::atoi(wanted)) : 2000U;
}();

// Knobs that must not change any result, different for every seed.
Options knobs(std::uint32_t seed, AdjacentPairs adjacent) {
  Options options = sweptOptions(adjacent);
  options.fuzzifier = 1.05F + 0.1F * static_cast<float>(seed % 20);
  options.iterations = static_cast<int>(seed % 4);
  options.refresh_period = 1 + static_cast<int>(seed % 3);
  options.threads = 1 + static_cast<int>(seed % 2);
  options.first_times = seed % 2 == 0;
  return options;
}

class SweptSoup : public SweptFixture {};

TEST_P(SweptSoup, EqualsTheOracleForAnyClusters) {
  std::size_t found = 0, between = 0;
  // The reference gets a part of the scenes, because the oracle takes most of the time.
  const std::uint32_t scenes = isBruteForce() ? kScenes / 4 : kScenes;
  for (std::uint32_t seed = 0; seed < scenes; ++seed) {
    const Scene scene = randomSweptScene(seed);
    const AdjacentPairs adjacent = kBothAdjacent[seed % 2];
    const std::vector<TrianglePair> expected = oracleSwept(scene, adjacent);
    Options options = knobs(seed, adjacent);
    for (const int clusters : clusterCounts()) {
      options.clusters = clusters;
      const DetectionResult& result = detector_->detect(scene, options);
      ASSERT_TRUE(samePairs(expected, result.contacts))
          << "seed " << seed << ", clusters " << clusters << ", " << toString(adjacent);
      ASSERT_TRUE(result.guaranteed);
      ASSERT_TRUE(result.within_pad.empty() && result.separations_m.empty());
      ASSERT_EQ(options.first_times ? expected.size() : 0, result.first_times.size());
      for (const FirstContact& time : result.first_times) between += time.low > 0;
    }
    found += expected.size();
  }
  EXPECT_GT(found, scenes);
  EXPECT_GT(between, scenes / 10);
}

TEST_P(SweptSoup, FirstTimesAreTheOracles) {
  std::size_t exact = 0, infima = 0;
  for (std::uint32_t seed = 0; seed < kScenes / 16; ++seed) {
    const Scene scene = randomSweptScene(seed);
    for (const AdjacentPairs adjacent : kBothAdjacent) {
      const DetectionResult& result = detector_->detect(scene, timedOptions(adjacent));
      ASSERT_EQ(result.contacts.size(), result.first_times.size());
      ASSERT_TRUE(samePairs(oracleSwept(scene, adjacent), result.contacts)) << "seed " << seed;
      const std::vector<SweptTime> truth =
          oracleFirstTimes(earlierScene(scene), laterScene(scene), result.contacts);
      for (std::size_t i = 0; i < truth.size(); ++i) {
        ASSERT_TRUE(holds(result.first_times[i], truth[i]))
            << "seed " << seed << ", " << result.contacts[i] << ", " << toString(adjacent);
        exact += truth[i].low == truth[i].high && truth[i].low > 0;
        infima += !truth[i].is_attained;
      }
    }
  }
  EXPECT_GT(exact, kScenes / 40);
  EXPECT_GT(infima, 0U);
}

TEST_P(SweptSoup, ConservativeLosesNothingAndSaysWhatItAdds) {
  Options options = timedOptions();
  for (std::uint32_t seed = 0; seed < kScenes / 4; ++seed) {
    const Scene scene = randomSweptScene(seed);
    options.predicates = Predicates::kExact;
    const DetectionResult exact = detector_->detect(scene, options);
    options.predicates = Predicates::kConservative;
    const DetectionResult& result = detector_->detect(scene, options);
    ASSERT_TRUE(includes(result.contacts, exact.contacts)) << "seed " << seed;
    ASSERT_LE(result.contacts.size() - exact.contacts.size(), result.counters.undecided);
    ASSERT_TRUE(result.guaranteed);
    ASSERT_TRUE(isOrdered(result.contacts)) << "seed " << seed;
    ASSERT_EQ(result.contacts.size(), result.first_times.size());
    for (const FirstContact& time : result.first_times) {
      ASSERT_TRUE(0 <= time.low && time.low <= time.high && time.high <= 1) << "seed " << seed;
    }
    for (std::size_t i = 0, k = 0; i < exact.contacts.size(); ++i, ++k) {
      while (result.contacts[k] < exact.contacts[i]) ++k;
      ASSERT_LE(result.first_times[k].low, exact.first_times[i].high) << "seed " << seed;
    }
  }
}

// Counts triangles of bodies that take part and that have no finite place in one of the two states.
TEST_P(SweptSoup, CountsRejectedTriangles) {
  std::uint64_t rejected = 0;
  for (std::uint32_t seed = 0; seed < 400; ++seed) {
    Scene scene = randomSweptScene(seed);
    for (BodyId b = 0; b < scene.bodyCount(); ++b) scene.setPairEnabled(b, b, true);
    const std::uint64_t expected =
        scene.triangleCount() - sweptTriangles(earlierScene(scene), laterScene(scene)).size();
    ASSERT_EQ(expected, detector_->detect(scene, sweptOptions()).counters.rejected)
        << "seed " << seed;
    rejected += expected;
  }
  EXPECT_GT(rejected, 30U);
}

// The scene at numerator / denominator of the step, times denominator: small integers.
Scene sceneAt(const Scene& scene, int numerator, int denominator) {
  Scene out = laterScene(scene);
  for (BodyId b = 0; b < scene.bodyCount(); ++b) {
    TriangleMesh mesh = scene.body(b).mesh;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      mesh.vertices[i] =
          scene.body(b).earlier->vertices[i] * static_cast<float>(denominator - numerator) +
          mesh.vertices[i] * static_cast<float>(numerator);
    }
    out.setVertices(b, mesh.vertices.data(), mesh.vertexCount());
  }
  return out;
}

// Enabled pairs whose closed triangles have a common point, of one body's too.
std::vector<TrianglePair> touchingPairs(const Scene& scene) {
  const std::vector<SweptTriangle> triangles = sweptTriangles(scene, scene);
  const auto corners = [](const SweptTriangle& t) {
    const Triangle& at = t.posed[0];
    return OracleTriangle{at.v[0], at.v[1], at.v[2]};
  };
  std::vector<TrianglePair> pairs;
  for (auto a = triangles.begin(); a != triangles.end(); ++a) {
    for (auto b = a + 1; b != triangles.end(); ++b) {
      if (!scene.pairEnabled(a->body, b->body)) continue;
      if (!meetBeyondByPredicates(corners(*a), corners(*b), {})) continue;
      pairs.emplace_back(a->body, a->triangle, b->body, b->triangle);
    }
  }
  return pairs;
}

// Returns whether the two triangles have a corner in common during the whole interval.
bool shareATrajectory(const Scene& scene, const TrianglePair& p) {
  if (p.body_a != p.body_b) return false;
  const Body& body = scene.body(p.body_a);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t a = 3 * std::size_t{body.mesh.triangles[3 * p.triangle_a + i]};
      const std::size_t b = 3 * std::size_t{body.mesh.triangles[3 * p.triangle_b + j]};
      const auto equal = [a, b](const std::vector<float>& xyz) {
        return std::equal(&xyz[a], &xyz[a] + 3, &xyz[b]);
      };
      if (equal(body.mesh.vertices) && equal(body.earlier->vertices)) return true;
    }
  }
  return false;
}

// Nothing that a test at a single time sees is missed, or first earlier than is told. Pairs that
// share a vertex are left out here.
TEST_P(SweptSoup, HoldsWhatIsSeenAtSingleTimes) {
  std::size_t seen = 0, at_single_times_alone = 0;
  for (std::uint32_t seed = 0; seed < kScenes / 10; ++seed) {
    const Scene scene = integerSweptScene(seed);
    const DetectionResult& result = detector_->detect(scene, timedOptions(AdjacentPairs::kSkip));
    std::set<TrianglePair> at_an_end;
    for (const int denominator : {1, 2, 3, 5, 7, 8}) {
      for (int numerator = 0; numerator <= denominator; ++numerator) {
        for (const TrianglePair& p : touchingPairs(sceneAt(scene, numerator, denominator))) {
          if (shareATrajectory(scene, p)) continue;
          const auto place = std::lower_bound(result.contacts.begin(), result.contacts.end(), p);
          ASSERT_TRUE(place != result.contacts.end() && *place == p)
              << "seed " << seed << ", " << p << " at " << numerator << "/" << denominator;
          const FirstContact& time =
              result.first_times[static_cast<std::size_t>(place - result.contacts.begin())];
          ASSERT_LE(static_cast<double>(time.low) * denominator, numerator)
              << "seed " << seed << ", " << p;
          ++seen;
          if (denominator == 1) at_an_end.insert(p);
          at_single_times_alone += at_an_end.count(p) == 0;
        }
      }
    }
  }
  EXPECT_GT(seen, 10 * kScenes);
  EXPECT_GT(at_single_times_alone, kScenes / 4);
}

INSTANTIATE_TEST_SUITE_P(, SweptSoup, ::testing::ValuesIn(sweptBackends()), backendName);

class LargeSweptSoup : public SweptFixture {};

// Some of the pairs whose boxes overlap are asked of the oracle: all would take it minutes.
void expectTheOracleAgrees(const Scene& scene, const Options& options,
                           const std::vector<TrianglePair>& found) {
  const Scene to = laterScene(scene);
  const std::vector<SweptTriangle> triangles = sweptTriangles(earlierScene(scene), to);
  const auto pairs = sweptBoxPairs(to, triangles, options.adjacent);
  std::mt19937 random(1);
  for (int i = 0; i < 500; ++i) {
    const auto& [a, b] = pairs[random() % pairs.size()];
    const TrianglePair p{a->body, a->triangle, b->body, b->triangle};
    ASSERT_EQ(meetEver(hullsOf(*a, *b)), std::binary_search(found.begin(), found.end(), p)) << p;
  }
}

TEST_P(LargeSweptSoup, EqualsBruteForceForAnyClusters) {
  const auto brute_force = makeBruteForceDetector();
  for (std::uint32_t seed = 0; seed < 8; ++seed) {
    const Scene scene = largeSweptScene(seed);
    Options options = knobs(seed, kBothAdjacent[seed / 2 % 2]);
    const std::vector<TrianglePair> expected = brute_force->detect(scene, options).contacts;
    ASSERT_GT(expected.size(), 500U) << "seed " << seed;
    for (const int clusters : {1, 2, 7, 64, 200, 0}) {
      options.clusters = clusters;
      ASSERT_TRUE(samePairs(expected, contacts(scene, options)))
          << "seed " << seed << ", clusters " << clusters;
    }
    ASSERT_NO_FATAL_FAILURE(expectTheOracleAgrees(scene, options, expected)) << "seed " << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(, LargeSweptSoup, ::testing::ValuesIn(sweptProductBackends()),
                         backendName);

}  // namespace
}  // namespace deformable_contact_monitor
