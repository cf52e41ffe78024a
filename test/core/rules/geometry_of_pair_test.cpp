// Properties that the geometry of any pair must have.
#include "core/rules/geometry_of_pair.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "geometry_pairs.h"

namespace deformable_contact_monitor {
namespace {

bool isFiniteGeometry(const PairGeometry& g) {
  return isFinite(g.point_a) && isFinite(g.point_b) && isFinite(g.normal) &&
         std::isfinite(g.separation_m);
}

class GeometryOfPair : public PairClassSuite {};

// The verdict alone decides the sign. No number is NaN or infinite.
TEST_P(GeometryOfPair, SeparationIsAboveZeroIffTheyAreApart) {
  long contacts = 0, apart = 0;
  forPairs(1, [&](const TrianglesPair& pair) {
    const bool contact = meet(pair);
    const PairGeometry g = geometryOf(pair.a, pair.b, 0);
    (contact ? contacts : apart) += 1;
    ASSERT_EQ(contact, g.separation_m <= 0) << describe(g);
    ASSERT_TRUE(isFiniteGeometry(g)) << describe(g);
    const float length = lengthOf(g.normal);
    if ((g.flags & kNormalUndefined) != 0) {
      ASSERT_EQ(0, length);
    } else {
      ASSERT_NEAR(1, length, 1e-6) << describe(g);
    }
    ASSERT_EQ(detail::hasArea(pair.a) && detail::hasArea(pair.b), (g.flags & kDegenerate) == 0);
    if ((g.flags & kCoplanar) != 0) {
      ASSERT_EQ(0, g.separation_m);
    }
    if (contact) return;
    const float given = 3;
    ASSERT_EQ(given, geometryOf(pair.a, pair.b, given).separation_m);
  });
  EXPECT_GT(contacts, 30);
  EXPECT_GT(contacts + apart, 1000);
}

TEST_P(GeometryOfPair, SwappingNegatesTheNormal) {
  forPairs(1, [&](const TrianglesPair& pair) {
    if (std::equal(pair.a.v, pair.a.v + 3, pair.b.v)) return;  // there is nothing to swap
    const bool contact = meet(pair);
    const PairGeometry g = geometryOf(pair.a, pair.b, 0);
    const PairGeometry swapped = geometryOf(pair.b, pair.a, 0);
    ASSERT_EQ(g.normal, swapped.normal * -1) << describe(g) << describe(swapped);
    ASSERT_EQ(0, std::memcmp(&g.separation_m, &swapped.separation_m, sizeof(float)));
    ASSERT_EQ(g.flags, swapped.flags);
    ASSERT_EQ(g.point_a, contact ? swapped.point_a : swapped.point_b);
    ASSERT_EQ(g.point_b, contact ? swapped.point_b : swapped.point_a);
  });
}

// Moved by that and a little more, they are apart; by a little less, they touch: in floats, so on
// pairs whose depth is far above their rounding.
TEST_P(GeometryOfPair, PartsThem) {
  long parted = 0;
  forPairs(4, [&](const TrianglesPair& pair) {
    if (!meet(pair)) return;
    const PairGeometry g = geometryOf(pair.a, pair.b, 0);
    const double depth = -double{g.separation_m}, size = sizeOf(pair.a) + sizeOf(pair.b);
    if (depth < 1e-4 * size || size < 1e-25) return;
    const auto moved = [&](double by) {
      TrianglesPair away = pair;
      for (Vec3f& v : away.b.v) v = toFloat(toDouble(v) + toDouble(g.normal) * by);
      return away;
    };
    ++parted;
    ASSERT_FALSE(meet(moved(depth + 1e-6 * size))) << describe(g);
    ASSERT_TRUE(meet(moved(depth - 1e-6 * size))) << describe(g);
  });
}

INSTANTIATE_TEST_SUITE_P(, GeometryOfPair, testing::ValuesIn(geometryPairClasses()), pairClassName);

}  // namespace
}  // namespace deformable_contact_monitor
