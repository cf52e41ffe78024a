// Nearest pairs in detection within bounds: with a deadline, with a tolerance, and with tiles by
// surface.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "bounded_fixture.h"
#include "in_child.h"
#include "nearest_fixture.h"
#include "random_scenes.h"

namespace deformable_contact_monitor {
namespace {

class NearestInBounds : public BoundedTest {
 protected:
  static Options inTime(std::chrono::steady_clock::duration time) {
    Options options = withNearest();
    options.limits.deadline = std::chrono::steady_clock::now() + time;
    return options;
  }

  // The pairs that are in `all` are a part of it, bit by bit.
  static void expectPartOf(const std::vector<NearestPair>& all,
                           const std::vector<NearestPair>& part) {
    for (const NearestPair& pair : part) {
      EXPECT_NE(all.end(), std::find(all.begin(), all.end(), pair)) << pair;
    }
    EXPECT_TRUE(std::is_sorted(part.begin(), part.end(), [](const auto& x, const auto& y) {
      return std::pair(x.pair.body_a, x.pair.body_b) < std::pair(y.pair.body_a, y.pair.body_b);
    }));
  }

  std::unique_ptr<Detector> brute_force_ = makeBruteForceDetector();
};

Scene randomSceneWithMargins(std::uint32_t seed) {
  static constexpr float kMargins[] = {0, 1e-3F, 0.1F, 1, 10, 1e20F};
  Scene scene = randomScene(seed);
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    scene.setMargin(id, kMargins[(3 * seed + id) % 6]);
  }
  return scene;
}

TEST_F(NearestInBounds, WithTimeEnoughItIsThatOfBruteForce) {
  std::size_t near = 0, touching = 0;
  for (std::uint32_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    const Scene scene = randomSceneWithMargins(seed);
    settle(scene);
    for (const bool near_pairs : {false, true}) {
      Options options = inTime(std::chrono::seconds(60));
      options.near_pairs = near_pairs;
      const DetectionResult exact = brute_force_->detect(scene, options);
      const DetectionResult& result = detector_->detect(scene, options);
      ASSERT_FALSE(result.cut_off);
      EXPECT_TRUE(samePairs(exact.contacts, result.contacts));
      EXPECT_TRUE(sameBits(exact.separations_m, result.separations_m));
      EXPECT_EQ(exact.nearest, result.nearest);
      for (const BodyDistance& distance : result.distances) {
        EXPECT_TRUE(distance.is_exact);
        EXPECT_TRUE(distance.is_listed);
        const auto found = std::find_if(exact.nearest.begin(), exact.nearest.end(), [&](auto& n) {
          return n.pair.body_a == distance.body_a && n.pair.body_b == distance.body_b;
        });
        const PairDecision decision = decide(distance, scene, 0);
        if (found == exact.nearest.end()) {
          EXPECT_EQ(PairDecision::kNone, decision);
          continue;
        }
        EXPECT_EQ(found->pair, distance.witness);
        EXPECT_EQ(found->distance_m > 0 ? PairDecision::kNear : PairDecision::kContact, decision);
        ++(found->distance_m > 0 ? near : touching);
      }
    }
  }
  EXPECT_GT(near, 50U);
  EXPECT_GT(touching, 50U);
}

// Cloths that cross, that are some way apart, and one far away.
Scene threeCloths() {
  Scene scene = pairScene(clothGrid(40, 1, 0, 0.05F), clothGrid(37, 1, 0.2F, 0.08F));
  scene.addBody("crossing", clothGrid(30, 1, 0.01F, 0.08F));
  scene.addBody("far", clothGrid(5, 1, 3, 0));
  for (const auto& [a, b] : {std::pair(0U, 2U), std::pair(0U, 3U), std::pair(1U, 2U)}) {
    scene.setPairEnabled(a, b, true);
  }
  scene.setPairEnabled(0, 0, true);
  scene.setMargin(0, 10);
  scene.setMargin(1, 0.15F);
  return scene;
}

TEST_F(NearestInBounds, WhateverTheDeadlineWhatIsThereIsExact) {
  Scene scene = threeCloths();
  const std::vector<NearestPair> expected = brute_force_->detect(scene, withNearest()).nearest;
  ASSERT_EQ(4U, expected.size());
  scene.setMargin(0, 0);  // a list of all pairs within 10 m takes long
  settle(scene);
  scene.setMargin(0, 10);
  // Deadlines from far too early to late, whatever the build and the machine.
  const auto before = std::chrono::steady_clock::now();
  EXPECT_EQ(detector_->detect(scene, inTime(std::chrono::minutes(10))).nearest, expected);
  const auto whole = std::chrono::steady_clock::now() - before;
  std::size_t cut_off = 0, complete = 0;
  for (int i = 0; i < 80; ++i) {
    const Options options = inTime(whole * (1 << (i % 20)) / (1 << 15));
    const DetectionResult& result = detector_->detect(scene, options);
    expectPartOf(expected, result.nearest);
    EXPECT_TRUE(result.cut_off || result.nearest == expected);
    (result.cut_off ? cut_off : complete) += 1;
    const DetectionResult& by_exact = exact_->detect(scene, inTime(std::chrono::microseconds(i)));
    expectPartOf(expected, by_exact.nearest);
    EXPECT_TRUE(by_exact.cut_off || by_exact.nearest == expected);
  }
  EXPECT_GT(cut_off, 10U);
  EXPECT_GT(complete, 10U);
  const DetectionResult& late = detector_->detect(scene, inTime(-std::chrono::seconds(1)));
  EXPECT_TRUE(late.nearest.empty());
  EXPECT_TRUE(late.isOutOfTime());
}

TEST_F(NearestInBounds, WithAToleranceItHasWhatIsExact) {
  std::size_t listed = 0;
  for (std::uint32_t seed = 0; seed < 150; ++seed) {
    SCOPED_TRACE(seed);
    const Scene scene = randomSceneWithMargins(seed);
    const std::vector<NearestPair> expected = brute_force_->detect(scene, withNearest()).nearest;
    std::vector<std::vector<Triangle>> triangles;
    for (const Body& body : scene.bodies()) triangles.push_back(finiteTriangles(body));
    settle(scene);
    for (const float tolerance_m : {1e-6F, 0.01F, 1.0F}) {
      Options options = withNearest();
      options.tolerance_m = tolerance_m;
      const DetectionResult& result = detector_->detect(scene, options);
      expectPartOf(expected, result.nearest);
      EXPECT_FALSE(result.cut_off);
      listed += result.nearest.size();
      for (const BodyDistance& distance : result.distances) {
        EXPECT_NE(PairDecision::kOpen, decide(distance, scene, tolerance_m));
        expectTrue(scene, distance, tolerance_m,
                   trueDistance(triangles[distance.body_a], triangles[distance.body_b]));
      }
    }
  }
  EXPECT_GT(listed, 30U);
}

// A body whose triangles change in each cycle has no tiling, so its pairs go to the exact detector.
TEST_F(NearestInBounds, PairsWithoutTilingsAreThoseOfBruteForceToo) {
  Scene scene = threeCloths();
  scene.setMargin(0, 0);
  settle(scene);
  scene.setMargin(0, 10);
  for (int i = 0; i < 6; ++i) {
    SCOPED_TRACE(i);
    scene.setMesh(2, clothGrid(10 + i, 1, 0.01F + 0.05F * static_cast<float>(i % 3), 0.08F));
    const Options options = inTime(std::chrono::seconds(60));
    const std::vector<NearestPair> expected = brute_force_->detect(scene, options).nearest;
    EXPECT_EQ(4U, expected.size());
    const DetectionResult& result = detector_->detect(scene, options);
    EXPECT_EQ(expected, result.nearest);
    ASSERT_EQ(4U, result.distances.size());
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_TRUE(result.distances[k].is_exact);
      EXPECT_EQ(expected[k].pair, result.distances[k].witness);
      EXPECT_EQ(expected[k].distance_m > 0 ? PairDecision::kNear : PairDecision::kContact,
                decide(result.distances[k], scene, 0));
    }
  }
}

// Bodies of many regions, whose tiles by surface are there at once, on several threads.
TEST_F(NearestInBounds, IsTheSameByTilesOfEitherKindOnAnyNumberOfThreads) {
  CpuSettings settings;
  settings.tilings = std::make_shared<TilingCache>();
  const auto tiled = makeCpuDetector(settings);
  for (int i = 0; i < 2; ++i) {
    SCOPED_TRACE(i);
    Scene scene = threeCloths();
    if (i % 2 == 1) scene.setMesh(0, shuffled(scene.body(0).mesh, 1));
    for (int cycle = 0; cycle < 7; ++cycle) {
      turn(scene, 10 * i + cycle);
      roughen(scene, 1, static_cast<std::uint32_t>(cycle));
      Options options = withNearest();
      options.threads = 1 + cycle % 4;
      const std::vector<NearestPair> expected = brute_force_->detect(scene, options).nearest;
      EXPECT_EQ(expected, tiled->detect(scene, options).nearest);
      EXPECT_EQ(expected, makeCpuDetector()->detect(scene, options).nearest);
      settings.tilings->wait();
    }
  }
}

TEST_F(NearestInBounds, IsExactForBodiesOfManyTilesAlmostTied) {
  CpuSettings settings;
  settings.tilings = std::make_shared<TilingCache>();
  const auto tiled = makeCpuDetector(settings);
  for (std::uint32_t seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE(seed);
    Scene scene = within(1, almostTied(seed, 40));
    if (seed % 2 == 1) turn(scene, static_cast<int>(seed));
    for (std::uint32_t cycle = 0; cycle < 8; ++cycle) {
      if (cycle >= TilingCache::kSettledAfter) roughen(scene, 1, 10 * seed + cycle);
      const DetectionResult& found = tiled->detect(scene, withNearest());
      settings.tilings->wait();
      if (cycle < TilingCache::kSettledAfter) continue;
      EXPECT_EQ(brute_force_->detect(scene, withNearest()).nearest, found.nearest);
    }
  }
}

TEST_F(NearestInBounds, WorksInAForkedProcess) {
  const Scene scene = threeCloths();
  const auto cpu = makeCpuDetector();
  std::vector<NearestPair> expected;
  for (int i = 0; i < 8; ++i) expected = cpu->detect(scene, withNearest()).nearest;
  EXPECT_EQ(4U, expected.size());
  EXPECT_EQ(0, inChild([&] {
              for (int i = 0; i < 8; ++i) {
                if (cpu->detect(scene, withNearest()).nearest != expected) return false;
              }
              return makeCpuDetector()->detect(scene, withNearest()).nearest == expected;
            }));
  EXPECT_EQ(expected, cpu->detect(scene, withNearest()).nearest);
}

}  // namespace
}  // namespace deformable_contact_monitor
