// Tests the motion that is taken off the end of the interval: boxes still hold their content, and a
// few vertices that move in another way do not matter.
#include "core/rules/common_motion.h"

#include <gtest/gtest.h>

#include <cfloat>
#include <random>

#include "core/rules/margins.h"

namespace deformable_contact_monitor {
namespace {

TEST(CommonMotion, BoxesAreRoundedOutwards) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> any(-100, 100);
  int rounded = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec3f p{any(random), any(random) * 1e-6F, any(random) * 1e6F};
    const Vec3f motion{any(random), any(random), i % 2 == 0 ? 0 : any(random)};
    const Aabb box = withoutMotion(Aabb{p, p}, motion);
    for (int k = 0; k < 3; ++k) {
      const double exact = static_cast<double>(p[k]) - motion[k];
      EXPECT_LE(box.min[k], exact);
      EXPECT_GE(box.max[k], exact);
      rounded += box.min[k] < box.max[k] ? 1 : 0;
    }
    if (motion.z == 0) {
      EXPECT_EQ(p.z, box.min.z);
      EXPECT_EQ(p.z, box.max.z);
    }
  }
  EXPECT_GT(rounded, 2000);
}

TEST(CommonMotion, BoxesThatOverlappedDoSoAtTheEndsOfFloat32) {
  const Vec3f motion{FLT_MAX, -FLT_MAX, 1};
  const Aabb a{{-FLT_MAX, FLT_MAX / 2, 0}, {-FLT_MAX / 2, FLT_MAX, 1}};
  const Aabb b{{-FLT_MAX / 2, FLT_MAX, 1}, {0, FLT_MAX, 2}};
  ASSERT_TRUE(intersects(a, b));
  const Aabb moved_a = withoutMotion(a, motion), moved_b = withoutMotion(b, motion);
  EXPECT_TRUE(intersects(moved_a, moved_b));
  EXPECT_TRUE(isFinite(moved_a.min) && isFinite(moved_a.max));
}

TEST(CommonMotion, IsThatOfMost) {
  std::vector<Vec3d> motions(60, Vec3d{21, -3, 0.5});
  for (Vec3d& m : motions) m.y += 0.01 * static_cast<double>(&m - motions.data());
  motions.resize(90, Vec3d{1e30, 1e30, -1e30});
  const Vec3f common = commonMotion(motions);
  EXPECT_EQ(21, common.x);
  EXPECT_NEAR(-2.6, common.y, 0.2);
  EXPECT_EQ(0.5F, common.z);
}

TEST(CommonMotion, IsNoneWhereNothingMovesAlike) {
  std::vector<Vec3d> none;
  EXPECT_EQ(Vec3f(), commonMotion(none));
  std::vector<Vec3d> still(5);
  EXPECT_EQ(Vec3f(), commonMotion(still));
  std::mt19937 random(2);
  std::uniform_real_distribution<double> any(-1, 1);
  std::vector<Vec3d> all_ways(500);
  for (Vec3d& m : all_ways) m = {any(random), any(random), any(random)};
  EXPECT_EQ(Vec3f(), commonMotion(all_ways));
  std::vector<Vec3d> too_far(5, Vec3d{1e39, 0, 0});
  EXPECT_EQ(Vec3f(), commonMotion(too_far));
}

TEST(PairPad, IsNotLessThanTheSum) {
  EXPECT_EQ(0, pairPad(0, 0));
  EXPECT_EQ(0.25F, pairPad(0.25F, 0));
  EXPECT_GE(pairPad(0.25F, 0.5F), 0.75F);
  EXPECT_LT(pairPad(0.25F, 0.5F), 0.7501F);
  EXPECT_GT(pairPad(1, 1e-20F), 1);
  EXPECT_EQ(FLT_MAX, pairPad(FLT_MAX, FLT_MAX));
}

}  // namespace
}  // namespace deformable_contact_monitor
