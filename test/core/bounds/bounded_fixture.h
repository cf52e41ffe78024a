// A bounded detector with its tilings, and what its distances must keep to.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "bounds_truth.h"
#include "core/body_distance.h"
#include "core/cpu_detector.h"
#include "core/detector_pool.h"
#include "core/rules/margins.h"

namespace deformable_contact_monitor {

// Makes a detector on the CPU that decides by bounds of these tilings.
inline std::unique_ptr<Detector> makeBoundedDetector(std::shared_ptr<TilingCache> tilings) {
  PoolSettings settings;
  settings.cpu = [] { return makeCpuDetector(); };
  settings.tilings = std::move(tilings);
  return makeDetectorPool(settings);
}

class BoundedTest : public ::testing::Test {
 protected:
  // Until it has the tilings of all bodies.
  void settle(const Scene& scene) {
    Options options;
    options.tolerance_m = 1;
    for (std::uint32_t i = 0; i <= TilingCache::kSettledAfter; ++i)
      detector_->detect(scene, options);
    tilings_->wait();
  }

  std::shared_ptr<TilingCache> tilings_ = std::make_shared<TilingCache>();
  std::unique_ptr<Detector> detector_ = makeBoundedDetector(tilings_);
  std::unique_ptr<Detector> exact_ = makeCpuDetector();
};

inline float marginOf(const Scene& scene, const BodyDistance& distance) {
  return pairMargin(scene.body(distance.body_a).margin_m, scene.body(distance.body_b).margin_m);
}

// That all it claims is true. `truth`: the bodies' distance, right to a part in 2^27, +inf where
// one has no triangle; or any number above `known_to`, if it is more than that.
inline void expectTrue(const Scene& scene, const BodyDistance& distance, float tolerance_m,
                       double truth, double known_to = INFINITY) {
  constexpr double kTruth = 1 + 0x1p-26;
  SCOPED_TRACE(::testing::Message()
               << "bodies " << distance.body_a << " and " << distance.body_b << ", distance "
               << truth << ", low " << distance.low_m << ", high " << distance.high_m);
  const float margin_m = marginOf(scene, distance);
  if (truth <= known_to) {
    EXPECT_LE(distance.low_m, truth * kTruth);
  }
  EXPECT_GE(distance.high_m * kTruth, std::min(truth, known_to));
  if (distance.high_m < INFINITY) {
    const PosedBody a(scene.body(distance.body_a)), b(scene.body(distance.body_b));
    EXPECT_EQ(distance.body_a, distance.witness.body_a);
    EXPECT_EQ(distance.body_b, distance.witness.body_b);
    const double own = trueDistance(a.triangle(distance.witness.triangle_a),
                                    b.triangle(distance.witness.triangle_b));
    EXPECT_LE(own, distance.high_m * kTruth);
    EXPECT_EQ(own == 0, distance.high_m == 0);
  }
  switch (decide(distance, margin_m, tolerance_m)) {
    case PairDecision::kNone:
      EXPECT_GT(truth, margin_m);
      break;
    case PairDecision::kNear:
      EXPECT_GT(truth, 0);
      EXPECT_LE(std::min(truth, known_to),
                (static_cast<double>(margin_m) + tolerance_m) * (1 + 1e-6));
      break;
    case PairDecision::kContact:
      EXPECT_LE(std::min(truth, known_to), tolerance_m * kTruth);
      break;
    case PairDecision::kOpen:
      break;
  }
}

}  // namespace deformable_contact_monitor
