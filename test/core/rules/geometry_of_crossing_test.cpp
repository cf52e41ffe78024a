// The short rule for proper crossings against the general one, and determinants by integers against
// exact sums: the same bits.
#include "core/rules/geometry_of_crossing.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "core/rules/geometry_of_pair.h"
#include "geometry_pairs.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kBytes = offsetof(PairGeometry, flags) + sizeof(PairGeometry::flags);

// Returns whether the short rule settled the pair.
bool expectSameBits(const TrianglesPair& pair) {
  PairGeometry geometry;
  if (!crossingGeometryOf(pair.a, pair.b, geometry)) return false;
  const PairGeometry expected = generalGeometryOf(pair.a, pair.b, 0);
  EXPECT_EQ(0, std::memcmp(&expected, &geometry, kBytes))
      << describe(expected) << " and " << describe(geometry);
  return true;
}

class GeometryOfCrossing : public PairClassSuite {};

TEST_P(GeometryOfCrossing, HasTheGeneralRulesBits) {
  forPairs(1, [&](const TrianglesPair& pair) {
    expectSameBits(pair);
    expectSameBits({pair.b, pair.a});
  });
}

INSTANTIATE_TEST_SUITE_P(, GeometryOfCrossing, testing::ValuesIn(geometryPairClasses()),
                         pairClassName);

// Nearly all contacts of random triangles are settled.
TEST(GeometryOfCrossings, AreSettledWhereTheyAreOrdinary) {
  GridDice dice(3);
  int contacts = 0, settled = 0;
  for (int i = 0; i < 20000; ++i) {
    const TrianglesPair pair{realTriangle(&dice, 1), realTriangle(&dice, 1)};
    if (!meet(pair)) continue;
    ++contacts;
    settled += expectSameBits(pair) ? 1 : 0;
  }
  EXPECT_GT(contacts, 2000);
  EXPECT_GT(settled, contacts * 99 / 100);
}

// Pairs that are nearly or exactly in one plane, or share vertices: these are left to the general
// rule, and near that limit nothing is settled wrongly.
TEST(GeometryOfCrossings, MayBeNearlyFlatOrShareVertices) {
  GridDice dice(5);
  int settled = 0;
  for (int i = 0; i < 60000; ++i) {
    TrianglesPair pair{realTriangle(&dice, 1), realTriangle(&dice, 1)};
    const float thick = std::ldexp(1.0F, -dice.within(0, 28));
    for (Triangle* const t : {&pair.a, &pair.b}) {
      for (Vec3f& v : t->v) v.z = 0.25F * v.x - 0.5F * v.y + thick * v.z;
    }
    if (dice.within(0, 3) == 0) pair.b.v[dice.within(0, 2)] = pair.a.v[dice.within(0, 2)];
    settled += expectSameBits(pair) ? 1 : 0;
  }
  EXPECT_GT(settled, 2000);
}

// Returns det[p1 - p0; p2 - p0; p3 - p0].
Expansion<48> exactSum(const Vec3f p[4]) {
  Expansion<48> sum;
  double sign = 1;
  for (const auto& of : {std::array<int, 3>{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}}) {
    detail::addDeterminant(sum, toDouble(p[of[0]]), toDouble(p[of[1]]), toDouble(p[of[2]]), sign);
    sign = -sign;
  }
  return sum;
}

TEST(DeterminantByIntegers, HasTheBitsOfTheSum) {
  GridDice dice(7);
  int by_integers = 0, long_ones = 0;
  for (int i = 0; i < 60000; ++i) {
    const float thick = std::ldexp(1.0F, -dice.within(0, 40));
    const int spread = dice.within(0, 14);
    Vec3f p[4];
    for (Vec3f& v : p) {
      v = realPoint(&dice, std::ldexp(1.0F, dice.within(0, spread)));
      v.z = 0.3F * v.x + 0.7F * v.y + thick * v.z;
    }
    double value = 0;
    if (!detail::determinantByIntegers(p[0], p[1], p[0], p[2], p[0], p[3], value)) continue;
    ++by_integers;
    const double sum = detail::exactVolume(p[0], p[1], p[2], p[3]);
    ASSERT_EQ(0, std::memcmp(&sum, &value, sizeof sum)) << sum << " and " << value;
    long_ones += exactSum(p).size() > 1 ? 1 : 0;
    const Triangle t{{p[0], p[1], p[2]}};
    const Vec3f q = realPoint(&dice, 1);
    if (!detail::determinantByIntegers(p[0], p[1], p[0], p[2], p[3], q, value)) continue;
    const double rise = detail::expandedRise(t, p[3], q);
    ASSERT_EQ(0, std::memcmp(&rise, &value, sizeof rise)) << rise << " and " << value;
  }
  EXPECT_GT(by_integers, 50000);
  EXPECT_GT(long_ones, 5000);
}

TEST(DeterminantByIntegers, IsZeroInOnePlane) {
  const Vec3f a{0, 0, 0.5F}, b{1, 0, 1}, c{0, 1, 0.75F}, d{1, 1, 1.25F};
  double value = 1;
#if DCM_INT128
  EXPECT_TRUE(detail::determinantByIntegers(a, b, a, c, a, d, value));
  EXPECT_EQ(0, value);
#endif
  EXPECT_EQ(0, detail::exactVolume(a, b, c, d));
}

}  // namespace
}  // namespace deformable_contact_monitor
