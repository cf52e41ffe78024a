// The oracle against itself: its two independent methods must agree, and known cases must hold.
#include <gtest/gtest.h>

#include <random>

#include "cgal_oracle.h"
#include "pair_sets.h"
#include "random_scenes.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

TEST(Oracle, PredicatesAgreeWithConstructionOnGrids) {
  std::mt19937 generator(7);
  int met = 0, sharing = 0;
  for (int round = 0; round < 20000; ++round) {
    OracleTriangle t[2];
    for (OracleTriangle& triangle : t) {
      for (Vec3f& v : triangle) {
        v = {static_cast<float>(generator() % 3), static_cast<float>(generator() % 3),
             static_cast<float>(generator() % 3)};
      }
    }
    std::vector<Vec3f> shared;
    if (round % 2 == 0) {
      for (const Vec3f& v : t[0]) {
        if (std::find(t[1].begin(), t[1].end(), v) != t[1].end() &&
            std::find(shared.begin(), shared.end(), v) == shared.end()) {
          shared.push_back(v);
        }
      }
    }
    const bool expected = meetBeyondByConstruction(t[0], t[1], shared);
    ASSERT_EQ(expected, meetBeyondByPredicates(t[0], t[1], shared)) << "round " << round;
    ASSERT_EQ(expected, meetBeyondByConstruction(t[1], t[0], shared)) << "round " << round;
    met += expected;
    sharing += !shared.empty();
  }
  EXPECT_GT(met, 4000);
  EXPECT_GT(sharing, 1000);
}

TEST(Oracle, FoldsOverASharedEdgeOnlyOnOneSide) {
  const Vec3f p{0, 0, 0}, q{1, 0, 0};
  const OracleTriangle up{p, q, {0, 1, 0}}, other_up{p, q, {2, 1, 0}}, down{p, q, {0, -1, 0}},
      out{p, q, {0, 1, 1}};
  for (const auto meet : {meetBeyondByConstruction, meetBeyondByPredicates}) {
    EXPECT_TRUE(meet(up, other_up, {p, q}));
    EXPECT_FALSE(meet(up, down, {p, q}));
    EXPECT_FALSE(meet(up, out, {p, q}));
    EXPECT_FALSE(meet(up, up, {up[0], up[1], up[2]}));
  }
}

TEST(Oracle, SegmentsAndPointsAreClosedSets) {
  const OracleTriangle face{Vec3f{0, 0, 0}, Vec3f{4, 0, 0}, Vec3f{0, 4, 0}};
  const OracleTriangle point{Vec3f{1, 1, 0}, Vec3f{1, 1, 0}, Vec3f{1, 1, 0}};
  const OracleTriangle above{Vec3f{1, 1, 1e-30F}, Vec3f{1, 1, 1e-30F}, Vec3f{1, 1, 1e-30F}};
  const OracleTriangle through{Vec3f{1, 1, -1}, Vec3f{1, 1, 1}, Vec3f{1, 1, 0}};
  EXPECT_TRUE(meetBeyondByPredicates(face, point, {}));
  EXPECT_FALSE(meetBeyondByPredicates(face, above, {}));
  EXPECT_TRUE(meetBeyondByPredicates(face, through, {}));
}

TEST(Oracle, RandomScenesHaveContactsOfEveryKind) {
  std::size_t skip = 0, beyond = 0, across = 0;
  for (std::uint32_t seed = 0; seed < 300; ++seed) {
    const Scene scene = randomScene(seed);
    skip += oracleContacts(scene, AdjacentPairs::kSkip).size();
    for (const TrianglePair& p : oracleContacts(scene, AdjacentPairs::kBeyondShared)) {
      ++beyond;
      across += p.body_a != p.body_b;
    }
  }
  EXPECT_GT(skip, 1000U);
  EXPECT_GT(beyond, skip + 500);
  EXPECT_GT(across, 500U);
  EXPECT_GT(beyond - across, 500U);
}

}  // namespace
}  // namespace deformable_contact_monitor
