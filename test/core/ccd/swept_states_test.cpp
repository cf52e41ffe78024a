// Continuous detection compared with discrete detection: bodies that do not move, each end of the
// interval, motion backwards, and two halves.
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <string>

#include "random_scenes.h"
#include "scenes.h"
#include "swept/swept_triangle.h"
#include "swept_expected.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint32_t kScenes = 600;

Options instantOptions(const Options& swept) {
  Options options = swept;
  options.motion = Motion::kInstant;
  options.first_times = false;
  return options;
}

// Returns whether each triangle is finite in both states.
bool isFinite(const Scene& scene) {
  return sweptTriangles(earlierScene(scene), laterScene(scene)).size() == scene.triangleCount();
}

// Each triangle as a body of its own; all pairs are enabled.
Scene singleTriangles(const Scene& scene) {
  Scene out;
  for (const SweptTriangle& t : sweptTriangles(earlierScene(scene), laterScene(scene))) {
    const BodyId id = out.addBody("triangle", meshOf({t.posed[1]}));
    out.setEarlier(id, RigidTransform(), meshOf({t.posed[0]}).vertices);
    for (BodyId other = 0; other < id; ++other) out.setPairEnabled(other, id, true);
  }
  return out;
}

class SweptStates : public SweptFixture {
 protected:
  // Whatever says that nothing moves: swept detection is instant detection, at t = 0.
  void expectStatic(const Scene& scene, const Options& options, const std::string& what) {
    const DetectionResult instant = detector_->detect(laterScene(scene), instantOptions(options));
    const DetectionResult& result = detector_->detect(scene, options);
    ASSERT_TRUE(samePairs(instant.contacts, result.contacts)) << what;
    ASSERT_EQ(instant.counters.rejected, result.counters.rejected) << what;
    for (const FirstContact& time : result.first_times) {
      ASSERT_TRUE(time.low == 0 && time.high == 0) << what;
    }
  }

  void expectStaticInBothWays(const Scene& scene, AdjacentPairs adjacent, const std::string& what) {
    Options options = timedOptions(adjacent);
    options.clusters = 3;
    expectStatic(stepScene(scene, scene), options, what + ", the same again");
    expectStatic(laterScene(scene), options, what + ", no earlier state");
  }
};

TEST_P(SweptStates, ZeroMotionIsTheStaticResult) {
  for (std::uint32_t seed = 0; seed < kScenes && !HasFatalFailure(); ++seed) {
    const std::string what = "seed " + std::to_string(seed);
    expectStaticInBothWays(randomScene(seed), kBothAdjacent[seed % 2], what);
    expectStaticInBothWays(earlierScene(randomSweptScene(seed)), kBothAdjacent[seed % 2], what);
  }
}

// Conservative predicates may leave other pairs undecided, and lose none.
TEST_P(SweptStates, ZeroMotionIsConservativeToo) {
  Options options = sweptOptions();
  options.predicates = Predicates::kConservative;
  for (std::uint32_t seed = 0; seed < kScenes; ++seed) {
    const Scene scene = randomScene(seed);
    const std::vector<TrianglePair> instant = contacts(scene);
    const DetectionResult& result = detector_->detect(stepScene(scene, scene), options);
    ASSERT_TRUE(includes(result.contacts, instant)) << "seed " << seed;
    ASSERT_LE(result.contacts.size() - instant.size(), result.counters.undecided);
  }
}

// A pose that changes nothing, and equal vertices with another sign of zero, are no motion.
TEST_P(SweptStates, EqualPlacesAreNoMotion) {
  const TriangleMesh cloth = clothGrid(6, 4, 0, 1);
  Scene scene = pairScene(cloth, clothGrid(6, 4, 0, -1));
  RigidTransform pose;
  pose.translation[0] = 1;
  TriangleMesh moved = cloth;
  for (std::size_t i = 0; i < moved.vertices.size(); i += 3) moved.vertices[i] -= 1;
  scene.setVertices(0, moved.vertices.data(), moved.vertexCount());
  scene.setPose(0, pose);
  std::vector<float> zeros = cloth.vertices;
  for (float& x : zeros) x = x == 0 ? -0.0F : x;
  scene.setEarlier(0, RigidTransform(), zeros);
  const DetectionResult& result = detector_->detect(scene, timedOptions());
  EXPECT_GT(result.contacts.size(), 20U);
  for (const FirstContact& time : result.first_times) EXPECT_EQ(time.high, 0);
  const std::vector<TrianglePair> swept = result.contacts;
  EXPECT_TRUE(samePairs(contacts(laterScene(scene)), swept));
}

TEST_P(SweptStates, ContainTheContactsOfBothEnds) {
  std::size_t more = 0;
  for (std::uint32_t seed = 0; seed < kScenes; ++seed) {
    const Scene scene = randomSweptScene(seed);
    // A triangle that is finite in one state alone has contacts there, and takes no part in a step.
    if (!isFinite(scene)) continue;
    for (const AdjacentPairs adjacent : kBothAdjacent) {
      const std::vector<TrianglePair> all = swept(scene, adjacent);
      std::size_t at_ends = 0;
      for (const Scene& end : {earlierScene(scene), laterScene(scene)}) {
        const std::vector<TrianglePair> instant = contacts(end, withAdjacent(adjacent));
        ASSERT_TRUE(includes(all, instant)) << "seed " << seed << ", " << toString(adjacent);
        at_ends += instant.size();
      }
      more += all.size() > at_ends ? 1 : 0;
    }
  }
  EXPECT_GT(more, kScenes / 10);
}

TEST_P(SweptStates, BackwardsIsTheSame) {
  for (std::uint32_t seed = 0; seed < kScenes; ++seed) {
    const Scene scene = randomSweptScene(seed);
    for (const AdjacentPairs adjacent : kBothAdjacent) {
      const std::vector<TrianglePair> forwards = swept(scene, adjacent);
      ASSERT_TRUE(samePairs(forwards, swept(reversedScene(scene), adjacent)))
          << "seed " << seed << ", " << toString(adjacent);
    }
  }
}

// Where the points halfway are float32 numbers. A pair that shares a vertex in a half alone is left
// out of that half, so bodies of one triangle each, which share none.
TEST_P(SweptStates, HalvesAddUpToTheWhole) {
  std::size_t found = 0, in_one_half = 0;
  for (std::uint32_t seed = 0; seed < kScenes; ++seed) {
    const Scene step = singleTriangles(integerSweptScene(seed));
    const Scene from = earlierScene(step), to = laterScene(step);
    Scene middle = to;
    for (BodyId b = 0; b < to.bodyCount(); ++b) {
      std::vector<float> xyz = to.body(b).mesh.vertices;
      for (std::size_t i = 0; i < xyz.size(); ++i) {
        xyz[i] = (xyz[i] + from.body(b).mesh.vertices[i]) / 2;
      }
      middle.setVertices(b, xyz.data(), xyz.size() / 3);
    }
    const std::vector<TrianglePair> whole = swept(step);
    const std::vector<TrianglePair> first = swept(stepScene(from, middle));
    const std::vector<TrianglePair> second = swept(stepScene(middle, to));
    std::vector<TrianglePair> both;
    std::set_union(first.begin(), first.end(), second.begin(), second.end(),
                   std::back_inserter(both));
    ASSERT_TRUE(samePairs(whole, both)) << "seed " << seed;
    found += whole.size();
    in_one_half += 2 * both.size() - first.size() - second.size();
  }
  EXPECT_GT(found, 3 * kScenes);
  EXPECT_GT(in_one_half, kScenes / 2);
}

INSTANTIATE_TEST_SUITE_P(, SweptStates, ::testing::ValuesIn(sweptBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
