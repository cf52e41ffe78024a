// Principal axes for every kind of spectrum, and intervals that never lose a touching pair.
#include "core/rules/principal_axes.h"

#include <gtest/gtest.h>

#include <random>

#include "core/rules/intervals.h"

namespace deformable_contact_monitor {
namespace {

double length(const Vec3f& v) { return std::sqrt(dot(toDouble(v), toDouble(v))); }

void expectOrthonormal(const PrincipalAxes& axes) {
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(length(axes.axis[i]), 1, 1e-5);
    for (int j = 0; j < i; ++j) EXPECT_NEAR(dot(axes.axis[i], axes.axis[j]), 0, 1e-5);
  }
}

double variance(const std::vector<Vec3f>& points, const Vec3f& axis) {
  double sum = 0, squares = 0;
  for (const Vec3f& p : points) {
    const double x = dot(toDouble(axis), toDouble(p));
    sum += x;
    squares += x * x;
  }
  const auto n = static_cast<double>(points.size());
  return squares / n - sum / n * (sum / n);
}

PrincipalAxes axesOf(const std::vector<Vec3f>& points) {
  Moments moments;
  for (const Vec3f& p : points) moments.add(p);
  return principalAxes(covarianceOf(moments));
}

TEST(PrincipalAxes, FirstAxisHasTheMostVarianceOfAllDirections) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  for (int trial = 0; trial < 50; ++trial) {
    const Vec3f size{std::fabs(normal(random)), std::fabs(normal(random)), 0.1F};
    const Vec3f shear{normal(random), normal(random), normal(random)};
    std::vector<Vec3f> points(300);
    for (Vec3f& p : points) {
      const float x = normal(random) * size.x, y = normal(random) * size.y,
                  z = normal(random) * size.z;
      p = {x + shear.x * y, y + shear.y * z, z + shear.z * x};
    }
    const PrincipalAxes axes = axesOf(points);
    expectOrthonormal(axes);
    const double first = variance(points, axes.axis[0]);
    EXPECT_GE(first, variance(points, axes.axis[1]) * (1 - 1e-6));
    EXPECT_GE(variance(points, axes.axis[1]), variance(points, axes.axis[2]) * (1 - 1e-6));
    for (int i = 0; i < 100; ++i) {
      const Vec3f d{normal(random), normal(random), normal(random)};
      const auto inverse = static_cast<float>(1 / length(d));
      EXPECT_LE(variance(points, d * inverse), first * (1 + 1e-4));
    }
  }
}

TEST(PrincipalAxes, DegenerateSpectraGiveUsableAxes) {
  const std::vector<std::vector<Vec3f>> clouds = {
      {},
      {{3, 4, 5}},
      {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}},
      {{0, 0, 0}, {1, 2, 3}},
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
      {{1e-30F, 0, 0}, {0, 1e-30F, 0}},
      {{1e18F, 0, 0}, {0, 1e18F, 0}, {-1e18F, 1, 2}},
  };
  for (const auto& cloud : clouds) expectOrthonormal(axesOf(cloud));
  Moments broken;
  broken.add({NAN, 0, 1});
  expectOrthonormal(principalAxes(covarianceOf(broken)));
}

// Two triangles that touch in one rounded point, extreme along the axis for both.
TEST(Projection, TouchingTrianglesAlwaysOverlap) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> uniform(-1, 1);
  const auto point = [&] { return Vec3f{uniform(random), uniform(random), uniform(random)}; };
  int naive_misses = 0;
  for (int trial = 0; trial < 200000; ++trial) {
    const Vec3f axis = point(), a0 = point(), a1 = point();
    const float t = (uniform(random) + 1) / 2;
    // The touching point as a vertex of b, rounded: it may be off a's edge by half an ulp.
    const Vec3f on_edge = a0 + (a1 - a0) * t;
    const Vec3f a[3] = {a0, a1, on_edge};
    const Vec3f b[3] = {on_edge, on_edge, on_edge};
    const Interval x = project(axis, a, 0), y = project(axis, b, 0);
    ASSERT_TRUE(x.lo <= y.hi && y.lo <= x.hi);
    // The interval is grown so that the exact interval lies inside.
    long double exact_lo = INFINITY, exact_hi = -INFINITY;
    for (const Vec3f& v : a) {
      const long double p = static_cast<long double>(axis.x) * v.x +
                            static_cast<long double>(axis.y) * v.y +
                            static_cast<long double>(axis.z) * v.z;
      exact_lo = std::min(exact_lo, p);
      exact_hi = std::max(exact_hi, p);
    }
    ASSERT_LE(x.lo, exact_lo);
    ASSERT_GE(x.hi, exact_hi);
    const float rounded = std::min(dot(axis, a[0]), std::min(dot(axis, a[1]), dot(axis, a[2])));
    naive_misses += rounded > exact_lo;
  }
  EXPECT_GT(naive_misses, 1000) << "the trial is not hard enough to show anything";
}

TEST(PackedBox, KeepsEveryOverlap) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(-1, 1);
  const Quantiser quantiser[2] = {{-1, 1}, {-1, 1}};
  int apart = 0, seen_apart = 0;
  for (int trial = 0; trial < 100000; ++trial) {
    Interval i[2], j[2];
    bool exact = true;
    for (int k = 0; k < 2; ++k) {
      const float x = uniform(random), y = uniform(random);
      i[k] = {x, std::min(1.0F, x + 0.3F * std::fabs(uniform(random)))};
      j[k] = {y, std::min(1.0F, y + 0.3F * std::fabs(uniform(random)))};
      if (trial % 3 == 0) {  // touching
        j[k].lo = i[k].hi;
        j[k].hi = std::max(j[k].hi, j[k].lo);
      }
      exact = exact && i[k].lo <= j[k].hi && j[k].lo <= i[k].hi;
    }
    const bool packed = intersects(pack(quantiser, i), pack(quantiser, j));
    if (exact) {
      ASSERT_TRUE(packed);
    }
    apart += !exact;
    seen_apart += !packed;
  }
  EXPECT_GT(seen_apart, apart * 0.98);
}

TEST(PackedBox, AFlatClusterIsNoTrouble) {
  const Quantiser flat(0.5F, 0.5F);
  EXPECT_EQ(flat(0.5F), 0U);
}

}  // namespace
}  // namespace deformable_contact_monitor
