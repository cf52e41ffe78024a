// Distances of triangles that do not intersect, against exact rationals; and when two are near.
#include "core/predicates/triangle_distance.h"

#include <gtest/gtest.h>

#include <cfloat>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "core/predicates/narrow_phase.h"
#include "exact_distance.h"

namespace deformable_contact_monitor {
namespace {

struct Pair {
  Triangle a, b;
};

class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  int within(int low, int high) {
    return low + static_cast<int>(random_() % static_cast<unsigned>(high - low + 1));
  }
  float real(float size) {
    return size * (static_cast<float>(within(-(1 << 23), 1 << 23)) * 0x1p-23F);
  }
  Vec3f point(float size) { return {real(size), real(size), real(size)}; }
  Triangle triangle(float size) { return {{point(size), point(size), point(size)}}; }
  Vec3f gridPoint(int range) {
    return {static_cast<float>(within(-range, range)), static_cast<float>(within(-range, range)),
            static_cast<float>(within(-range, range))};
  }
  Triangle gridTriangle(int range) {
    return {{gridPoint(range), gridPoint(range), gridPoint(range)}};
  }

 private:
  std::mt19937 random_;
};

Triangle scaled(Triangle t, float factor) {
  for (Vec3f& v : t.v) v = v * factor;
  return t;
}

Triangle moved(Triangle t, const Vec3f& by) {
  for (Vec3f& v : t.v) v = v + by;
  return t;
}

Pair ordinary(Dice* dice) { return {dice->triangle(1), moved(dice->triangle(1), dice->point(1))}; }

Pair farFromTheOrigin(Dice* dice) {
  const Vec3f there = dice->point(1000);
  return {moved(dice->triangle(0.01F), there), moved(dice->triangle(0.01F), there)};
}

Pair onAGrid(Dice* dice) { return {dice->gridTriangle(3), dice->gridTriangle(3)}; }

// Nearly or quite collinear.
Pair slivers(Dice* dice) {
  Pair pair = ordinary(dice);
  const float width = std::ldexp(1.0F, -dice->within(10, 40));
  for (Triangle* t : {&pair.a, &pair.b}) {
    const Vec3f along = t->v[1] - t->v[0];
    t->v[2] = t->v[0] + along * dice->real(1.5F) + dice->point(width);
  }
  return pair;
}

Pair degenerate(Dice* dice) {
  Pair pair = dice->within(0, 1) == 0 ? ordinary(dice) : onAGrid(dice);
  pair.a.v[2] = pair.a.v[dice->within(0, 1)];
  if (dice->within(0, 1) == 0) pair.a.v[1] = pair.a.v[2];
  if (dice->within(0, 2) == 0) pair.b.v[0] = pair.b.v[1];
  return pair;
}

// A vertex, or an edge, just off the other's face or edge.
Pair nearlyTouching(Dice* dice) {
  Pair pair = ordinary(dice);
  const float s = std::abs(dice->real(0.5F)), r = dice->within(0, 1) == 0 ? 0 : 0.3F;
  const Vec3f on_a =
      pair.a.v[0] + (pair.a.v[1] - pair.a.v[0]) * s + (pair.a.v[2] - pair.a.v[0]) * r;
  const Vec3f off = dice->point(std::ldexp(1.0F, -dice->within(8, 30)));
  const Vec3f along = dice->point(1);
  pair.b.v[0] = on_a + off;
  if (dice->within(0, 1) == 0) {
    pair.b.v[0] = on_a + off + along;
    pair.b.v[1] = on_a + off - along;
  }
  return pair;
}

// Some vertices up to the largest float32 away, also in planes and on lines through the other.
Pair farVertices(Dice* dice) {
  Pair pair = dice->within(0, 1) == 0 ? ordinary(dice) : onAGrid(dice);
  const float far = std::ldexp(1.0F, dice->within(20, 126));
  const int kind = dice->within(0, 4);
  if (kind == 0) {
    pair.a.v[0] = dice->point(far);
  } else if (kind == 1) {  // an edge through the origin
    pair.a.v[0] = dice->point(far);
    pair.a.v[1] = pair.a.v[0] * -1;
  } else if (kind == 2) {  // a plane through the origin
    pair.a.v[0] = dice->point(far);
    pair.a.v[1] = {pair.a.v[0].y, pair.a.v[0].z, pair.a.v[0].x};
    pair.a.v[2] = (pair.a.v[0] * -0.5F) + (pair.a.v[1] * -0.5F);
  } else if (kind == 3) {  // ground
    pair.a = {{{-far, -far, 0.01F}, {far, -far, 0.01F}, {0, far, 0.01F}}};
  } else {  // both
    pair.a.v[0] = dice->point(far);
    pair.b.v[0] = dice->within(0, 1) == 0 ? pair.a.v[0] * 0.5F : dice->point(far);
  }
  return pair;
}

Pair tiny(Dice* dice) {
  const float size = std::ldexp(1.0F, -dice->within(100, 148));
  return {scaled(dice->gridTriangle(3), size), scaled(dice->gridTriangle(3), size)};
}

Pair ofAllSizes(Dice* dice) {
  Pair pair;
  for (Triangle* t : {&pair.a, &pair.b}) {
    for (Vec3f& v : t->v) v = dice->point(std::ldexp(1.0F, dice->within(-140, 120)));
  }
  return pair;
}

struct Class {
  const char* name;
  std::function<Pair(Dice*)> make;
};

std::vector<Class> classes() {
  return {{"ordinary", ordinary},        {"far from the origin", farFromTheOrigin},
          {"on a grid", onAGrid},        {"slivers", slivers},
          {"degenerate", degenerate},    {"nearly touching", nearlyTouching},
          {"far vertices", farVertices}, {"tiny", tiny},
          {"of all sizes", ofAllSizes}};
}

// Visits pairs of every class that do not intersect.
void forEachPair(int count, const std::function<void(const Pair&, const std::string&)>& visit) {
  for (const Class& kind : classes()) {
    Dice dice(3);
    int apart = 0;
    for (int i = 0; i < count; ++i) {
      const Pair pair = kind.make(&dice);
      PredicateState state;
      if (trianglesIntersect(pair.a, pair.b, state)) continue;
      ++apart;
      visit(pair, kind.name);
      if (::testing::Test::HasFailure()) FAIL() << kind.name << ", pair " << i;
    }
    EXPECT_GT(apart, count / 8) << kind.name;
  }
}

TEST(TriangleDistance, IsThatOfExactRationals) {
  forEachPair(1500, [](const Pair& pair, const std::string& name) {
    const double exact = exactDistance(pair.a, pair.b);
    EXPECT_NEAR(separation(pair.a, pair.b), exact, exact * 0x1p-28) << name;
    EXPECT_GT(separation(pair.a, pair.b), 0) << name;
  });
}

// The vertex lies beyond the sharp corner of a needle that ends very far away. The least component
// of an area decides on which side of the long edge it is.
TEST(TriangleDistance, OfAVertexBeyondTheCornerOfALongNeedle) {
  const float third = 0x1.555556p-2F, sixth = 0x1.555556p-3F;
  const Triangle a{
      {{third, 0, -0x1.17c0e6p-5F}, {0.5F, 0, -0x1.9d255ap-7F}, {0.5F, sixth, -0x1.d398b6p-11F}}};
  for (const float far : {3e38F, 1e30F, 1e20F, 1e10F, 1e6F}) {
    const Triangle b{{{-far, 0, 0}, {sixth, sixth, 0}, {0, sixth, 0}}};
    const double exact = exactDistance(a, b);
    EXPECT_NEAR(exact, separation(a, b), exact * 0x1p-28) << far;
  }
}

TEST(TriangleDistance, IsTheSameForBothOrders) {
  forEachPair(20000, [](const Pair& pair, const std::string& name) {
    EXPECT_EQ(separation(pair.a, pair.b), separation(pair.b, pair.a)) << name;
  });
}

TEST(TriangleDistance, IsNeverLessThanThatOfTheBoxes) {
  forEachPair(20000, [](const Pair& pair, const std::string& name) {
    const double gap = std::sqrt(squaredGap(boxOf(pair.a), boxOf(pair.b)));
    EXPECT_GE(separation(pair.a, pair.b) * (1 + 0x1p-28), gap) << name;
  });
}

TEST(TriangleDistance, FollowsExactShiftsAndScales) {
  Dice dice(5);
  for (int i = 0; i < 20000; ++i) {
    const Pair pair = onAGrid(&dice);
    PredicateState state;
    if (trianglesIntersect(pair.a, pair.b, state)) continue;
    const double expected = separation(pair.a, pair.b);
    const Vec3f by = dice.gridPoint(1 << 20);
    EXPECT_NEAR(expected, separation(moved(pair.a, by), moved(pair.b, by)), expected * 0x1p-28);
    for (const int exponent : {-140, 120}) {
      const float factor = std::ldexp(1.0F, exponent);
      EXPECT_EQ(std::ldexp(expected, exponent),
                separation(scaled(pair.a, factor), scaled(pair.b, factor)));
    }
  }
}

// The early decisions of nearVerdict agree with the distance.
TEST(NearVerdict, IsTheRoundedDistanceUpToTheMargin) {
  std::size_t near = 0;
  forEachPair(20000, [&near](const Pair& pair, const std::string& name) {
    const double distance = separation(pair.a, pair.b);
    if (distance > FLT_MAX / 2) return;
    const auto rounded = static_cast<float>(distance);
    for (const float factor : {0.5F, 0.999F, 1.001F, 1.5F, 10.0F, 1000.0F}) {
      const float margin = rounded * factor;
      if (margin == 0 || margin == rounded || margin > FLT_MAX) continue;
      const Verdict verdict = nearVerdict(pair.a, pair.b, margin);
      ASSERT_EQ(verdict.contact, rounded < margin) << name << ", " << distance << ", " << margin;
      ASSERT_EQ(verdict.separation_m, verdict.contact ? std::max(rounded, 1.4e-45F) : 0) << name;
      near += verdict.contact;
    }
  });
  EXPECT_GT(near, 100000U);
}

TEST(NearVerdict, NoneWithoutAMargin) {
  const Triangle low{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  EXPECT_FALSE(nearVerdict(low, moved(low, {0, 0, 1e-30F}), 0).contact);
}

TEST(NearVerdict, IsClosedForBoxesInRealNumbers) {
  const auto at = [](float z) { return Triangle{{{0, 0, z}, {1, 0, z}, {0, 1, z}}}; };
  for (const float margin : {1e-45F, 1e-30F, 0.1F, 1.0F, 3.0F, 1e30F, FLT_MAX}) {
    EXPECT_TRUE(nearVerdict(at(0), at(margin), margin).contact) << margin;
    EXPECT_EQ(nearVerdict(at(0), at(margin), margin).separation_m, margin);
    EXPECT_TRUE(nearVerdict(at(-margin), at(0), margin).contact) << margin;
    EXPECT_FALSE(nearVerdict(at(0), at(margin), std::nextafter(margin, 0.0F)).contact) << margin;
  }
  // 1 + 1e-20 rounds to 1, but inflated boxes that far apart need not meet.
  EXPECT_FALSE(nearVerdict(at(-1), at(1e-20F), 1).contact);
  EXPECT_TRUE(nearVerdict(at(-1), at(-1e-20F), 1).contact);
  // 0 is for those that intersect, however small the distance.
  EXPECT_GT(nearVerdict({{{0, 0, 0}, {1, 0, 0}, {0, 1e-45F, 0}}},
                        {{{0, 1e-45F, 0}, {1, 1e-45F, 0}, {1, 1, 0}}}, 1)
                .separation_m,
            0);
}

}  // namespace
}  // namespace deformable_contact_monitor
