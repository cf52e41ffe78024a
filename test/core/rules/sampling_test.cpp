// Samples and triangles are each other's inverse, and seeds stand in the middle of equal shares.
#include <gtest/gtest.h>

#include <tuple>
#include <vector>

#include "core/rules/clustering.h"

namespace deformable_contact_monitor {
namespace {

// (samples, triangles)
class SamplingTest : public testing::TestWithParam<std::tuple<std::uint32_t, std::uint32_t>> {
 protected:
  const Sampling sampling_{std::get<0>(GetParam()), std::get<1>(GetParam())};
};

TEST_P(SamplingTest, SampleAndTriangleAreInverse) {
  for (std::uint32_t s = 0; s < sampling_.samples; ++s) {
    const std::uint32_t t = sampling_.triangleOf(s);
    ASSERT_LT(t, sampling_.triangles);
    ASSERT_TRUE(sampling_.isSample(t)) << "sample " << s << ", triangle " << t;
    ASSERT_EQ(s, sampling_.sampleOf(t));
  }
}

TEST_P(SamplingTest, EachSampleIsOneTriangle) {
  std::vector<int> times(sampling_.samples, 0);
  for (std::uint32_t t = 0; t < sampling_.triangles; ++t) {
    if (!sampling_.isSample(t)) continue;
    ASSERT_LT(sampling_.sampleOf(t), sampling_.samples);
    ++times[sampling_.sampleOf(t)];
  }
  EXPECT_EQ(std::vector<int>(sampling_.samples, 1), times);
}

TEST_P(SamplingTest, SamplesAreSpreadEvenly) {
  const std::uint32_t step = sampling_.triangles / sampling_.samples;
  for (std::uint32_t s = 1; s < sampling_.samples; ++s) {
    const std::uint32_t gap = sampling_.triangleOf(s) - sampling_.triangleOf(s - 1);
    ASSERT_GE(gap, step);
    ASSERT_LE(gap, step + 1);
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, SamplingTest,
                         testing::Values(std::make_tuple(1U, 1U), std::make_tuple(1U, 1000U),
                                         std::make_tuple(7U, 7U), std::make_tuple(6U, 7U),
                                         std::make_tuple(2048U, 2048U),
                                         std::make_tuple(2048U, 2049U),
                                         std::make_tuple(2048U, 92230U),
                                         std::make_tuple(30000U, 1000003U)));

// Products that no 32 bits hold.
TEST(Sampling, OfTwoBillionTriangles) {
  const Sampling sampling{524280, 2147483647U};
  for (const std::uint32_t s : {0U, 1U, 262140U, 524279U}) {
    const std::uint32_t t = sampling.triangleOf(s);
    EXPECT_LT(t, sampling.triangles);
    EXPECT_TRUE(sampling.isSample(t));
    EXPECT_EQ(s, sampling.sampleOf(t));
  }
}

TEST(Sampling, IsEightAClusterButNoMoreThanThereAre) {
  EXPECT_EQ(2048U, samplingOf(92230, 16, 2048).samples);
  EXPECT_EQ(8000U, samplingOf(92230, 1000, 2048).samples);
  EXPECT_EQ(700U, samplingOf(700, 16, 2048).samples);
}

TEST(Sampling, SeedsStandInTheMiddleOfEqualShares) {
  EXPECT_EQ(50U, seedOf(0, 1, 100));
  EXPECT_EQ(5U, seedOf(0, 10, 100));
  EXPECT_EQ(95U, seedOf(9, 10, 100));
  for (std::size_t g = 0; g < 7; ++g) EXPECT_EQ(g, seedOf(g, 7, 7));
}

}  // namespace
}  // namespace deformable_contact_monitor
