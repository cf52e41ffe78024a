// Random pairs of moving triangles, by classes, against the exact oracle: verdicts and first times,
// every filter left out in turn, and what must not change them. $DCM_FUZZ_PAIRS says how many of
// each class.
#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>
#include <string>

#include "core/predicates/swept_exact.h"
#include "moving_pairs.h"
#include "swept/swept_oracle.h"

namespace deformable_contact_monitor {
namespace {

long pairsWanted() {
  const char* wanted = std::getenv("DCM_FUZZ_PAIRS");
  return wanted != nullptr ? std::atol(wanted) : 100;
}

// Triangles of one body.
template <unsigned kFilters = kAllSweptFilters>
SweptVerdict verdictOf(const MovingPair& pair, bool wants_time,
                       Predicates mode = Predicates::kExact) {
  PredicateState state;
  state.mode = mode;
  return sweptVerdict<kFilters>(pair.a, pair.b, sharedTrajectories(pair.a, pair.b),
                                AdjacentPairs::kBeyondShared, wants_time, state);
}

bool isContact(const SweptVerdict& verdict) {
  EXPECT_NE(verdict.part, PartVerdict::kOpen);
  return verdict.part == PartVerdict::kMeet;
}

std::string text(const MovingPair& pair) {
  std::string all;
  for (const MovingTriangle* t : {&pair.a, &pair.b}) {
    for (const Triangle* state : {&t->from, &t->to}) {
      for (const Vec3f& v : state->v) {
        for (int k = 0; k < 3; ++k) all += std::to_string(v[k]) + (k < 2 ? " " : ", ");
      }
      all += "; ";
    }
  }
  return all;
}

class SweptPairs : public testing::TestWithParam<MovingPairClass> {
 protected:
  // Calls check(pair, oracle's first time) for the class's pairs.
  template <class Check>
  void forEachPair(const Check& check) const {
    const long count = pairsWanted();
    MotionDice dice(static_cast<unsigned>(count));
    long contacts = 0;
    for (long i = 0; i < count && !HasFatalFailure(); ++i) {
      const MovingPair pair = GetParam().make(&dice);
      const std::optional<SweptTime> time = firstSweptContact(
          pair.a.from, pair.a.to, pair.b.from, pair.b.to, AdjacentPairs::kBeyondShared);
      contacts += time.has_value() ? 1 : 0;
      SCOPED_TRACE("pair " + std::to_string(i) + ": " + text(pair));
      check(pair, time);
    }
    EXPECT_GT(contacts, 0);
  }
};

TEST_P(SweptPairs, EqualTheOracle) {
  forEachPair([](const MovingPair& pair, const std::optional<SweptTime>& time) {
    ASSERT_EQ(isContact(verdictOf(pair, false)), time.has_value());
    const MovingPair swapped{pair.b, pair.a};
    ASSERT_EQ(isContact(verdictOf(swapped, false)), time.has_value());
    const MovingPair back{reversed(pair.a), reversed(pair.b)};
    ASSERT_EQ(isContact(verdictOf(back, false)), time.has_value());
  });
}

TEST_P(SweptPairs, FirstTimesHoldTheOracles) {
  forEachPair([](const MovingPair& pair, const std::optional<SweptTime>& time) {
    const SweptVerdict verdict = verdictOf(pair, true);
    ASSERT_EQ(isContact(verdict), time.has_value());
    if (!time) return;
    ASSERT_LE(mpq_class(verdict.first_low), time->high);
    ASSERT_GE(mpq_class(verdict.first_high), time->low);
    ASSERT_LE(verdict.first_high - verdict.first_low, 1.0F / (1 << 20));
    ASSERT_EQ(verdict.first_high == 0, time->high == 0 && time->is_attained);
    if (!time->is_attained) {
      ASSERT_GT(mpq_class(verdict.first_high), time->low);
    }
  });
}

TEST_P(SweptPairs, NoFilterChangesTheVerdict) {
  forEachPair([](const MovingPair& pair, const std::optional<SweptTime>& time) {
    const bool expected = time.has_value();
    ASSERT_EQ(isContact(verdictOf<kAllSweptFilters & ~kMovingBoxes>(pair, true)), expected);
    ASSERT_EQ(isContact(verdictOf<kAllSweptFilters & ~kMovingPlanes>(pair, true)), expected);
    ASSERT_EQ(isContact(verdictOf<kAllSweptFilters & ~kFixedDirections>(pair, true)), expected);
    ASSERT_EQ(isContact(verdictOf<kAllSweptFilters & ~kFeatureBoxes>(pair, true)), expected);
    ASSERT_EQ(isContact(verdictOf<kAllSweptFilters & ~kHalving>(pair, true)), expected);
    ASSERT_EQ(isContact(verdictOf<kAllSweptFilters & ~kIntegerSigns>(pair, true)), expected);
    ASSERT_EQ(isContact(verdictOf<kAllSweptFilters & ~kTies>(pair, true)), expected);
    ASSERT_EQ(isContact(verdictOf<kAllSweptFilters & ~kShortcuts>(pair, true)), expected);
    ASSERT_EQ(isContact(verdictOf<0>(pair, false)), expected);
  });
}

TEST_P(SweptPairs, TimesAreThoseOfTheExactStepAlone) {
  forEachPair([](const MovingPair& pair, const std::optional<SweptTime>& time) {
    const SweptVerdict with = verdictOf(pair, true), without = verdictOf<0>(pair, true);
    ASSERT_EQ(isContact(without), time.has_value());
    if (!time) return;
    ASSERT_LE(mpq_class(without.first_low), time->high);
    ASSERT_GE(mpq_class(without.first_high), time->low);
    ASSERT_LE(with.first_low, without.first_high);
    ASSERT_GE(with.first_high, without.first_low);
  });
}

TEST_P(SweptPairs, ConservativeMissesNothingAndSaysWhatItGuesses) {
  forEachPair([](const MovingPair& pair, const std::optional<SweptTime>& time) {
    for (const bool wants_time : {false, true}) {
      PredicateState state;
      state.mode = Predicates::kConservative;
      const SweptVerdict verdict = sweptVerdict(pair.a, pair.b, sharedTrajectories(pair.a, pair.b),
                                                AdjacentPairs::kBeyondShared, wants_time, state);
      ASSERT_TRUE(isContact(verdict) || !time);
      ASSERT_TRUE(isContact(verdict) == time.has_value() || state.undecided);
      if (!time || !wants_time) continue;
      ASSERT_LE(mpq_class(verdict.first_low), time->high);
      if (!state.undecided) {
        ASSERT_GE(mpq_class(verdict.first_high), time->low);
      }
    }
  });
}

// Each decision of float32 is right.
TEST_P(SweptPairs, Float32IsCertainOrOpen) {
  forEachPair([](const MovingPair& pair, const std::optional<SweptTime>& time) {
    const SharedVertices shared = sharedTrajectories(pair.a, pair.b);
    PredicateState state;
    const SweptVerdict verdict =
        shared.any ? quickSweptBeyondShared<float>(pair.a, pair.b, shared, true, state)
                   : quickSweptVerdict<float>(pair.a, pair.b, true, state);
    if (verdict.part == PartVerdict::kOpen) return;
    ASSERT_EQ(isContact(verdict), time.has_value());
    if (!time) return;
    ASSERT_LE(mpq_class(verdict.first_low), time->high);
    ASSERT_GE(mpq_class(verdict.first_high), time->low);
  });
}

Vec3f turned(const Vec3f& v) { return {-v.z, v.x, v.y}; }

TEST_P(SweptPairs, ExactChangesOfTheFrameChangeNothing) {
  forEachPair([](const MovingPair& pair, const std::optional<SweptTime>& /*time*/) {
    const SweptVerdict before = verdictOf(pair, true);
    MovingPair other = pair;
    for (MovingTriangle* t : {&other.a, &other.b}) {
      for (Triangle* state : {&t->from, &t->to}) {
        *state = {{turned(state->v[1]), turned(state->v[2]), turned(state->v[0])}};
      }
    }
    ASSERT_EQ(isContact(verdictOf(other, false)), isContact(before));
    for (const int power : {-40, 30}) {
      const SweptVerdict after = verdictOf(scaled(pair, power), true);
      ASSERT_EQ(after.part, before.part);
      ASSERT_LE(after.first_low, before.first_high);
      ASSERT_GE(after.first_high, before.first_low);
    }
  });
}

TEST_P(SweptPairs, ContainTheStaticOnesAndZeroMotionEqualsThem) {
  forEachPair([](const MovingPair& pair, const std::optional<SweptTime>& time) {
    for (const bool end : {false, true}) {
      const Triangle &a = end ? pair.a.to : pair.a.from, &b = end ? pair.b.to : pair.b.from;
      const MovingPair still{{a, a}, {b, b}};
      for (const Predicates mode : {Predicates::kExact, Predicates::kConservative}) {
        PairFacts facts;
        facts.shared = sharedVertices(a, b);
        PredicateState state;
        state.mode = mode;
        const bool expected =
            isCandidate(a, b, facts) && candidateVerdict(a, b, facts, state).contact;
        const SweptVerdict verdict = verdictOf(still, true, mode);
        ASSERT_EQ(isContact(verdict), expected);
        ASSERT_EQ(verdict.first_low, 0);
        if (mode != Predicates::kExact) continue;
        ASSERT_EQ(verdict.first_high, 0);
        ASSERT_TRUE(time || !expected);
        const bool same_sharing =
            sharedVertices(a, b).any == sharedTrajectories(pair.a, pair.b).any;
        if (!end && expected && same_sharing) {
          ASSERT_EQ(verdictOf(pair, true).first_high, 0);
        }
      }
    }
  });
}

// Where the points halfway are float32 numbers.
TEST_P(SweptPairs, HalvesAddUpToTheWhole) {
  long judged = 0;
  forEachPair([&judged](const MovingPair& pair, const std::optional<SweptTime>& time) {
    MovingPair first = scaled(pair, 1), second = scaled(pair, 1);
    const MovingPair half = scaled(pair, 0);
    for (int i = 0; i < 3; ++i) {
      const auto middle = [i](const MovingTriangle& t) { return t.from.v[i] + t.to.v[i]; };
      first.a.to.v[i] = second.a.from.v[i] = middle(half.a);
      first.b.to.v[i] = second.b.from.v[i] = middle(half.b);
      for (const MovingTriangle* t : {&half.a, &half.b}) {
        for (int k = 0; k < 3; ++k) {
          const double sum = static_cast<double>(t->from.v[i][k]) + t->to.v[i][k];
          if (static_cast<double>(middle(*t)[k]) != sum) return;
        }
      }
    }
    ++judged;
    ASSERT_EQ(isContact(verdictOf(first, false)) || isContact(verdictOf(second, false)),
              time.has_value());
  });
  if (std::string(GetParam().name) != "off_the_grid") {
    EXPECT_GT(judged, 0);
  }
}

const auto kName = [](const testing::TestParamInfo<MovingPairClass>& info) {
  return std::string(info.param.name);
};
INSTANTIATE_TEST_SUITE_P(Moving, SweptPairs, testing::ValuesIn(movingPairClasses()), kName);
INSTANTIATE_TEST_SUITE_P(Sharing, SweptPairs, testing::ValuesIn(sharingPairClasses()), kName);

}  // namespace
}  // namespace deformable_contact_monitor
