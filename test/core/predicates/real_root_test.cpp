// Growing integers against GMP's, and roots of polynomials: multiple, close, common, at the ends.
#include "core/predicates/real_root.h"

#include <gmpxx.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace deformable_contact_monitor {
namespace {

// The same number twice.
struct Twins {
  GrowingInteger ours = 0;
  mpz_class theirs = 0;
};

Twins randomTwins(std::mt19937& random, int words) {
  Twins twins;
  for (int i = 0; i < words; ++i) {
    const auto part = static_cast<std::int64_t>(random());
    const int shift = random() % 3 == 0 ? 200 : 32;
    twins.ours = (twins.ours << shift) + part;
    mpz_mul_2exp(twins.theirs.get_mpz_t(), twins.theirs.get_mpz_t(),
                 static_cast<mp_bitcnt_t>(shift));
    twins.theirs += mpz_class(static_cast<unsigned long>(part));
  }
  if (random() % 2 == 0) {
    twins.ours = -twins.ours;
    twins.theirs = -twins.theirs;
  }
  return twins;
}

// By taking theirs off, 32 bits at a time.
bool areEqual(GrowingInteger ours, const mpz_class& theirs) {
  mpz_class size = abs(theirs);
  for (int shift = 0; size != 0; shift += 32) {
    const mpz_class low = size & 0xffffffffUL;
    const GrowingInteger part = GrowingInteger(static_cast<std::int64_t>(low.get_ui())) << shift;
    ours = sgn(theirs) > 0 ? ours - part : ours + part;
    size >>= 32;
  }
  return ours.sign() == 0;
}

TEST(GrowingInteger, IsAsGmpHasIt) {
  std::mt19937 random(7);
  for (int i = 0; i < 3000; ++i) {
    const Twins a = randomTwins(random, static_cast<int>(random() % 12));
    const Twins b = i % 5 == 0 ? a : randomTwins(random, static_cast<int>(random() % 12));
    ASSERT_TRUE(areEqual(a.ours + b.ours, a.theirs + b.theirs));
    ASSERT_TRUE(areEqual(a.ours - b.ours, a.theirs - b.theirs));
    ASSERT_TRUE(areEqual(a.ours * b.ours, a.theirs * b.theirs));
    ASSERT_EQ((a.ours - b.ours).sign(), sgn(mpz_class(a.theirs - b.theirs)));
    const int shift = static_cast<int>(random() % 300);
    ASSERT_TRUE(areEqual(a.ours << shift, a.theirs << static_cast<unsigned>(shift)));
    const mpz_class floored = abs(a.theirs) >> static_cast<unsigned>(shift);
    if (a.ours.sign() >= 0 && floored < mpz_class(1) << 62) {
      ASSERT_EQ(static_cast<std::int64_t>(a.ours >> shift), floored.get_si());
    }
  }
  EXPECT_EQ(GrowingInteger(INT64_MIN).sign(), -1);
  EXPECT_TRUE(areEqual(GrowingInteger(INT64_MIN), mpz_class(-1) << 63));
}

Polynomial linear(std::int64_t at_zero, std::int64_t slope) {
  return Polynomial::linear(at_zero, slope);
}

std::vector<double> rootsOf(const Polynomial& f) {
  std::vector<double> values;
  for (RealRoot& root : rootsInUnitInterval(f)) {
    EXPECT_EQ(root.signOf(f), 0);
    const float low = root.floatLow(), high = root.floatHigh();
    EXPECT_LE(high - low, std::ldexp(1.0F, -20));
    values.push_back((static_cast<double>(low) + high) / 2);
  }
  std::sort(values.begin(), values.end());
  return values;
}

void expectRoots(const Polynomial& f, const std::vector<double>& expected) {
  const std::vector<double> found = rootsOf(f);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-6);
}

TEST(RealRoot, SimpleOnesAndThoseAtTheEnds) {
  expectRoots(linear(-1, 3), {1.0 / 3});
  expectRoots(linear(0, 3), {0});
  expectRoots(linear(-3, 3), {1});
  expectRoots(linear(-4, 3), {});
  expectRoots(linear(1, 1), {});
  expectRoots(linear(0, 1) * linear(-1, 1) * linear(-1, 2), {0, 0.5, 1});
  expectRoots(linear(-1, 4) * linear(-1, 3) * linear(-1, 2), {0.25, 1.0 / 3, 0.5});
  const Polynomial two_t_squared = linear(0, 2) * linear(0, 1);
  expectRoots(two_t_squared - linear(1, 0), {std::sqrt(0.5)});
  expectRoots((two_t_squared - linear(1, 0)) * linear(-2, 3), {2.0 / 3, std::sqrt(0.5)});
  expectRoots(two_t_squared + linear(1, 0), {});
}

TEST(RealRoot, MultipleOnes) {
  expectRoots(linear(-1, 3) * linear(-1, 3), {1.0 / 3});
  expectRoots(linear(-1, 3) * linear(-1, 3) * linear(-1, 3), {1.0 / 3});
  expectRoots(linear(-1, 3) * linear(-1, 3) * linear(-2, 3), {1.0 / 3, 2.0 / 3});
  expectRoots(linear(-1, 3) * linear(-1, 3) * linear(5, 3), {1.0 / 3});
  expectRoots(linear(-1, 2) * linear(-1, 2) * linear(0, 1), {0, 0.5});
  expectRoots(linear(4, 3) * linear(4, 3) * linear(-1, 3), {1.0 / 3});
}

TEST(RealRoot, CloseOnesAreTwo) {
  const std::int64_t n = std::int64_t{1} << 40;
  std::vector<RealRoot> roots = rootsInUnitInterval(linear(-n / 2 - 1, n) * linear(-n / 2, n));
  ASSERT_EQ(roots.size(), 2U);
  EXPECT_NE(RealRoot::compare(roots[0], roots[1]), 0);
  EXPECT_EQ(RealRoot::compare(roots[0], roots[1]), -RealRoot::compare(roots[1], roots[0]));
}

TEST(RealRoot, SignsAndComparisonsAtCommonRoots) {
  const Polynomial f = linear(0, 2) * linear(0, 1) - linear(1, 0);  // 2 t^2 - 1
  RealRoot root = rootsInUnitInterval(f).at(0);
  EXPECT_EQ(root.signOf(f * linear(-1, 3)), 0);
  EXPECT_EQ(root.signOf(linear(-70710678, 100000000)), 1);
  EXPECT_EQ(root.signOf(linear(-70710679, 100000000)), -1);
  // The same root of another polynomial, and a rational one beside it.
  for (RealRoot& other : rootsInUnitInterval(f * linear(-1, 3))) {
    EXPECT_EQ(RealRoot::compare(root, other), other.floatLow() < 0.5F ? 1 : 0);
  }
  RealRoot third = rootsInUnitInterval(linear(-1, 3)).at(0);
  RealRoot half(Dyadic{1, 1});
  EXPECT_EQ(RealRoot::compare(third, half), -1);
  EXPECT_EQ(RealRoot::compare(half, third), 1);
  RealRoot same = rootsInUnitInterval(linear(-2, 4)).at(0);
  EXPECT_EQ(RealRoot::compare(half, same), 0);
  EXPECT_EQ(RealRoot::compare(same, half), 0);
  RealRoot between(RealRoot::numberBetween(third, half));
  EXPECT_EQ(RealRoot::compare(third, between), -1);
  EXPECT_EQ(RealRoot::compare(between, half), -1);
}

}  // namespace
}  // namespace deformable_contact_monitor
