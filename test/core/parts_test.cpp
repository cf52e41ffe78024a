// Parts of bodies, beside brute force without parts, filtered by the rules. $DCM_PART_SCENES says
// how many random scenes.
#include <gtest/gtest.h>

#include <cfloat>
#include <chrono>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bounds/bounded_fixture.h"
#include "core/body_distance.h"
#include "core/bounds/radii.h"
#include "nearest_pairs.h"
#include "parts_fixture.h"
#include "random_scenes.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

const std::uint32_t kScenes = numberFromEnvironment("DCM_PART_SCENES", 500);

// Margins and adjacency that differ from seed to seed.
Options optionsOf(std::uint32_t seed, Scene& scene) {
  constexpr float kMargins[] = {0, 0, 1e-40F, 0.1F, 0.5F, 10, 1e30F, FLT_MAX};
  for (BodyId id = 0; id < scene.bodyCount() && seed % 2 == 0; ++id) {
    scene.setMargin(id, kMargins[(seed / 3 + 5 * id) % 8]);
  }
  Options options = withAdjacent(kBothAdjacent[seed / 2 % 2]);
  options.clusters = static_cast<int>(seed % 5);
  options.threads = 1 + static_cast<int>(seed % 2);
  return options;
}

testing::AssertionResult sameGeometry(const HostList<PairGeometry>& expected,
                                      const HostList<PairGeometry>& found) {
  if (expected.size() != found.size()) return testing::AssertionFailure() << "other sizes";
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const PairGeometry &x = expected[i], &y = found[i];
    const float values[][2] = {{x.point_a.x, y.point_a.x},
                               {x.point_b.y, y.point_b.y},
                               {x.normal.x, y.normal.x},
                               {x.normal.z, y.normal.z},
                               {x.separation_m, y.separation_m}};
    for (const auto& pair : values) {
      if (std::memcmp(&pair[0], &pair[1], sizeof pair[0]) != 0) {
        return testing::AssertionFailure() << "geometry " << i << " differs";
      }
    }
  }
  return testing::AssertionSuccess();
}

class PartsSuite : public DetectorSuite {
 protected:
  // Expects the contacts that brute force finds without parts, as far as parts leave them, with
  // separations and geometry, and the same counts of rejected triangles.
  void expectFiltered(const Scene& scene, const Options& options) {
    const DetectionResult expected =
        filtered(scene, brute_force_->detect(undivided(scene), options));
    const ExpectedRejected rejected(scene, options.motion);
    for (int cycle = 0; cycle < 2; ++cycle) {
      const DetectionResult& found = detector_->detect(scene, options);
      ASSERT_TRUE(samePairs(expected.contacts, found.contacts)) << "cycle " << cycle;
      if (!expected.separations_m.empty()) {
        ASSERT_TRUE(sameBits(expected.separations_m, found.separations_m));
      }
      ASSERT_TRUE(sameGeometry(expected.geometry, found.geometry));
      ASSERT_EQ(rejected.all, found.counters.rejected);
      ASSERT_EQ(rejected.by_part, found.rejected_parts);
    }
    contacts_ += expected.contacts.size();
    rejected_ += rejected.by_part.size();
  }

  std::unique_ptr<Detector> brute_force_ = makeBruteForceDetector();
  std::size_t contacts_ = 0, rejected_ = 0;
};

TEST_P(PartsSuite, LeaveTheContactsThatBruteForceLeaves) {
  for (std::uint32_t seed = 0; seed < kScenes && !HasFatalFailure(); ++seed) {
    SCOPED_TRACE(seed);
    Scene scene = randomScene(seed);
    Options options = optionsOf(seed, scene);
    options.geometry = seed % 4 < 2;
    divide(scene, seed);
    if (seed % 3 == 0) giveMargins(scene, seed);
    expectFiltered(scene, options);
  }
  EXPECT_GT(contacts_, kScenes / 100 * 100);
  EXPECT_GE(rejected_, kScenes / 100 * 5);
}

// Thousands of triangles: many clusters and tiles, and oversized triangles.
TEST_P(PartsSuite, LeaveTheContactsThatBruteForceLeavesInLargeScenes) {
  for (std::uint32_t seed = 0; seed < 4 + kScenes / 500 && !HasFatalFailure(); ++seed) {
    SCOPED_TRACE(seed);
    Scene scene = largeRandomScene(seed);
    divide(scene, seed);
    Options options;
    options.clusters = static_cast<int>(seed % 3 * 20);
    expectFiltered(scene, options);
  }
  EXPECT_GT(contacts_, 100U);
}

// A detector with a past: the rules change while meshes stay, so that the last cycle's nearest
// triangles may not count any more.
TEST_P(PartsSuite, HaveTheNearestPairsOfBruteForceWhenRulesChange) {
  Scene scene = pairScene(clothGrid(14, 1, 0, 0.1F), clothGrid(9, 0.9F, 0.15F, 0.1F));
  scene.setMargin(0, 1);
  Options options;
  options.nearest = options.nearest_by_part = true;
  for (std::uint32_t seed = 0; seed < 30; ++seed) {
    divide(scene, seed);
    if (seed % 2 == 0) giveMargins(scene, seed);
    const auto parts = nearestOfAllParts(scene, *brute_force_, options);
    const DetectionResult& found = detector_->detect(scene, options);
    ASSERT_TRUE(sameNearest(nearestOfBodies(parts), found.nearest)) << "seed " << seed;
  }
}

// The nearest pairs of bodies and of parts.
TEST_P(PartsSuite, HaveTheNearestPairsOfBruteForce) {
  std::size_t apart = 0, touching = 0;
  for (std::uint32_t seed = 0; seed < kScenes; ++seed) {
    Scene scene = randomScene(seed);
    Options options = optionsOf(seed, scene);
    for (BodyId id = 0; id < scene.bodyCount() && seed % 2 == 1; ++id) scene.setMargin(id, 1);
    options.nearest = options.nearest_by_part = true;
    divide(scene, seed);
    if (seed % 3 == 0) giveMargins(scene, seed);
    std::vector<NearestOfParts> parts = nearestOfAllParts(scene, *brute_force_, options);
    const std::vector<NearestPair> bodies = nearestOfBodies(parts);
    const auto isUnnamed = [&scene](const NearestOfParts& of) {
      return scene.body(of.parts.body_a).parts.empty() && scene.body(of.parts.body_b).parts.empty();
    };
    parts.erase(std::remove_if(parts.begin(), parts.end(), isUnnamed), parts.end());
    for (int cycle = 0; cycle < 2; ++cycle) {
      const DetectionResult& found = detector_->detect(scene, options);
      ASSERT_TRUE(sameNearest(bodies, found.nearest)) << "seed " << seed << ", cycle " << cycle;
      ASSERT_TRUE(parts == found.nearest_parts) << "seed " << seed << ", cycle " << cycle;
    }
    for (const NearestPair& pair : bodies) ++(pair.distance_m > 0 ? apart : touching);
  }
  EXPECT_GE(apart, kScenes / 100 * 10);
  EXPECT_GE(touching, kScenes / 100 * 10);
}

// Bodies of many tiles, of which the disabled parts are the nearest ones.
TEST_P(PartsSuite, HaveTheNearestPairsOfBruteForceWhereDisabledPartsAreNearest) {
  for (std::uint32_t seed = 0; seed < 6; ++seed) {
    Scene scene = pairScene(clothGrid(40, 1, 0, 0.05F), clothGrid(30, 0.8F, 0.02F, 0.02F));
    scene.setMargin(0, seed % 2 == 0 ? 1.0F : 0.03F);
    divide(scene, seed);
    Options options;
    options.nearest = options.nearest_by_part = true;
    const auto parts = nearestOfAllParts(scene, *brute_force_, options);
    for (int cycle = 0; cycle < 3; ++cycle) {
      const DetectionResult& found = detector_->detect(scene, options);
      ASSERT_TRUE(sameNearest(nearestOfBodies(parts), found.nearest)) << "seed " << seed;
      const bool named = !scene.body(0).parts.empty() || !scene.body(1).parts.empty();
      ASSERT_TRUE((named ? parts : std::vector<NearestOfParts>()) == found.nearest_parts) << seed;
    }
  }
}

// Contacts of the interval with their first times, and those within pads.
TEST_P(PartsSuite, LeaveTheSweptContactsThatBruteForceLeaves) {
  for (std::uint32_t seed = 0; seed < kScenes / 2; ++seed) {
    Scene scene = randomScene(seed);
    for (BodyId id = 0; id < scene.bodyCount(); ++id) {
      RigidTransform from = scene.body(id).pose;
      from.translation[(seed + id) % 3] -= 0.7 + 0.1 * id;
      scene.setEarlier(id, from);
      if (seed % 3 == 0) scene.setPad(id, 0.05F);
    }
    Options options = withAdjacent(kBothAdjacent[seed % 2]);
    options.motion = Motion::kSwept;
    options.first_times = true;
    divide(scene, seed);
    const Scene whole = undivided(scene);
    const DetectionResult expected = filtered(scene, brute_force_->detect(whole, options));
    const DetectionResult own = filtered(scene, detector_->detect(whole, options));
    const ExpectedRejected rejected(scene, options.motion);
    const DetectionResult& found = detector_->detect(scene, options);
    if (!scene.anyPad()) {
      ASSERT_TRUE(samePairs(expected.contacts, found.contacts)) << "seed " << seed;
    }
    ASSERT_TRUE(samePairs(own.contacts, found.contacts)) << "seed " << seed;
    ASSERT_EQ(own.within_pad, found.within_pad) << "seed " << seed;
    ASSERT_EQ(own.first_times.size(), found.first_times.size());
    for (std::size_t i = 0; i < found.first_times.size(); ++i) {
      ASSERT_LE(found.first_times[i].low, own.first_times[i].high) << "seed " << seed;
      ASSERT_LE(own.first_times[i].low, found.first_times[i].high) << "seed " << seed;
    }
    ASSERT_EQ(rejected.all, found.counters.rejected) << "seed " << seed;
    ASSERT_EQ(rejected.by_part, found.rejected_parts) << "seed " << seed;
    contacts_ += found.contacts.size();
  }
  EXPECT_GE(contacts_, kScenes / 100 * 50);
}

// Parts and rules that change while the meshes stay.
TEST_P(PartsSuite, MayChangeFromCycleToCycle) {
  Scene scene = pairScene(clothGrid(12, 1, 0, 0.1F), clothGrid(9, 0.9F, 0.01F, 0.1F));
  scene.setPairEnabled(0, 0, true);
  for (std::uint32_t seed = 0; seed < 40 && !HasFatalFailure(); ++seed) {
    SCOPED_TRACE(seed);
    if (seed % 5 == 4) {
      scene.enableAllParts();
    } else {
      divide(scene, seed);
    }
    if (seed % 7 == 6) scene.setMesh(1, clothGrid(9 + seed % 3, 0.9F, 0.01F, 0.1F));
    expectFiltered(scene, Options());
  }
}

// Finds what it is given.
class CannedDetector : public Detector {
 public:
  explicit CannedDetector(DetectionResult result) : result_(std::move(result)) {}
  std::string backend() const override { return "canned"; }
  void reset() override {}
  void swapResult(DetectionResult& result) override { result_.swap(result); }
  const DetectionResult& detect(const Scene&, const Options&) override { return result_; }

 private:
  DetectionResult result_;
};

// The search of bodies ended, and that of the parts did not. The nearest triangle is of no part,
// and beyond the margin of that; but the part, which has a larger margin, may be near as well.
TEST(MarginsOfParts, AreOpenWhereTheirSearchWasCutOff) {
  for (const bool cut_off : {true, false}) {
    Scene scene = pairScene(clothGrid(2, 1, 0, 0), clothGrid(2, 1, 0.05F, 0));
    scene.setParts(1, {0, 1, 1, 1, 1, 1, 1, 1});
    scene.setPartMargins(1, {{1, 0.1F}});
    DetectionResult result;
    result.cut_off = cut_off;
    NearestPair nearest;
    nearest.pair = {0, 0, 1, 0};
    nearest.distance_m = 0.05F;
    result.nearest = {nearest};
    result.nearest_parts = {{{0, 1, 0, 0}, nearest}};
    BodyDistance distance;
    distance.body_b = 1;
    distance.low_m = distance.high_m = 0.05F;
    distance.witness = nearest.pair;
    distance.is_exact = true;
    result.distances = {distance};
    const auto detector =
        withRadiiAndPartMargins(std::make_unique<CannedDetector>(std::move(result)));
    Options options;
    options.nearest = true;
    const DetectionResult& found = detector->detect(scene, options);
    EXPECT_TRUE(found.nearest.empty());
    ASSERT_EQ(1U, found.distances.size());
    EXPECT_EQ(cut_off ? PairDecision::kOpen : PairDecision::kNone,
              decide(found.distances[0], scene, 0));
  }
}

// Decided by bounds: what is claimed holds for the parts that count.
TEST(PartsWithinATolerance, AreDecidedByWhatCounts) {
  const auto tilings = std::make_shared<TilingCache>();
  const auto detector = makeBoundedDetector(tilings);
  const auto brute_force = makeBruteForceDetector();
  std::size_t decided[4] = {};
  for (std::uint32_t seed = 0; seed < kScenes / 2; ++seed) {
    Scene scene = randomScene(seed);
    for (BodyId id = 0; id < scene.bodyCount(); ++id) scene.setMargin(id, 0.3F);
    divide(scene, seed);
    Options options;
    options.nearest = options.nearest_by_part = true;
    const auto parts = nearestOfAllParts(scene, *brute_force, options);
    options.tolerance_m = 0.05F;
    for (std::uint32_t i = 0; i <= TilingCache::kSettledAfter; ++i)
      detector->detect(scene, options);
    tilings->wait();
    const DetectionResult& found = detector->detect(scene, options);
    std::map<std::pair<BodyId, BodyId>, float> truth;
    for (const NearestPair& nearest : nearestOfBodies(parts)) {
      truth[{nearest.pair.body_a, nearest.pair.body_b}] = nearest.distance_m;
    }
    for (const BodyDistance& distance : found.distances) {
      const auto known = truth.find({distance.body_a, distance.body_b});
      const double true_m = known == truth.end() ? 1e38 : known->second;
      const double known_to = known == truth.end() ? 0.3 : INFINITY;
      SCOPED_TRACE(seed);
      expectTrue(scene, distance, options.tolerance_m, true_m, known_to);
      ++decided[static_cast<int>(decide(distance, scene, options.tolerance_m))];
    }
    for (const TrianglePair& pair : found.contacts) ASSERT_TRUE(isCompared(scene, pair)) << seed;
    for (const NearestOfParts& nearest : found.nearest_parts) {
      ASSERT_TRUE(std::find(parts.begin(), parts.end(), nearest) != parts.end()) << seed;
    }
    const auto isUnnamed = [&scene](const NearestOfParts& of) {
      return scene.body(of.parts.body_a).parts.empty() && scene.body(of.parts.body_b).parts.empty();
    };
    const auto unnamed = std::count_if(parts.begin(), parts.end(), isUnnamed);
    ASSERT_EQ(parts.size() - static_cast<std::size_t>(unnamed), found.nearest_parts.size()) << seed;
    ASSERT_EQ(ExpectedRejected(scene, Motion::kInstant).by_part, found.rejected_parts) << seed;
    Options in_time;  // with a deadline, the bounds also list contacts
    in_time.limits.deadline = std::chrono::steady_clock::now() + std::chrono::hours(1);
    const auto expected = filtered(scene, brute_force->detect(undivided(scene), Options()));
    ASSERT_TRUE(samePairs(expected.contacts, detector->detect(scene, in_time).contacts)) << seed;
  }
  EXPECT_EQ(0U, decided[static_cast<int>(PairDecision::kOpen)]);
  EXPECT_GE(decided[static_cast<int>(PairDecision::kNone)], kScenes / 100 * 10);
  EXPECT_GE(decided[static_cast<int>(PairDecision::kContact)], kScenes / 100 * 10);
}

#ifdef DCM_HAVE_FCL
// FCL, on triangles that share no vertex, as far as it is exact.
TEST(PartsByFcl, LeaveTheContactsThatBruteForceLeaves) {
  const auto fcl = makeFclDetector();
  const auto brute_force = makeBruteForceDetector();
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    Scene scene = pairScene(clothGrid(15, 1, 0, 0.1F), clothGrid(12, 0.9F, 0.013F, 0.12F));
    scene.setPairEnabled(0, 0, seed % 2 == 0);
    scene.setMargin(0, 0.5F);
    divide(scene, seed);
    Options options = withAdjacent(AdjacentPairs::kSkip);
    options.nearest = options.nearest_by_part = true;
    const DetectionResult& expected = brute_force->detect(scene, options);
    const DetectionResult& found = fcl->detect(scene, options);
    ASSERT_TRUE(samePairs(expected.contacts, found.contacts)) << "seed " << seed;
    ASSERT_EQ(expected.nearest_parts.size(), found.nearest_parts.size()) << "seed " << seed;
    for (std::size_t i = 0; i < found.nearest_parts.size(); ++i) {
      ASSERT_TRUE(expected.nearest_parts[i].parts == found.nearest_parts[i].parts);
      ASSERT_NEAR(expected.nearest_parts[i].nearest.distance_m,
                  found.nearest_parts[i].nearest.distance_m, 1e-6);
    }
  }
}
#endif

// What no enabled pair of parts needs is not looked at.
TEST_P(PartsSuite, WithoutAPairAreLeftOutEarly) {
  if (GetParam().name == std::string("brute_force")) return;
  Scene scene = pairScene(clothGrid(20, 1, 0, 0.1F), clothGrid(20, 1, 0.01F, 0.1F));
  scene.setPairEnabled(0, 0, true);
  const std::size_t count = scene.body(0).mesh.triangleCount();
  std::vector<PartId> parts(count, 1);
  std::fill_n(parts.begin(), count / 4, PartId{0});
  scene.setParts(0, parts);
  for (const PartId part : {0, 1}) scene.setPartPairEnabled(0, 1, 0, part, false);
  scene.setPartPairEnabled(0, 1, 1, 0, false);
  const Counters counters = detector_->detect(scene, Options()).counters;
  EXPECT_GE(counters.culled, count - count / 4);
}

INSTANTIATE_TEST_SUITE_P(, PartsSuite, ::testing::ValuesIn(allBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
