// The distance that claims are checked with, worked out by hand and by points all over.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tools/measure_trade/bound_measurement.h"

namespace deformable_contact_monitor {
namespace {

const Triangle kFloor = {{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};

Triangle moved(Triangle t, const Vec3f& by) {
  for (Vec3f& v : t.v) v = v + by;
  return t;
}

TEST(TriangleGapTest, ByHand) {
  EXPECT_EQ(triangleGapM(kFloor, moved(kFloor, {0, 0, 2})), 2) << "faces";
  const Triangle blade = {{{1, 1, -1}, {1, 1, 1}, {1, 2, 1}}};
  EXPECT_EQ(triangleGapM(kFloor, blade), 0) << "through it";
  EXPECT_EQ(triangleGapM(kFloor, moved(blade, {0, 0, 1})), 0) << "a corner on it";
  EXPECT_EQ(triangleGapM(kFloor, moved(blade, {0, 0, 1.5F})), 0.5) << "a corner above it";
  EXPECT_EQ(triangleGapM(kFloor, moved(kFloor, {0, 0, 0})), 0) << "itself";
  EXPECT_EQ(triangleGapM(kFloor, moved(kFloor, {7, 0, 0})), 3) << "corners";
  const Triangle across = {{{2, -1, 1}, {2, -1, 3}, {2, -4, 1}}};
  EXPECT_DOUBLE_EQ(triangleGapM(kFloor, across), std::sqrt(2)) << "corner and edge";
  const Triangle bridge = {{{-1, 1, 2}, {3, -3, 2}, {1, 1, 9}}};
  EXPECT_EQ(triangleGapM(kFloor, bridge), 2) << "edges that cross";
  const Triangle point = {{{1, 1, 3}, {1, 1, 3}, {1, 1, 3}}};
  EXPECT_EQ(triangleGapM(kFloor, point), 3) << "degenerate";
  EXPECT_EQ(triangleGapM(point, moved(point, {0, 4, 3})), 5);
}

// No point of one is nearer to one of the other, and some are hardly farther.
TEST(TriangleGapTest, AgainstPointsAllOver) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> coordinate(-1, 1);
  const auto corner = [&] {
    return Vec3f{coordinate(random), coordinate(random), coordinate(random)};
  };
  constexpr int kParts = 24;
  const auto at = [](const Triangle& t, int i, int k) {
    const double u = double(i) / kParts, v = double(k) / kParts;
    return toDouble(t.v[0]) * (1 - u - v) + toDouble(t.v[1]) * u + toDouble(t.v[2]) * v;
  };
  for (int trial = 0; trial < 60; ++trial) {
    const Triangle a = {{corner(), corner(), corner()}};
    const Triangle b = moved({{corner(), corner(), corner()}}, {1, 0, 0});
    const double gap = triangleGapM(a, b);
    double nearest = INFINITY;
    for (int i = 0; i <= kParts; ++i) {
      for (int k = 0; i + k <= kParts; ++k) {
        for (int m = 0; m <= kParts; ++m) {
          for (int n = 0; m + n <= kParts; ++n) {
            const Vec3d way = at(a, i, k) - at(b, m, n);
            nearest = std::min(nearest, std::sqrt(dot(way, way)));
          }
        }
      }
    }
    EXPECT_LE(gap, nearest + 1e-12);
    EXPECT_GE(gap, nearest - 0.17) << "two cells of at most 3.5 / 24 m across, halved";
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
