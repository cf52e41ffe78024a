// Random pairs of triangles that touch, lie in one plane or are degenerate, against the oracle: the
// narrow phase where floating point alone would guess. $DCM_FUZZ_PAIRS says how many of each class.
#include "hard_pairs.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "cgal_oracle.h"
#include "pair_verdict.h"

namespace deformable_contact_monitor {
namespace {

class HardPairs : public testing::TestWithParam<HardPairClass> {};

bool isDegenerate(const Triangle& t) {
  PredicateState state;
  return projectionAxis(t.v[0], t.v[1], t.v[2], state) < 0;
}

TEST_P(HardPairs, EqualTheOracle) {
  const char* wanted = std::getenv("DCM_FUZZ_PAIRS");
  const long count = wanted != nullptr ? std::atol(wanted) : 20000;
  GridDice dice(static_cast<unsigned>(count));
  long contacts = 0, exact = 0;
  for (long i = 0; i < count; ++i) {
    const TrianglesPair unscaled = GetParam().make(&dice);
    const TrianglesPair pair = scaledBy(unscaled, dice.within(-60, 40));
    const OracleTriangle a{pair.a.v[0], pair.a.v[1], pair.a.v[2]};
    const OracleTriangle b{pair.b.v[0], pair.b.v[1], pair.b.v[2]};
    const bool by_construction = isDegenerate(pair.a) || isDegenerate(pair.b);
    const bool expected =
        by_construction ? meetBeyondByConstruction(a, b, {}) : meetBeyondByPredicates(a, b, {});
    PredicateState state;
    const bool found = pairVerdict(pair.a, pair.b, false, AdjacentPairs::kSkip, 0, state).contact;
    ASSERT_EQ(found, expected) << "pair " << i;
    PredicateState swapped;
    ASSERT_EQ(found, pairVerdict(pair.b, pair.a, false, AdjacentPairs::kSkip, 0, swapped).contact)
        << "pair " << i;
    PredicateState conservative;
    conservative.mode = Predicates::kConservative;
    const bool safe =
        pairVerdict(pair.a, pair.b, false, AdjacentPairs::kSkip, 0, conservative).contact;
    ASSERT_TRUE(safe || !expected) << "pair " << i;
    ASSERT_TRUE(safe == expected || conservative.undecided) << "pair " << i;
    PredicateState without_filters;
    ASSERT_EQ(found, robustIntersection(pair.a, pair.b, KnownSides(), without_filters))
        << "pair " << i;
    contacts += found;
    exact += without_filters.exact > 0;
  }
  EXPECT_GT(contacts, 3 * count / 10);
  EXPECT_GT(exact, 3 * count / 10);
}

INSTANTIATE_TEST_SUITE_P(, HardPairs, testing::ValuesIn(hardPairClasses()),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace deformable_contact_monitor
