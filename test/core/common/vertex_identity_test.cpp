// Vertices are one iff their coordinates as received are equal.
#include "core/common/vertex_identity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace deformable_contact_monitor {
namespace {

TEST(VertexIdentity, AgreesWithComparingAllPairs) {
  std::mt19937 random(1);
  std::vector<float> xyz(3 * 700);
  for (float& x : xyz) {
    const auto k = random() % 6;
    x = k == 5 ? -0.0F : static_cast<float>(k);
  }
  std::vector<std::uint32_t> least_equal;
  VertexIdentity identity;
  for (int repeat = 0; repeat < 2; ++repeat) {
    identity.identify(xyz, least_equal);
    ASSERT_EQ(least_equal.size(), 700U);
    for (std::uint32_t i = 0; i < 700; ++i) {
      std::uint32_t expected = 0;
      while (xyz[3 * expected] != xyz[3 * i] || xyz[3 * expected + 1] != xyz[3 * i + 1] ||
             xyz[3 * expected + 2] != xyz[3 * i + 2]) {
        ++expected;
      }
      ASSERT_EQ(least_equal[i], expected) << "vertex " << i;
    }
    std::shuffle(xyz.begin(), xyz.end(), random);
  }
}

TEST(VertexIdentity, NonFiniteVerticesAreEqualToNoneAndCostLittle) {
  std::vector<float> xyz(3 * 200000, NAN);  // quadratic time would show
  xyz[0] = xyz[1] = xyz[2] = INFINITY;
  xyz[3] = xyz[4] = xyz[5] = INFINITY;
  std::vector<std::uint32_t> least_equal;
  VertexIdentity().identify(xyz, least_equal);
  for (std::uint32_t i = 0; i < least_equal.size(); ++i) ASSERT_EQ(least_equal[i], i);
}

// In two states vertices are one iff they are in both.
TEST(VertexIdentity, InTwoStates) {
  const std::vector<float> now = {1, 2, 3, 1, 2, 3, 1, 2, 3, -0.0F, 0, 0, 0, 0, 0, NAN, 0, 0};
  const std::vector<float> earlier = {0, 0, 0, 0, 0, 1, -0.0F, 0, 0, 5, 5, 5, 5, 5, 5, 1, 1, 1};
  std::vector<std::uint32_t> least_equal;
  VertexIdentity().identify(now, earlier, least_equal);
  EXPECT_EQ((std::vector<std::uint32_t>{0, 1, 0, 3, 3, 5}), least_equal);
  VertexIdentity().identify(earlier, now, least_equal);
  EXPECT_EQ((std::vector<std::uint32_t>{0, 1, 0, 3, 3, 5}), least_equal);
}

TEST(VertexIdentity, NoVertices) {
  std::vector<std::uint32_t> least_equal{7};
  VertexIdentity().identify({}, least_equal);
  EXPECT_TRUE(least_equal.empty());
}

}  // namespace
}  // namespace deformable_contact_monitor
