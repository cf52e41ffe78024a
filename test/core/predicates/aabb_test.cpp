// Boxes: closed, grown outwards, and empty ones that stay empty.
#include "core/predicates/aabb.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace deformable_contact_monitor
