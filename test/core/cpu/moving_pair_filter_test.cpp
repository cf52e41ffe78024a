// The CPU's filters of moving pairs in vector lanes never contradict the exact verdict.
// $DCM_FUZZ_PAIRS says how many pairs of each class.
#include "core/cpu/moving_pair_filter.h"

#include <gtest/gtest.h>

#include <cfloat>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include "core/cpu/sort.h"
#include "core/predicates/swept_exact.h"
#include "moving_pairs.h"

namespace deformable_contact_monitor {
namespace {

std::size_t pairsWanted() {
  const char* wanted = std::getenv("DCM_FUZZ_PAIRS");
  return wanted != nullptr ? std::strtoul(wanted, nullptr, 10) : 1000;
}

std::vector<SweptVerdict> exactVerdicts(const std::vector<MovingPair>& pairs) {
  std::vector<SweptVerdict> verdicts;
  for (const MovingPair& pair : pairs) {
    PredicateState state;
    verdicts.push_back(sweptVerdict(pair.a, pair.b, {}, AdjacentPairs::kSkip, true, state));
  }
  return verdicts;
}

// A class's pairs, those that share a vertex by chance left out.
std::vector<MovingPair> pairsOf(const MovingPairClass& what, std::size_t count) {
  MotionDice dice(static_cast<unsigned>(count));
  std::vector<MovingPair> pairs;
  while (pairs.size() < count) {
    const MovingPair pair = what.make(&dice);
    if (!sharedTrajectories(pair.a, pair.b).any) pairs.push_back(pair);
  }
  return pairs;
}

enum class Outcome { kApart, kMeet, kOpen };

std::vector<Outcome> filtered(const std::vector<MovingPair>& pairs, unsigned filters,
                              bool wants_time) {
  std::vector<MovingTriangles> refs;
  for (const MovingPair& pair : pairs) refs.push_back({&pair.a, &pair.b});
  MovingPairFilter filter(filters);
  filter.filter(refs, wants_time);
  std::vector<Outcome> crossings(pairs.size(), Outcome::kApart);
  for (const std::uint32_t i : filter.meeting()) crossings[i] = Outcome::kMeet;
  for (const std::uint32_t i : filter.open()) {
    EXPECT_EQ(crossings[i], Outcome::kApart) << "crossings twice";
    crossings[i] = Outcome::kOpen;
  }
  return crossings;
}

struct Count {
  std::size_t apart = 0, meet = 0, open = 0;
};

Count expectNoContradiction(const std::vector<MovingPair>& pairs,
                            const std::vector<SweptVerdict>& exact, unsigned filters) {
  Count count;
  const std::vector<Outcome> any = filtered(pairs, filters, false);
  const std::vector<Outcome> first = filtered(pairs, filters, true);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    SCOPED_TRACE("pair " + std::to_string(i) + ", filters " + std::to_string(filters));
    const bool contact = exact[i].part == PartVerdict::kMeet;
    count.apart += any[i] == Outcome::kApart ? 1 : 0;
    count.meet += any[i] == Outcome::kMeet ? 1 : 0;
    count.open += any[i] == Outcome::kOpen ? 1 : 0;
    EXPECT_TRUE(any[i] == Outcome::kOpen || (any[i] == Outcome::kMeet) == contact);
    EXPECT_FALSE(first[i] == Outcome::kApart && contact);
    if (first[i] == Outcome::kMeet) {
      EXPECT_TRUE(contact);
      EXPECT_EQ(exact[i].first_high, 0);
    }
  }
  return count;
}

class LaneScreenTest : public testing::TestWithParam<MovingPairClass> {};

TEST_P(LaneScreenTest, EachFilterAloneAndAllNeverContradictTheVerdict) {
  const std::vector<MovingPair> pairs = pairsOf(GetParam(), pairsWanted());
  const std::vector<SweptVerdict> exact = exactVerdicts(pairs);
  for (const unsigned filters : {kFilterPlanes, kFilterEnds, kFilterPieces}) {
    const Count count = expectNoContradiction(pairs, exact, filters);
    if (std::string(GetParam().name) != "off_the_grid") continue;
    EXPECT_EQ(count.apart > 0, filters != kFilterEnds);
    EXPECT_EQ(count.meet > 0, filters != kFilterPlanes);
  }
  const Count count = expectNoContradiction(pairs, exact, kAllMovingFilters);
  if (std::string(GetParam().name) == "off_the_grid") {
    EXPECT_LT(count.open, pairs.size() / 20);
  }
}

// An affine map of all places keeps contacts that just touch, and fills mantissas so that products
// are rounded.
TEST_P(LaneScreenTest, NorWhereTheyTouchAndProductsAreRounded) {
  const float rows[3][3] = {{20011, 313, -1021}, {-707, 15013, 2003}, {1511, -911, 17011}};
  std::vector<MovingPair> pairs;
  for (MovingPair pair : pairsOf(GetParam(), pairsWanted())) {
    bool fits = true;
    for (MovingTriangle* t : {&pair.a, &pair.b}) {
      for (Triangle* state : {&t->from, &t->to}) {
        for (Vec3f& v : state->v) {
          const Vec3f p = v;
          float* const x[3] = {&v.x, &v.y, &v.z};
          for (int k = 0; k < 3; ++k) {
            *x[k] = rows[k][0] * p.x + rows[k][1] * p.y + rows[k][2] * p.z;
            fits = fits && std::fabs(*x[k]) < 1 << 24;
          }
        }
      }
    }
    if (fits) pairs.push_back(pair);
  }
  const std::vector<SweptVerdict> exact = exactVerdicts(pairs);
  for (const unsigned filters : {kFilterPlanes, kFilterEnds, kFilterPieces}) {
    expectNoContradiction(pairs, exact, filters);
  }
}

// Far from 1 rounding is the same, until numbers become denormal or infinite.
TEST_P(LaneScreenTest, NorAtTheExtremes) {
  std::vector<MovingPair> pairs = pairsOf(GetParam(), pairsWanted() / 10);
  for (const int power : {-149, -145, -130, -75, -45, 40, 60, 100, 115}) {
    std::vector<MovingPair> extreme;
    for (const MovingPair& pair : pairs) {
      const MovingPair changed = scaled(pair, power);
      if (isFinite(changed.a) && isFinite(changed.b)) extreme.push_back(changed);
    }
    const std::vector<SweptVerdict> exact = exactVerdicts(extreme);
    EXPECT_TRUE(power >= 100 || !extreme.empty());
    for (const unsigned filters : {kFilterPlanes, kFilterEnds, kFilterPieces}) {
      expectNoContradiction(extreme, exact, filters);
    }
  }
}

const auto kName = [](const testing::TestParamInfo<MovingPairClass>& info) {
  return std::string(info.param.name);
};
INSTANTIATE_TEST_SUITE_P(Moving, LaneScreenTest, testing::ValuesIn(movingPairClasses()), kName);

// Each coordinate of each vertex of its own size, from the least denormal to the largest number.
TEST(LaneScreenExtremes, SizesFarApart) {
  MotionDice dice(5);
  const auto size = [&dice] {
    const float of[] = {0, 1.4e-45F, 1e-40F, 1e-38F, 1e-30F, 1e-19F, 1, 1e19F, 1e30F, FLT_MAX};
    return of[dice.within(0, 9)] * static_cast<float>(dice.within(-4, 4)) / 4;
  };
  std::vector<MovingPair> pairs(pairsWanted());
  for (MovingPair& pair : pairs) {
    const bool by_axis = dice.half();
    const Vec3f scale{size(), size(), size()};
    for (MovingTriangle* t : {&pair.a, &pair.b}) {
      for (Triangle* state : {&t->from, &t->to}) {
        for (Vec3f& v : state->v) {
          const Vec3f p = dice.point(9) * 0.125F;
          v = by_axis ? Vec3f{scale.x * p.x, scale.y * p.y, scale.z * p.z}
                      : Vec3f{size(), size(), size()};
          for (float* x : {&v.x, &v.y, &v.z}) *x = std::fmax(-FLT_MAX, std::fmin(FLT_MAX, *x));
        }
      }
    }
  }
  const std::vector<SweptVerdict> exact = exactVerdicts(pairs);
  for (const unsigned filters : {kFilterPlanes, kFilterEnds, kFilterPieces, kAllMovingFilters}) {
    expectNoContradiction(pairs, exact, filters);
  }
}

// The filters are asked of finite vertices; of others they tell nothing.
TEST(LaneScreenExtremes, NothingIsCertainOfInfinityAndNaN) {
  const std::vector<MovingPair> pairs = pairsOf(movingPairClasses()[3], 200);
  std::vector<MovingPair> changed;
  for (const float odd : {std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity(), std::nanf("")}) {
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      MovingPair pair = pairs[i];
      MovingTriangle& t = i % 2 == 0 ? pair.a : pair.b;
      Vec3f& v = (i % 4 < 2 ? t.from : t.to).v[i % 3];
      (i % 5 == 0 ? v.x : i % 5 < 3 ? v.y : v.z) = odd;
      changed.push_back(pair);
    }
  }
  for (const unsigned filters : {kFilterPlanes, kFilterEnds, kFilterPieces, kAllMovingFilters}) {
    for (const Outcome crossings : filtered(changed, filters, false))
      EXPECT_EQ(crossings, Outcome::kOpen) << filters;
  }
}

TEST(LaneScreenLanes, APairsPlaceAmongOthersChangesNothing) {
  const std::vector<MovingPair> pairs = pairsOf(movingPairClasses()[3], 61);
  const std::vector<Outcome> together = filtered(pairs, kAllMovingFilters, false);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    EXPECT_EQ(filtered({pairs[i]}, kAllMovingFilters, false)[0], together[i]) << i;
  }
  EXPECT_TRUE(filtered({}, kAllMovingFilters, false).empty());
}

TEST(LaneScreenLanes, BoxesMeetAsMovingBoxesDo) {
  std::size_t apart = 0;
  for (const MovingPairClass& what : movingPairClasses()) {
    for (const MovingPair& pair : pairsOf(what, 500)) {
      const MovingBox a = boxOf(pair.a), b = boxOf(pair.b);
      EXPECT_EQ(intersects(LaneMovingBox(a), LaneMovingBox(b)), !areApart(a, b)) << what.name;
      apart += areApart(a, b) ? 1 : 0;
    }
  }
  EXPECT_GT(apart, 100U);
}

}  // namespace
}  // namespace deformable_contact_monitor
