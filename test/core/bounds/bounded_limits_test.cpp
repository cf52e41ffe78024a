// Tests the results of a bounded detector that runs out of time.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <limits>
#include <map>
#include <memory_resource>
#include <random>
#include <utility>
#include <vector>

#include "bounded_fixture.h"
#include "core/bounds/bounded_cycle.h"
#include "core/bounds/radii.h"
#include "core/common/cycle_limit.h"
#include "pair_sets.h"
#include "random_scenes.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

using Clock = std::chrono::steady_clock;

Options withDeadline(Clock::duration from_now) {
  Options options;
  options.limits.deadline = Clock::now() + from_now;
  return options;
}

Scene crossingCloths() {
  Scene scene = pairScene(clothGrid(40, 1, 0, 0.05F), clothGrid(37, 1, 0.001F, 0.08F));
  scene.addBody("far", clothGrid(5, 1, 3, 0));
  scene.setPairEnabled(0, 2, true);
  scene.setPairEnabled(0, 0, true);
  return scene;
}

// Triangles with random corners in a box.
TriangleMesh soup(std::uint32_t seed, int count, float size) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0, 1);
  std::vector<Triangle> triangles(static_cast<std::size_t>(count));
  for (Triangle& t : triangles) {
    const Vec3f at{unit(random), unit(random), unit(random)};
    for (Vec3f& v : t.v) v = at + Vec3f{unit(random), unit(random), unit(random)} * size;
  }
  return meshOf(triangles);
}

TEST_F(BoundedTest, ADeadlineThatIsOverLeavesAllOpen) {
  const Scene scene = crossingCloths();
  settle(scene);
  for (const float tolerance_m : {0.0F, 0.01F}) {
    Options options = withDeadline(-std::chrono::seconds(1));
    options.tolerance_m = tolerance_m;
    const DetectionResult& result = detector_->detect(scene, options);
    EXPECT_TRUE(result.isOutOfTime());
    ASSERT_EQ(2U, result.distances.size());
    for (const BodyDistance& distance : result.distances) {
      EXPECT_EQ(PairDecision::kOpen, decide(distance, 0, tolerance_m));
      EXPECT_FALSE(distance.is_listed);
      EXPECT_EQ(0, distance.low_m);
    }
  }
}

// The exact detector has no time for the self-contact of a body whose distance is decided.
TEST_F(BoundedTest, WhatTheExactDetectorDidNotComeToIsRejectedAllTheSame) {
  Scene scene = pairScene(clothGrid(40, 1, 0, 0.05F), clothGrid(5, 1, 3, 0));
  TriangleMesh cloth = scene.body(0).mesh;
  cloth.vertices[0] = std::numeric_limits<float>::quiet_NaN();
  scene.setMesh(0, cloth);
  scene.setPairEnabled(0, 0, true);
  settle(scene);
  DetectionResult nothing;
  const auto exact = [&](const Scene& part, const Options& options) -> const DetectionResult& {
    nothing.begin(part, options, true);
    nothing.cutOff(kNoTime);
    return nothing;
  };
  BoundedCycle cycle(exact, tilings_, *std::pmr::new_delete_resource());
  const DetectionResult& result = cycle.detect(scene, withDeadline(std::chrono::hours(1)));
  ASSERT_EQ(result.distances.size(), 1U);
  EXPECT_EQ(decide(result.distances[0], 0, 0), PairDecision::kNone);
  EXPECT_GT(result.counters.rejected, 0U);
  EXPECT_EQ(result.counters.rejected, exact_->detect(scene, Options()).counters.rejected);
}

// Of bodies with a radius, the search has time, and the list has none.
class SearchOnly : public Detector {
 public:
  std::string backend() const override { return "search"; }
  void reset() override {}
  void swapResult(DetectionResult& result) override { result_.swap(result); }
  const DetectionResult& detect(const Scene& scene, const Options& options) override {
    result_.begin(scene, options, true);
    result_.counters.rejected = calls_++ == 0 ? 3 : 0;
    return result_;
  }

 private:
  DetectionResult result_;
  int calls_ = 0;
};

TEST(LimitsOfRadii, WhatTheSearchRejectedIsRejected) {
  Scene scene =
      pairScene(meshOf({Triangle{}}), meshOf({Triangle{{{1, 0, 0}, {1, 0, 0}, {1, 0, 0}}}}));
  scene.setRadius(1, 0.25F);
  scene.setMargin(0, 0.25F);
  Options options;
  options.nearest = true;
  const auto detector = withRadiiAndPartMargins(std::make_unique<SearchOnly>());
  EXPECT_EQ(detector->detect(scene, options).counters.rejected, 3U);
}

TEST_F(BoundedTest, AFlagEndsItToo) {
  const Scene scene = crossingCloths();
  settle(scene);
  const std::atomic<bool> stop{true};
  Options options;
  options.tolerance_m = 0.01F;
  options.limits.stop = &stop;
  const DetectionResult& result = detector_->detect(scene, options);
  EXPECT_TRUE(result.cut_off);
  EXPECT_EQ("stopped", result.cut_off_because);
}

TEST_F(BoundedTest, WithTimeEnoughTheListIsTheExactOne) {
  for (std::uint32_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    Scene scene = seed == 0 ? crossingCloths() : randomScene(seed);
    constexpr float kMargins[] = {0, 1e-3F, 0.1F, 1, 1e20F};
    for (BodyId id = 0; id < scene.bodyCount(); ++id) {
      scene.setMargin(id, kMargins[(seed + id) % 5]);
    }
    settle(scene);
    Options exactly;
    exactly.geometry = true;
    const DetectionResult& exact = exact_->detect(scene, exactly);
    Options options = withDeadline(std::chrono::seconds(60));
    options.geometry = true;
    const DetectionResult& result = detector_->detect(scene, options);
    ASSERT_FALSE(result.cut_off);
    EXPECT_TRUE(result.guaranteed);
    EXPECT_TRUE(samePairs(exact.contacts, result.contacts));
    EXPECT_TRUE(sameBits(exact.separations_m, result.separations_m));
    ASSERT_EQ(exact.geometry.size(), result.geometry.size());
    for (std::size_t i = 0; i < exact.geometry.size(); ++i) {
      EXPECT_EQ(exact.geometry[i].point_a, result.geometry[i].point_a);
      EXPECT_EQ(exact.geometry[i].separation_m, result.geometry[i].separation_m);
    }
    for (const BodyDistance& distance : result.distances) {
      EXPECT_TRUE(distance.is_listed);
      bool touch = false, near = false;
      for (std::size_t i = 0; i < exact.contacts.size(); ++i) {
        const TrianglePair& pair = exact.contacts[i];
        if (pair.body_a != distance.body_a || pair.body_b != distance.body_b) continue;
        const bool apart = !exact.separations_m.empty() && exact.separations_m[i] > 0;
        (apart ? near : touch) = true;
      }
      const PairDecision expected = touch  ? PairDecision::kContact
                                    : near ? PairDecision::kNear
                                           : PairDecision::kNone;
      EXPECT_EQ(expected, decide(distance, marginOf(scene, distance), 0));
    }
  }
}

// All results are true at any deadline. No pair of bodies is reported as farther apart than it is.
TEST_F(BoundedTest, WhateverTheDeadlineWhatIsSaidIsTrue) {
  Scene scene = pairScene(soup(1, 800, 0.3F), soup(2, 800, 0.3F));
  scene.addBody("cloth", clothGrid(40, 1, 1.35F, 0.05F));
  scene.setPairEnabled(0, 2, true);
  scene.setPairEnabled(1, 2, true);
  scene.setMargin(2, 0.005F);
  settle(scene);
  const DetectionResult& exact = exact_->detect(scene, Options());
  std::vector<std::vector<Triangle>> triangles;
  for (const Body& body : scene.bodies()) triangles.push_back(finiteTriangles(body));
  std::map<std::pair<BodyId, BodyId>, double> truth;
  for (const auto& [a, b] : scene.enabledPairs()) {
    truth[{a, b}] = trueDistance(triangles[a], triangles[b]);
  }
  std::size_t cut_off = 0, complete = 0;
  for (int i = 0; i < 120; ++i) {
    Options options = withDeadline(std::chrono::microseconds(3 << (i % 20)));
    options.tolerance_m = i % 3 == 0 ? 1e-3F : 0;
    const DetectionResult& result = detector_->detect(scene, options);
    EXPECT_TRUE(std::includes(exact.contacts.begin(), exact.contacts.end(), result.contacts.begin(),
                              result.contacts.end()));
    (result.cut_off ? cut_off : complete) += 1;
    for (const BodyDistance& distance : result.distances) {
      expectTrue(scene, distance, options.tolerance_m,
                 truth.at({distance.body_a, distance.body_b}));
    }
  }
  EXPECT_GT(cut_off, 20U);
  EXPECT_GT(complete, 20U);
}

}  // namespace
}  // namespace deformable_contact_monitor
