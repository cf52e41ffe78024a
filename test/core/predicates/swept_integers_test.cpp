// What integers say about features of random moving triangles, at all scales, against the exact
// step. $DCM_FUZZ_PAIRS says how many pairs of each class.
#include "core/predicates/swept_integers.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "core/predicates/swept_exact.h"
#include "moving_features.h"
#include "moving_pairs.h"

namespace deformable_contact_monitor {
namespace {

long pairsWanted() {
  const char* wanted = std::getenv("DCM_FUZZ_PAIRS");
  return wanted != nullptr ? std::atol(wanted) : 300;
}

class SweptIntegers : public testing::TestWithParam<MovingPairClass> {
 protected:
  // Calls check(feature) for features that do not meet at the start.
  template <class Check>
  void forEachFeature(const Check& check) const {
    MotionDice dice(7);
    for (long i = 0; i < pairsWanted() && !HasFatalFailure(); ++i) {
      const int power = dice.within(-100, 100);
      const MovingPair pair = scaled(GetParam().make(&dice), power);
      if (!isFinite(pair.a) || !isFinite(pair.b)) continue;
      for (int f = 0; f < kFeatures; ++f) {
        const Feature feature = featureOf(pair.a, pair.b, f);
        if (!meetsAtStart(feature)) check(feature);
      }
    }
  }
};

// The exact first time lies in the interval of a tie, if the tie is the only time at which the four
// points are in one plane. Otherwise the feature meets in it, or has met before.
TEST_P(SweptIntegers, TiesAreMeetings) {
  long ties = 0, alone = 0;
  forEachFeature([&ties, &alone](const Feature& feature) {
    const bool one_root = integerSigns(feature) == IntegerSigns::kOneRoot;
    const FeatureVerdict tie = tieVerdict(feature, nullptr, 0, false, one_root);
    if (tie.part == PartVerdict::kOpen) return;
    ASSERT_EQ(tie.part, PartVerdict::kMeet);
    ++ties;
    const FirstTime exact = exactFeatureTime(feature, true);
    ASSERT_TRUE(exact.happens());
    ASSERT_LE(exact.low, tie.high);
    const FeatureVerdict timed = tieVerdict(feature, nullptr, exact.low, true, one_root);
    if (timed.part == PartVerdict::kOpen) return;
    alone += one_root ? 1 : 0;
    ASSERT_LE(timed.low, exact.high);
    ASSERT_GE(timed.high, exact.low);
    ASSERT_LE(timed.high - timed.low, kTimeWidth);
  });
  const std::string name = GetParam().name;
  if (name == "level_vertex_meets_edge" || name == "mirrored") {
    EXPECT_GT(ties, pairsWanted() / 10);
    EXPECT_GT(alone, 0);
  }
}

// A meeting that leaves out the shared vertex is one in another point.
TEST_P(SweptIntegers, TiesBeyondAVertexAreTies) {
  forEachFeature([](const Feature& feature) {
    for (const MovingPoint& vertex : feature.x) {
      const FeatureVerdict beyond = tieVerdict(feature, &vertex, 0, false, false);
      if (beyond.part == PartVerdict::kOpen) continue;
      const FeatureVerdict tie = tieVerdict(feature, nullptr, 0, false, false);
      ASSERT_EQ(tie.part, PartVerdict::kMeet);
      ASSERT_LE(tie.low, beyond.low);
    }
  });
}

TEST_P(SweptIntegers, WithoutARootFeaturesMeetAtTheEndAtMost) {
  forEachFeature([](const Feature& feature) {
    const IntegerSigns signs = integerSigns(feature);
    const FirstTime exact = exactFeatureTime(feature, true);
    if (signs == IntegerSigns::kNoRootWithin) {
      ASSERT_TRUE(!exact.happens() || exact.low == 1);
    }
    if (signs == IntegerSigns::kOneRoot && exact.happens()) {
      ASSERT_GT(exact.high, 0);
      ASSERT_LT(exact.low, 1);
    }
  });
}

INSTANTIATE_TEST_SUITE_P(Classes, SweptIntegers, testing::ValuesIn(movingPairClasses()),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace deformable_contact_monitor
