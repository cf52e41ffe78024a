// Signs by integers against signs by expansions, and both against what must hold of determinants.
#include "core/predicates/orientation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace deformable_contact_monitor {
namespace {

// `spread`: of the coordinates' exponents; small grids make zero determinants common.
class Points {
 public:
  Points(unsigned seed, int spread, int grid) : random_(seed), spread_(spread), grid_(grid) {}
  Vec3f next() { return {coordinate(), coordinate(), coordinate()}; }

 private:
  float coordinate() {
    const int exponent = static_cast<int>(random_() % static_cast<unsigned>(spread_ + 1));
    const int range = 2 * grid_ + 1;
    const int step = static_cast<int>(random_() % static_cast<unsigned>(range)) - grid_;
    return std::ldexp(static_cast<float>(step), exponent - 60);
  }
  std::mt19937 random_;
  int spread_, grid_;
};

TEST(Orientation, IntegersAgreeWithExpansions) {
  std::size_t by_integers = 0, by_expansions = 0, zeros = 0;
  for (const int spread : {0, 1, 10, 20, 30, 40, 100, 150}) {
    for (const int grid : {1, 2, 16777215}) {
      Points points(static_cast<unsigned>(spread + grid), spread, grid);
      for (int i = 0; i < 3000; ++i) {
        const Vec3f a = points.next(), b = points.next(), c = points.next(), d = points.next();
        const float x[12] = {a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, d.x, d.y, d.z};
        std::int64_t integers[12];
        (toIntegers(x, integers) ? by_integers : by_expansions) += 1;
        const int sign = orient3dExact(a, b, c, d);
        ASSERT_EQ(sign, orient3dExpanded(a, b, c, d)) << "spread " << spread << ", grid " << grid;
        ASSERT_EQ(sign, -orient3dExact(b, a, c, d));
        ASSERT_EQ(sign, -orient3dExact(a, b, d, c));
        ASSERT_EQ(orient2dExact(a.x, a.y, b.x, b.y, c.x, c.y),
                  orient2dExpanded(a.x, a.y, b.x, b.y, c.x, c.y));
        zeros += sign == 0;
      }
    }
  }
  EXPECT_GT(by_integers, 20000U);
  EXPECT_GT(by_expansions, 5000U);
  EXPECT_GT(zeros, 2000U);
}

TEST(Orientation, TheLargestDifferencesFit) {
  // Exponents as far apart as integers take, mantissas full.
  const float big = std::ldexp(16777215.0F, 37), small = 8388609;
  const Vec3f a{-big, -big, -big}, b{big, -big, small}, c{small, big, -big}, d{big, big, big};
  const float x[12] = {a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, d.x, d.y, d.z};
  std::int64_t integers[12];
  ASSERT_TRUE(toIntegers(x, integers));
  EXPECT_EQ(orient3dExact(a, b, c, d), orient3dExpanded(a, b, c, d));
  EXPECT_NE(orient3dExact(a, b, c, d), 0);
  float beyond[2] = {2 * big, small};
  std::int64_t two[2];
  EXPECT_FALSE(toIntegers(beyond, two));
}

// The sum of three products that cancel down to their errors, or below.
TEST(Orientation, SignsOfProductsAreExact) {
  std::mt19937_64 random(5);
  const auto whole = [&random](std::uint64_t most) {
    return static_cast<double>(static_cast<std::int64_t>(random() % (2 * most + 1))) -
           static_cast<double>(most);
  };
  int told = 0, zeros = 0;
  constexpr int kSums = 200000;
  for (int n = 0; n < kSums; ++n) {
    const std::uint64_t most = std::uint64_t{1} << (10 + n % 40);
    const double x = whole(most), y = whole(most), i = whole(3), j = whole(3);
    const double z = -(x + i), w = y + j;
    const double s = n % 3 == 0 ? whole(3) : 1, t = x * j + i * y + i * j + whole(1);
    Expansion<8> sum;
    sum.addProduct(x, y);
    sum.addProduct(z, w);
    sum.addProduct(s, t);
    const int sign = detail::signOfProducts(x, y, z, w, s, t);
    if (sign == kUncertain) continue;
    ++told;
    zeros += sign == 0;
    ASSERT_EQ(sign, sum.sign()) << n;
  }
  EXPECT_GT(told, kSums / 2);
  EXPECT_GT(zeros, kSums / 10);
}

// Determinants of coordinates of all sizes have sums with gaps and many components.
TEST(Orientation, CompressedSumsAreTheSame) {
  std::mt19937 random(8);
  int most = 0;
  for (int n = 0; n < 20000; ++n) {
    Vec3f p[4];
    for (Vec3f& v : p) {
      const auto any = [&random] {
        const float x = static_cast<float>(random() % 3 == 0 ? 1 : 1 + random() % (1U << 24));
        return std::ldexp(random() % 2 == 0 ? x : -x, static_cast<int>(random() % 253) - 149);
      };
      v = {any(), any(), any()};
    }
    Expansion<48> sum;
    addOrient3d(sum, p[0], p[1], p[2], p[3]);
    Expansion<48> few = sum;
    few.compress();
    most = std::max(most, few.size());
    ASSERT_LE(few.size(), 17) << n;
    Expansion<96> difference;
    for (int i = 0; i < sum.size(); ++i) difference.add(sum.component(i));
    for (int i = 0; i < few.size(); ++i) difference.add(-few.component(i));
    ASSERT_EQ(0, difference.size()) << n;
    for (int i = 1; i < few.size(); ++i) {
      ASSERT_LE(std::fabs(few.component(i - 1)), 0x1p-52 * std::fabs(few.component(i))) << n;
    }
  }
  EXPECT_GT(most, 8);
}

TEST(Orientation, IntegersAreTheNumbers) {
  const float subnormal = std::numeric_limits<float>::denorm_min();
  const float x[6] = {
      0.0F, -0.0F, subnormal, -3 * subnormal, std::ldexp(1.0F, -126), -std::ldexp(1.5F, -120)};
  std::int64_t integers[6];
  ASSERT_TRUE(toIntegers(x, integers));
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(static_cast<double>(integers[i]), static_cast<double>(x[i]) / subnormal) << i;
  }
}

// A point on the line through two others, by construction, at every size that float32 has.
TEST(Orientation, CollinearPointsAreExactlyCollinear) {
  std::mt19937 random(3);
  for (int i = 0; i < 20000; ++i) {
    const float scale = std::ldexp(1.0F, static_cast<int>(random() % 200) - 110);
    const auto pick = [&] { return static_cast<float>(static_cast<int>(random() % 2001) - 1000); };
    const float px = pick(), py = pick(), ux = pick(), uy = pick(), t = pick();
    const float ax = px * scale, ay = py * scale;
    const float bx = (px + ux) * scale, by = (py + uy) * scale;
    const float cx = (px + t * ux) * scale, cy = (py + t * uy) * scale;
    ASSERT_EQ(orient2dExact(ax, ay, bx, by, cx, cy), 0);
    const float off = std::nextafter(cy, INFINITY);
    const int expected = ux > 0 ? 1 : (ux < 0 ? -1 : 0);
    ASSERT_EQ(orient2dExact(ax, ay, bx, by, cx, off), expected);
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
