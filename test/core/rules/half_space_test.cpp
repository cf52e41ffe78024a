// The half-space rule against its definition, evaluated in long double over all prototypes.
#include "core/rules/half_space.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "core/cpu/cluster.h"

namespace deformable_contact_monitor {
namespace {

long double squared(const Vec3f& a, const Vec3f& b) {
  const long double x = static_cast<long double>(a.x) - b.x;
  const long double y = static_cast<long double>(a.y) - b.y;
  const long double z = static_cast<long double>(a.z) - b.z;
  return x * x + y * y + z * z;
}

struct World {
  std::mt19937 random;
  std::vector<Vec3f> points;
  Prototypes prototypes;

  World(unsigned seed, std::size_t count, bool on_grid) : random(seed) {
    for (std::size_t i = 0; i < count; ++i) points.push_back(point(on_grid));
    prototypes.build(points);
  }
  float coordinate(bool on_grid) {
    if (on_grid) return static_cast<float>(static_cast<int>(random() % 17) - 8) / 8;
    return std::uniform_real_distribution<float>(-1, 1)(random);
  }
  Vec3f point(bool on_grid) {
    return {coordinate(on_grid), coordinate(on_grid), coordinate(on_grid)};
  }
};

class HalfSpaceRuleTest : public testing::TestWithParam<std::tuple<std::size_t, bool>> {};

TEST_P(HalfSpaceRuleTest, FindsANearestPrototype) {
  World world(1, std::get<0>(GetParam()), std::get<1>(GetParam()));
  const PrototypesView view = world.prototypes.view();
  for (int i = 0; i < 2000; ++i) {
    const Vec3f v = world.point(std::get<1>(GetParam()));
    const NearestPrototype nearest = nearestPrototype(view, v, world.random() % view.count, 0);
    std::vector<long double> distances;
    for (std::uint32_t g = 0; g < view.count; ++g) {
      distances.push_back(squared(v, view.prototypes[g]));
    }
    const long double found = distances[nearest.cluster];
    std::sort(distances.begin(), distances.end());
    ASSERT_LE(found, distances[0] * (1 + 1e-6L));
    if (view.count == 1) continue;
    if (distances[1] == distances[0]) {
      EXPECT_TRUE(nearest.tied);
    }
    if (distances[1] > distances[0] * 1.1L + 1e-5L) {
      EXPECT_FALSE(nearest.tied);
    }
  }
}

// No cluster whose cell the triangle may reach is left out, and few others are let in.
TEST_P(HalfSpaceRuleTest, AdmitsWhatTheDefinitionAdmits) {
  World world(2, std::get<0>(GetParam()), std::get<1>(GetParam()));
  const PrototypesView view = world.prototypes.view();
  std::size_t admitted = 0, needed = 0;
  for (int i = 0; i < 1000; ++i) {
    HalfSpaceRule rule;
    const Vec3f corner = world.point(std::get<1>(GetParam()));
    const float size = (i % 3 == 0) ? 0.6F : 0.05F;
    std::uint32_t first = 0;
    std::set<std::uint32_t> competitors;
    for (Vec3f& v : rule.v) v = corner + world.point(std::get<1>(GetParam())) * size;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t nearest = nearestPrototype(view, rule.v[k], 0, 0).cluster;
      if (k == 0) first = nearest;
      competitors.insert(nearest);
      rule.addCompetitor(view.prototypes[nearest], 0);
    }
    std::set<std::uint32_t> got;
    forEachAdmitted(view, rule, first, [&](std::uint32_t g) {
      EXPECT_TRUE(got.insert(g).second) << "cluster " << g << " twice";
    });
    for (std::uint32_t g = 0; g < view.count; ++g) {
      bool kept = true;
      for (const std::uint32_t k : competitors) {
        bool all_nearer_to_k = true;
        for (const Vec3f& v : rule.v) {
          all_nearer_to_k =
              all_nearer_to_k && squared(v, view.prototypes[g]) > squared(v, view.prototypes[k]);
        }
        kept = kept && !all_nearer_to_k;
      }
      needed += kept;
      if (kept) {
        ASSERT_TRUE(got.count(g)) << "cluster " << g << " left out";
      }
    }
    admitted += got.size();
  }
  EXPECT_LE(admitted, needed + needed / 50);
}

INSTANTIATE_TEST_SUITE_P(Counts, HalfSpaceRuleTest,
                         testing::Combine(testing::Values(1, 2, 3, 40, 64, 66, 300, 2000),
                                          testing::Bool()));

TEST(HalfSpaceRule, ATriangleWithinTheMarginOfABorderIsOnBothSides) {
  const Vec3f left{-1, 0, 0}, right{1, 0, 0};
  HalfSpaceRule rule;
  rule.v[0] = {-0.1F, 0, 0};
  rule.v[1] = {-0.2F, 0.1F, 0};
  rule.v[2] = {-0.2F, 0, 0.1F};
  rule.addCompetitor(left, 0);
  EXPECT_FALSE(rule.admits(right));
  HalfSpaceRule near = rule;
  near.competitors = 0;
  near.addCompetitor(left, 2 * 0.1001F);
  EXPECT_TRUE(near.admits(right));
}

TEST(Prototypes, CoincidentOnesAreKeptOnce) {
  Prototypes prototypes;
  prototypes.build({{0, 0, 0}, {0.5F, 0, 0}, {0, 0, 0}, {0, 1e-8F, 0}, {0.5F, 0, 0}, {0, 1, 0}});
  EXPECT_EQ(prototypes.size(), 3U);
}

}  // namespace
}  // namespace deformable_contact_monitor
