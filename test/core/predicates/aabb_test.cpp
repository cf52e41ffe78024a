// Boxes: closed, grown outwards, and empty ones that stay empty.
#include "core/predicates/aabb.h"

#include <gtest/gtest.h>

#include <cfloat>
#include <cmath>

namespace deformable_contact_monitor {
namespace {

TEST(Aabb, TouchingBoxesOverlapAndEmptyOnesNever) {
  const Aabb unit{{0, 0, 0}, {1, 1, 1}};
  EXPECT_TRUE(intersects(unit, Aabb{{1, 1, 1}, {2, 2, 2}}));
  EXPECT_FALSE(intersects(unit, Aabb{{std::nextafter(1.0F, 2.0F), 0, 0}, {2, 2, 2}}));
  EXPECT_FALSE(intersects(unit, Aabb()));
  EXPECT_FALSE(intersects(Aabb(), Aabb()));
}

TEST(Aabb, AnEmptyBoxAddsNothing) {
  Aabb box;
  box.include(Aabb());
  EXPECT_TRUE(box.empty());
  box.include(Vec3f{1, 2, 3});
  box.include(Aabb());
  EXPECT_EQ(box.min, (Vec3f{1, 2, 3}));
  EXPECT_EQ(box.max, (Vec3f{1, 2, 3}));
}

TEST(Aabb, InflatedIsRoundedOutwards) {
  const Aabb box{{1, -1, 1e30F}, {1, 1, 1e30F}};
  const Aabb grown = inflated(box, 1e-9F);
  EXPECT_LT(grown.min.x, 1.0F);
  EXPECT_GT(grown.max.x, 1.0F);
  EXPECT_LT(grown.min.z, 1e30F);
  EXPECT_EQ(inflated(box, 0).min, box.min);
}

TEST(Aabb, InflatedEndsAtTheLargestNumber) {
  const Aabb grown = inflated(Aabb{{-3e38F, 0, 3e38F}, {-3e38F, 0, 3e38F}}, 3e38F);
  EXPECT_EQ(grown.min.x, -FLT_MAX);
  EXPECT_LT(grown.max.x, FLT_MAX);
  EXPECT_EQ(grown.max.z, FLT_MAX);
  EXPECT_TRUE(intersects(inflated(Aabb{{FLT_MAX, 0, 0}, {FLT_MAX, 0, 0}}, FLT_MAX),
                         inflated(Aabb{{-FLT_MAX, 0, 0}, {-FLT_MAX, 0, 0}}, FLT_MAX)));
}

TEST(Aabb, ApartIsDecidedInRealNumbers) {
  const auto at = [](float x) { return Aabb{{x, 0, 0}, {x, 0, 0}}; };
  EXPECT_FALSE(areApart(at(0), at(1), 1));
  EXPECT_TRUE(areApart(at(0), at(std::nextafter(1.0F, 2.0F)), 1));
  EXPECT_TRUE(areApart(at(1e-20F), at(-1), 1)) << "1 + 1e-20";
  EXPECT_FALSE(areApart(at(-1e-20F), at(-1), 1));
  EXPECT_FALSE(areApart(at(-FLT_MAX), at(0), FLT_MAX));
  EXPECT_TRUE(areApart(at(-FLT_MAX), at(1e-45F), FLT_MAX));
  EXPECT_TRUE(areApart(at(-1e-45F), at(1e-45F), 1e-45F));
  EXPECT_FALSE(areApart(Aabb{{0, 0, 0}, {9, 9, 9}}, at(3), 0));
}

TEST(Aabb, GapsAddUp) {
  const Aabb unit{{0, 0, 0}, {1, 1, 1}};
  EXPECT_EQ(squaredGap(unit, Aabb{{3, 4, 0.5F}, {5, 5, 5}}), 4 + 9);
  EXPECT_EQ(squaredGap(Aabb{{3, 4, 0.5F}, {5, 5, 5}}, unit), 4 + 9);
  EXPECT_EQ(squaredGap(unit, unit), 0);
}

}  // namespace
}  // namespace deformable_contact_monitor
