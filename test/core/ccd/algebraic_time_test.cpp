// Exact times: roots of integer polynomials, their order, signs at them.
#include "swept/algebraic_time.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <vector>

namespace deformable_contact_monitor {
namespace {

IntegerPolynomial polynomial(std::initializer_list<int> coefficients) {
  return IntegerPolynomial(std::vector<mpz_class>(coefficients.begin(), coefficients.end()));
}

// The polynomial of a rational root.
IntegerPolynomial linear(const mpq_class& root) {
  return IntegerPolynomial({-root.get_num(), root.get_den()});
}

const IntegerPolynomial kHalf = polynomial({-1, 0, 2});  // root of 1/2: irrational

TEST(AlgebraicTime, RootsInTheStepEachOnceAscending) {
  const IntegerPolynomial p = polynomial({-1, 2}) * polynomial({-1, 2}) * polynomial({-1, 3}) *
                              polynomial({0, 1}) * polynomial({-1, 1}) * polynomial({1, 1}) *
                              polynomial({-3, 2}) * polynomial({1, 0, 1});
  std::vector<AlgebraicTime> roots = rootsInStep(p);
  ASSERT_EQ(4U, roots.size());
  EXPECT_TRUE(roots[0].isDyadic() && roots[2].isDyadic() && roots[3].isDyadic());
  const mpq_class expected[] = {0, {1, 3}, {1, 2}, 1};
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(0, roots[i].signOf(linear(expected[i]))) << i;
    roots[i].refineTo(100);
    EXPECT_LE(toRational(roots[i].low()), expected[i]);
    EXPECT_GE(toRational(roots[i].high()), expected[i]);
    EXPECT_LE(abs(toRational(roots[i].high()) - expected[i]), mpq_class(1) / (mpz_class(1) << 100));
  }
  EXPECT_TRUE(rootsInStep(polynomial({7})).empty());
  EXPECT_TRUE(rootsInStep(polynomial({1, -3, 3})).empty());
  EXPECT_TRUE(rootsInStep(polynomial({6, -5, 1})).empty());
}

TEST(AlgebraicTime, RootsThatAreNearlyOne) {
  // 1/2 and 2^-40 more, then roots of 1/2 and of 1/2 + 2^-100.
  const mpz_class big = mpz_class(1) << 100;
  const IntegerPolynomial scaled = polynomial({-1, 0, 2}) * IntegerPolynomial({big});
  const IntegerPolynomial pairs[] = {
      linear({1, 2}) * linear(mpq_class(1, 2) + mpq_class(1) / (mpz_class(1) << 40)),
      kHalf * (scaled - polynomial({2}))};
  for (const IntegerPolynomial& p : pairs) {
    std::vector<AlgebraicTime> roots = rootsInStep(p);
    ASSERT_EQ(2U, roots.size());
    EXPECT_EQ(-1, compare(roots[0], roots[1]));
    EXPECT_EQ(1, compare(roots[1], roots[0]));
    AlgebraicTime middle(between(roots[0], roots[1]));
    EXPECT_EQ(-1, compare(roots[0], middle));
    EXPECT_EQ(1, compare(roots[1], middle));
  }
}

TEST(AlgebraicTime, SignsAtAnIrrationalTime) {
  int checked = 0;
  for (const IntegerPolynomial& of :
       {kHalf, kHalf * polynomial({-1, 3}), kHalf * polynomial({-3, 4})}) {
    for (AlgebraicTime& root : rootsInStep(of)) {
      if (root.signOf(polynomial({-2, 5})) < 0 || root.signOf(polynomial({-73, 100})) > 0) continue;
      ++checked;
      EXPECT_EQ(0, root.signOf(kHalf));
      EXPECT_EQ(0, root.signOf(IntegerPolynomial()));
      EXPECT_EQ(0, root.signOf(kHalf * polynomial({-1, 1, 5})));
      EXPECT_EQ(1, root.signOf(polynomial({1})));
      EXPECT_EQ(1, root.signOf(polynomial({-1, 0, 3})));
      EXPECT_EQ(-1, root.signOf(polynomial({-1, 0, 1})));
      EXPECT_EQ(1, root.signOf(linear(
                       {mpz_class("70710678118654752440"), mpz_class("100000000000000000000")})));
      EXPECT_EQ(-1, root.signOf(linear(
                        {mpz_class("70710678118654752441"), mpz_class("100000000000000000000")})));
    }
  }
  EXPECT_EQ(3, checked);
}

TEST(AlgebraicTime, RootsOfDifferentPolynomialsCompare) {
  std::vector<AlgebraicTime> third = rootsInStep(polynomial({-1, 3}));
  std::vector<AlgebraicTime> same = rootsInStep(polynomial({-1, 3}) * kHalf);
  ASSERT_EQ(2U, same.size());
  EXPECT_EQ(0, compare(third[0], same[0]));
  EXPECT_EQ(-1, compare(third[0], same[1]));
  AlgebraicTime zero({0, 0}), one({1, 0}), half({1, 1}), also_half({4, 3});
  EXPECT_EQ(-1, compare(zero, third[0]));
  EXPECT_EQ(1, compare(one, third[0]));
  EXPECT_EQ(1, compare(half, third[0]));
  EXPECT_EQ(0, compare(half, also_half));
}

TEST(AlgebraicTime, RandomRationalRoots) {
  std::mt19937 generator(31);
  for (int round = 0; round < 300; ++round) {
    std::set<mpq_class> expected;
    IntegerPolynomial p = polynomial({1 + static_cast<int>(generator() % 5)});
    for (int degree = 1 + static_cast<int>(generator() % 4); degree > 0; --degree) {
      mpq_class root(static_cast<int>(generator() % 25) - 4, 1 + generator() % 12);
      root.canonicalize();
      p = p * linear(root);
      if (0 <= root && root <= 1) expected.insert(root);
    }
    std::vector<AlgebraicTime> roots = rootsInStep(p);
    ASSERT_EQ(expected.size(), roots.size()) << "round " << round;
    std::size_t i = 0;
    for (const mpq_class& root : expected) ASSERT_EQ(0, roots[i++].signOf(linear(root)));
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
