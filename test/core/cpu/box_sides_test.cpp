// Sides of a box against boxes of triangles, grown and rounded as the detector does.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>

#include "core/cpu/body_boxes.h"

namespace deformable_contact_monitor {
namespace {

class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}

  // Any of few values, one of them or next to it, a real number, or one of any size.
  float number(float size) {
    const float few = static_cast<float>(static_cast<int>(random_() % 9) - 4) * size;
    switch (random_() % 4) {
      case 0:
        return few;
      case 1:
        return std::nextafter(few, random_() % 2 == 0 ? -INFINITY : INFINITY);
      case 2:
        return few + size * static_cast<float>(random_() % 1000) * 1e-3F;
      default:
        return std::ldexp(few, static_cast<int>(random_() % 40) - 20);
    }
  }
  float growth(float size) {
    return random_() % 3 == 0 ? 0 : std::fabs(number(random_() % 2 == 0 ? size : size * 1e-3F));
  }
  Vec3f point(float size) { return {number(size), number(size), number(size)}; }

 private:
  std::mt19937 random_;
};

Aabb boxOfTwo(const Vec3f& a, const Vec3f& b) {
  Aabb box;
  box.include(a);
  box.include(b);
  return box;
}

TEST(BoxSides, InCommonMeanThatTheBoxIsMissed) {
  Dice dice(1);
  int common = 0, missed = 0;
  for (int i = 0; i < 400000; ++i) {
    const float size = i % 16 == 0 ? 4e37F : std::ldexp(1.0F, i % 200 - 140);
    const Aabb box = boxOfTwo(dice.point(size), dice.point(size));
    const float growth = dice.growth(size);
    const Triangle t{{dice.point(size), dice.point(size), dice.point(size)}};
    if (!isFinite(t) || !std::isfinite(growth)) continue;
    const BoxSides sides(box, growth);
    const bool misses = !intersects(inflated(boxOf(t), growth), box);
    const bool has_common = (sides.of(t.v[0]) & sides.of(t.v[1]) & sides.of(t.v[2])) != 0;
    ASSERT_LE(has_common, misses) << i;
    common += has_common ? 1 : 0;
    missed += misses ? 1 : 0;
  }
  EXPECT_GT(common, 50000);
  EXPECT_GT(common, missed * 3 / 4);
}

// Each side is told from the others, and what is a little further away is seen.
TEST(BoxSides, AreSeenCloseToTheBox) {
  const Aabb box{{-1, -2, -3}, {1, 2, 3}};
  for (const float growth : {0.0F, 0.5F}) {
    const BoxSides sides(box, growth);
    std::uint8_t all = 0;
    for (int axis = 0; axis < 3; ++axis) {
      for (const float sign : {-1.0F, 1.0F}) {
        const float off = sign * (static_cast<float>(axis + 1) + growth);
        const auto at = [&](float x) {
          return Vec3f{axis == 0 ? x : 0, axis == 1 ? x : 0, axis == 2 ? x : 0};
        };
        EXPECT_EQ(0, sides.of(at(off)));
        const std::uint8_t side = sides.of(at(off * 1.00001F));
        EXPECT_EQ(0, side & (side - 1));
        EXPECT_EQ(0, side & all);
        all |= side;
      }
    }
    EXPECT_EQ(63, all);
  }
  EXPECT_NE(0, BoxSides({{0, 0, 0}, {1, 1, 1}}, 0).of({-1e-30F, 0, 0}));
}

}  // namespace
}  // namespace deformable_contact_monitor
