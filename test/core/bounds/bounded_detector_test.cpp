// States of pairs of bodies within a tolerance, against distances of all their triangles.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "bounded_fixture.h"
#include "core/mesh_file.h"
#include "pair_sets.h"
#include "random_scenes.h"
#include "scene_walk.h"
#include "scenes.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

using IdPair = std::pair<BodyId, BodyId>;

std::map<IdPair, double> trueDistances(const Scene& scene) {
  std::vector<std::vector<Triangle>> triangles;
  for (const Body& body : scene.bodies()) triangles.push_back(finiteTriangles(body));
  std::map<IdPair, double> distances;
  for (const IdPair& pair : scene.enabledPairs()) {
    if (pair.first == pair.second) continue;
    distances[pair] = trueDistance(triangles[pair.first], triangles[pair.second]);
  }
  return distances;
}

// That they are of all pairs of two bodies, decided, and true.
void expectAllTrue(const Scene& scene, const DetectionResult& result, float tolerance_m,
                   const std::map<IdPair, double>& truth, double known_to = INFINITY) {
  ASSERT_EQ(truth.size(), result.distances.size());
  auto expected = truth.begin();
  for (const BodyDistance& distance : result.distances) {
    EXPECT_EQ(expected->first, IdPair(distance.body_a, distance.body_b));
    EXPECT_NE(PairDecision::kOpen, decide(distance, marginOf(scene, distance), tolerance_m))
        << distance.body_a << " " << distance.body_b << ", low " << distance.low_m << ", high "
        << distance.high_m << ", truth " << expected->second;
    expectTrue(scene, distance, tolerance_m, expected->second, known_to);
    ++expected;
  }
}

// Those of the exact list that are no contacts of two bodies, and of the others the number by pair.
void expectContactsAreReal(const DetectionResult& exact, const DetectionResult& result) {
  EXPECT_TRUE(isOrdered(result.contacts));
  EXPECT_TRUE(std::includes(exact.contacts.begin(), exact.contacts.end(), result.contacts.begin(),
                            result.contacts.end()));
  std::vector<TrianglePair> own, expected;
  std::map<IdPair, std::size_t> count;
  for (const TrianglePair& pair : result.contacts) {
    if (pair.body_a == pair.body_b) own.push_back(pair);
    ++count[{pair.body_a, pair.body_b}];
  }
  for (const TrianglePair& pair : exact.contacts) {
    if (pair.body_a == pair.body_b) expected.push_back(pair);
  }
  EXPECT_TRUE(samePairs(expected, own));
  for (const BodyDistance& distance : result.distances) {
    EXPECT_EQ((count[{distance.body_a, distance.body_b}]), distance.contact_count);
  }
}

float randomLength(std::mt19937& random) {
  constexpr float kLengths[] = {0, 1e-3F, 1e-2F, 0.1F, 1, 1e-9F, 1e-30F, 1e20F, 1e-44F};
  return kLengths[random() % 9];
}

TEST_F(BoundedTest, SaysNothingFalseAndLeavesNothingOpenOnRandomScenes) {
  std::size_t decided[4] = {};
  const char* const given = std::getenv("DCM_BOUND_SEEDS");
  const std::uint32_t seeds = given == nullptr ? 600 : std::strtoul(given, nullptr, 10);
  for (std::uint32_t seed = 0; seed < seeds && !HasFatalFailure(); ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    Scene scene = randomScene(seed);
    for (BodyId id = 0; id < scene.bodyCount(); ++id) {
      if (random() % 2 == 0) scene.setMargin(id, randomLength(random));
    }
    const std::map<IdPair, double> truth = trueDistances(scene);
    if (truth.empty()) continue;
    settle(scene);
    const DetectionResult& exact = exact_->detect(scene, Options());
    for (const float tolerance_m : {1e-3F, 0.1F, 1e-30F, 1e10F, 1.4e-45F}) {
      SCOPED_TRACE(tolerance_m);
      Options options;
      options.tolerance_m = tolerance_m;
      const DetectionResult& result = detector_->detect(scene, options);
      expectAllTrue(scene, result, tolerance_m, truth);
      expectContactsAreReal(exact, result);
      EXPECT_EQ(exact.counters.rejected, result.counters.rejected);
      EXPECT_EQ(exact.counters.triangles, result.counters.triangles);
      EXPECT_FALSE(result.cut_off);
      EXPECT_FALSE(result.guaranteed);
      EXPECT_EQ(result.separations_m.size(), scene.anyMargin() ? result.contacts.size() : 0);
      for (const BodyDistance& distance : result.distances) {
        ++decided[static_cast<int>(decide(distance, marginOf(scene, distance), tolerance_m))];
      }
    }
  }
  for (const PairDecision each :
       {PairDecision::kNone, PairDecision::kNear, PairDecision::kContact}) {
    EXPECT_GT(decided[static_cast<int>(each)], 100U) << static_cast<int>(each);
  }
}

// Cloths whose tiles overlap everywhere while they are some way apart.
TEST_F(BoundedTest, DecidesCloseClothsAtAnyTolerance) {
  std::mt19937 random(3);
  for (int i = 0; i < 40; ++i) {
    const float gap = 0.0005F * static_cast<float>(1 + random() % 100);
    Scene scene = pairScene(clothGrid(20, 1, 0, 0.05F), clothGrid(17, 1, gap, 0.05F));
    scene.setMargin(0, static_cast<float>(random() % 4) * 0.01F);
    const std::map<IdPair, double> truth = trueDistances(scene);
    settle(scene);
    for (const float tolerance_m : {1e-6F, 1e-4F, 1e-3F, 5e-3F, 2e-2F, 0.1F}) {
      Options options;
      options.tolerance_m = tolerance_m;
      expectAllTrue(scene, detector_->detect(scene, options), tolerance_m, truth);
    }
  }
}

// Tiles overlap everywhere, and only a look at what is apart can end it early.
TEST_F(BoundedTest, DecidesSoupsByWhatTheToleranceAllows) {
  constexpr float kGapM = 1e-3F;
  for (int layers = 4; layers <= 24; ++layers) {  // of some 16 to 576 pairs of tiles
    SCOPED_TRACE(layers);
    Scene scene = pairScene(sliverSoup(0, layers, 32, kGapM), sliverSoup(1, layers, 32, kGapM));
    const std::map<IdPair, double> truth = trueDistances(scene);
    settle(scene);
    for (const float margin_m : {0.0F, 5e-4F, 2e-3F}) {
      scene.setMargin(0, margin_m);
      for (const float tolerance_m : {1e-6F, 9e-4F, 1.1e-3F, 5e-3F, 0.1F}) {
        Options options;
        options.tolerance_m = tolerance_m;
        const DetectionResult& result = detector_->detect(scene, options);
        expectAllTrue(scene, result, tolerance_m, truth);
        if (layers < 12) continue;
        EXPECT_EQ(decide(result.distances.front(), margin_m, tolerance_m),
                  tolerance_m > kGapM ? PairDecision::kContact
                  : margin_m > kGapM  ? PairDecision::kNear
                                      : PairDecision::kNone)
            << margin_m << " " << tolerance_m;
      }
    }
  }
}

TEST_F(BoundedTest, IsTheSameOnAnyNumberOfThreads) {
  for (std::uint32_t seed = 0; seed < 3; ++seed) {
    Scene scene = largeRandomScene(seed);
    scene.setMargin(0, 0.001F);
    for (BodyId id = 0; id < scene.bodyCount(); ++id) scene.setPairEnabled(id, id, false);
    settle(scene);
    Options options;
    options.tolerance_m = 1e-3F;
    options.threads = 1;
    const DetectionResult one = detector_->detect(scene, options);
    for (options.threads = 2; options.threads <= 4; ++options.threads) {
      const DetectionResult& other = detector_->detect(scene, options);
      EXPECT_TRUE(samePairs(one.contacts, other.contacts));
      ASSERT_EQ(one.distances.size(), other.distances.size());
      for (std::size_t i = 0; i < one.distances.size(); ++i) {
        EXPECT_EQ(one.distances[i].low_m, other.distances[i].low_m);
        EXPECT_EQ(one.distances[i].high_m, other.distances[i].high_m);
        EXPECT_EQ(one.distances[i].witness, other.distances[i].witness);
      }
    }
  }
}

// Bodies that come, move, change their triangles and are switched off and on.
TEST_F(BoundedTest, KeepsNothingThatChanged) {
  std::size_t looked_at = 0;
  for (std::uint32_t seed = 0; seed < 6; ++seed) {
    SceneWalk walk(seed);
    for (int step = 0; step < 120; ++step) {
      SCOPED_TRACE(::testing::Message()
                   << "seed " << seed << ", step " << step << ": " << walk.step());
      if (walk.scene().triangleCount() > 1500) continue;
      Options options = walk.options();
      options.predicates = Predicates::kExact;
      options.overlap = 1;
      options.tolerance_m = 1e-3F;
      tilings_->wait();
      const DetectionResult& result = detector_->detect(walk.scene(), options);
      if (result.distances.empty()) continue;
      expectAllTrue(walk.scene(), result, options.tolerance_m, trueDistances(walk.scene()));
      looked_at += result.distances.size();
    }
  }
  EXPECT_GT(looked_at, 200U);
}

// By a margin of 5 cm the exact detector tells the distances of all pairs that are nearer.
std::map<IdPair, double> distancesBelow(Detector& exact, Scene scene, float known_to) {
  for (BodyId id = 0; id < scene.bodyCount(); ++id) scene.setMargin(id, known_to);
  std::map<IdPair, double> distances;
  for (const IdPair& pair : scene.enabledPairs()) distances[pair] = 2 * known_to;
  const DetectionResult& result = exact.detect(scene, Options());
  for (std::size_t i = 0; i < result.contacts.size(); ++i) {
    double& least_m = distances[{result.contacts[i].body_a, result.contacts[i].body_b}];
    least_m = std::min<double>(least_m, result.separations_m[i]);
  }
  return distances;
}

TEST_F(BoundedTest, RobotLinksAndATShirtAtManyTolerancesAndMargins) {
  DCM_REQUIRE_TEST_DATA();
  constexpr float kKnownTo = 0.05F;
  Scene scene;
  TriangleMesh mesh = readMeshFile(testDataFile("tshirt/000.obj"));
  for (float& x : mesh.vertices) x *= 0.1F;  // to a T-shirt's size
  const BodyId shirt = scene.addBody("shirt", mesh);
  const std::string links = "robots/panda_description/meshes/collision/";
  for (const char* link : {"hand.stl", "link5.stl", "link3.stl", "finger.stl"}) {
    scene.setPairEnabled(shirt, scene.addBody(link, readMeshFile(testDataFile(links + link))),
                         true);
  }
  settle(scene);
  std::size_t contacts = 0, claimed = 0;
  for (int step = 0; step < 10; ++step) {
    for (BodyId id = 1; id < scene.bodyCount(); ++id) {
      const double angle = 0.37 * step + id, c = std::cos(angle), s = std::sin(angle);
      RigidTransform pose;
      const double rotation[9] = {c, -s, 0, s, c, 0, 0, 0, 1};
      std::copy(std::begin(rotation), std::end(rotation), pose.rotation);
      for (int axis = 0; axis < 3; ++axis)
        pose.translation[axis] = 0.2 * std::sin(step + 2 * axis + id);
      scene.setPose(id, pose);
    }
    const std::map<IdPair, double> truth = distancesBelow(*exact_, scene, kKnownTo);
    for (const float margin_m : {0.0F, 0.002F, 0.02F}) {
      scene.setMargin(shirt, margin_m);
      for (const float tolerance_m : {1e-6F, 1e-3F, 5e-3F, 2e-2F}) {
        Options options;
        options.tolerance_m = tolerance_m;
        const DetectionResult& result = detector_->detect(scene, options);
        expectAllTrue(scene, result, tolerance_m, truth, kKnownTo * (1 - 1e-6));
        for (const BodyDistance& distance : result.distances) {
          const bool touches = truth.at({distance.body_a, distance.body_b}) == 0;
          const bool claims = decide(distance, margin_m, tolerance_m) == PairDecision::kContact;
          EXPECT_TRUE(claims || !touches);
          contacts += touches;
          claimed += claims;
        }
      }
    }
  }
  EXPECT_GT(contacts, 100U);
  EXPECT_GE(claimed, contacts);
}

TEST_F(BoundedTest, GivesGeometryAndSeparationsBesideEachContact) {
  Scene scene = pairScene(clothGrid(20, 1, 0, 0.05F), clothGrid(17, 1, 0.001F, 0.08F));
  scene.setPairEnabled(0, 0, true);
  scene.setMargin(0, 0.001F);
  settle(scene);
  Options options;
  options.tolerance_m = 1e-6F;
  options.geometry = true;
  const DetectionResult& result = detector_->detect(scene, options);
  EXPECT_GE(result.contacts.size(), 1U);
  EXPECT_EQ(result.contacts.size(), result.geometry.size());
  EXPECT_EQ(result.contacts.size(), result.separations_m.size());
}

TEST_F(BoundedTest, IsExactWithoutToleranceAndDeadlineAndBetweenStates) {
  Scene scene = pairScene(clothGrid(20, 1, 0, 0.05F), clothGrid(17, 1, 0.001F, 0.08F));
  settle(scene);
  const DetectionResult& result = detector_->detect(scene, Options());
  EXPECT_TRUE(samePairs(exact_->detect(scene, Options()).contacts, result.contacts));
  EXPECT_TRUE(result.distances.empty());
  EXPECT_TRUE(result.guaranteed);
  Options swept;
  swept.motion = Motion::kSwept;
  swept.tolerance_m = 0.01F;
  scene.setEarlier(0, RigidTransform());
  EXPECT_TRUE(
      samePairs(exact_->detect(scene, swept).contacts, detector_->detect(scene, swept).contacts));
}

// Gaps of one step of float32 are as small as the bounds of distances themselves.
TEST_F(BoundedTest, DecidesBodiesOfTheSmallestNumbers) {
  std::mt19937 random(3);
  const auto soup = [&random](std::size_t triangles) {
    TriangleMesh mesh;
    for (std::size_t i = 0; i < 9 * triangles; ++i) {
      const int steps = static_cast<int>(random() % 41) - 20;
      mesh.vertices.push_back(static_cast<float>(steps * 0x1p-149));
    }
    for (std::uint32_t i = 0; i < 3 * triangles; ++i) mesh.triangles.push_back(i);
    return mesh;
  };
  std::size_t touching = 0;
  for (int i = 0; i < 300; ++i) {
    const TriangleMesh a = soup(1 + random() % 4);
    const Scene scene = pairScene(a, soup(1 + random() % 4));
    settle(scene);
    Options options;
    options.limits.deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    const DetectionResult& result = detector_->detect(scene, options);
    EXPECT_FALSE(result.cut_off) << i;
    const DetectionResult& exact = exact_->detect(scene, Options());
    EXPECT_TRUE(samePairs(exact.contacts, result.contacts)) << i;
    touching += !exact.contacts.empty();
  }
  EXPECT_GT(touching, 30U);
  EXPECT_LT(touching, 270U);
}

TEST_F(BoundedTest, IsExactUntilTilingsAreThere) {
  const Scene scene = pairScene(clothGrid(20, 1, 0, 0.05F), clothGrid(17, 1, 0.001F, 0.08F));
  Options options;
  options.tolerance_m = 0.01F;
  const DetectionResult& result = detector_->detect(scene, options);
  EXPECT_TRUE(samePairs(exact_->detect(scene, Options()).contacts, result.contacts));
  EXPECT_TRUE(result.guaranteed);
  EXPECT_TRUE(result.distances.empty());
}

}  // namespace
}  // namespace deformable_contact_monitor
