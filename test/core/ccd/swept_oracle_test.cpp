// The oracle of swept contacts: cases that are known by hand, the static oracle, invariances.
#include "swept/swept_oracle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "cgal_oracle.h"
#include "pair_sets.h"
#include "scenes.h"
#include "swept/random_swept_pairs.h"

namespace deformable_contact_monitor {
namespace {

constexpr AdjacentPairs kSkip = AdjacentPairs::kSkip, kBeyond = AdjacentPairs::kBeyondShared;

const Triangle kFloor{{{0, 0, 0}, {8, 0, 0}, {0, 8, 0}}};

Triangle pointAt(const Vec3f& p) { return {{p, p, p}}; }

std::optional<SweptTime> firstTime(const SweptPair& p, AdjacentPairs adjacent) {
  return firstSweptContact(p.a0, p.a1, p.b0, p.b1, adjacent);
}

bool operator==(const SweptTime& a, const SweptTime& b) {
  return a.low == b.low && a.high == b.high && a.is_attained == b.is_attained;
}

// A point that moves from `start` to `end`, against the floor.
std::optional<SweptTime> meetsFloor(const Vec3f& start, const Vec3f& end) {
  return firstSweptContact(pointAt(start), pointAt(end), kFloor, kFloor);
}

void expectAt(const mpq_class& time, const std::optional<SweptTime>& found) {
  ASSERT_TRUE(found);
  EXPECT_LE(found->low, time);
  EXPECT_GE(found->high, time);
  EXPECT_LE(found->high - found->low, mpq_class(1, 1 << 30));
  EXPECT_TRUE(found->is_attained);
}

TEST(SweptOracle, APointThroughATriangle) {
  expectAt({1, 2}, meetsFloor({1, 1, 1}, {1, 1, -1}));
  expectAt({1, 3}, meetsFloor({1, 1, 1}, {1, 1, -2}));
  expectAt(0, meetsFloor({1, 1, 0}, {1, 1, -2}));
  expectAt(1, meetsFloor({1, 1, 5}, {1, 1, 0}));
  EXPECT_FALSE(meetsFloor({1, 1, 5}, {1, 1, 1e-30F}));
  // Through an edge, a corner, the border's line beyond a corner.
  expectAt({1, 2}, meetsFloor({4, 4, 1}, {4, 4, -1}));
  expectAt({1, 2}, meetsFloor({8, 0, 1}, {8, 0, -1}));
  EXPECT_FALSE(meetsFloor({9, 0, 1}, {9, 0, -1}));
  EXPECT_FALSE(meetsFloor({4, 4 + 1e-6F, 1}, {4, 4 + 1e-6F, -1}));
  // The point moves within the plane, onto an edge or a corner.
  expectAt({1, 2}, meetsFloor({-1, 2, 0}, {1, 2, 0}));
  expectAt({1, 4}, meetsFloor({-1, -1, 0}, {3, 3, 0}));
  expectAt({1, 2}, meetsFloor({-1, 0, 0}, {1, 0, 0}));
  EXPECT_FALSE(meetsFloor({-1, 0.5F, 0}, {1, -1, 0}));
}

TEST(SweptOracle, WhatPiercesAllTheTimeHasNoEvent) {
  const Triangle through{{{2, 2, -9}, {2, 2, 9}, {3, 2, 9}}},
      shifted{{{2, 3, -9}, {2, 3, 9}, {3, 3, 9}}};
  expectAt(0, firstSweptContact(through, shifted, kFloor, kFloor));
}

// A wall that turns about the z axis, y = t x, as a segment in the plane z = 0 and as a triangle.
struct Wall {
  Triangle state0, state1;
};
const Wall kWalls[] = {
    {{{{0, 0, 0}, {16, 0, 0}, {16, 0, 0}}}, {{{0, 0, 0}, {16, 16, 0}, {0, 0, 0}}}},
    {{{{0, 0, -8}, {0, 0, 8}, {64, 0, 0}}}, {{{0, 0, -8}, {0, 0, 8}, {64, 64, 0}}}}};

TEST(SweptOracle, AnIrrationalTime) {
  for (const Wall& wall : kWalls) {
    // At (2 t, 1): 1 = 2 t^2.
    const std::optional<SweptTime> found =
        firstSweptContact(wall.state0, wall.state1, pointAt({0, 1, 0}), pointAt({2, 1, 0}));
    ASSERT_TRUE(found);
    EXPECT_TRUE(found->is_attained);
    EXPECT_LT(2 * found->low * found->low, 1);
    EXPECT_GT(2 * found->high * found->high, 1);
    EXPECT_LE(found->high - found->low, mpq_class(1, 1 << 30));
  }
}

TEST(SweptOracle, ATouchWithoutCrossing) {
  for (const Wall& wall : kWalls) {
    // At (1 - t, 1/4): (t - 1/2)^2. At (6 - 9 t, 1): (3 t - 1)^2.
    expectAt({1, 2}, firstSweptContact(wall.state0, wall.state1, pointAt({1, 0.25F, 0}),
                                       pointAt({0, 0.25F, 0})));
    expectAt({1, 3},
             firstSweptContact(wall.state0, wall.state1, pointAt({6, 1, 0}), pointAt({-3, 1, 0})));
    // A little farther off, by a part in 2^23.
    EXPECT_FALSE(sweptContact(wall.state0, wall.state1, pointAt({6, 1.0000001F, 0}),
                              pointAt({-3, 1.0000001F, 0})));
  }
}

TEST(SweptOracle, AnInfimumIsSaidToBeOne) {
  // Grows out of the shared point at t = 1/2 into the other triangle.
  const Triangle a0{{{0, 0, 0}, {-1, 0, 0}, {0, -1, 0}}}, a1{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  const std::optional<SweptTime> found = firstSweptContact(a0, a1, kFloor, kFloor, kBeyond);
  ASSERT_TRUE(found);
  EXPECT_EQ(mpq_class(1, 2), found->low);
  EXPECT_EQ(mpq_class(1, 2), found->high);
  EXPECT_FALSE(found->is_attained);
  EXPECT_FALSE(sweptContact(a0, a1, kFloor, kFloor, kSkip));
  // The other way round it is beyond from the start.
  const std::optional<SweptTime> back = firstSweptContact(a1, a0, kFloor, kFloor, kBeyond);
  ASSERT_TRUE(back);
  EXPECT_EQ(0, back->high);
  EXPECT_TRUE(back->is_attained);
}

TEST(SweptOracle, SharersCountWhereTheyFold) {
  const Vec3f p{0, 0, 0}, q{1, 0, 0};
  const Triangle still{{p, q, {0, 1, 0}}};
  const auto folds = [&](const Vec3f& start, const Vec3f& end) {
    return firstSweptContact({{p, q, start}}, {{p, q, end}}, still, still, kBeyond);
  };
  expectAt({1, 2}, folds({0, 1, 1}, {0, 1, -1}));
  EXPECT_FALSE(folds({0, -1, 1}, {0, -1, -1}));  // flat, and away from each other
  EXPECT_FALSE(folds({0, 1, 2}, {0, 1, 1}));
  // Points that coincide in one state are not shared.
  EXPECT_TRUE(sweptContact({{{5, 5, 5}, {6, 5, 5}, q}}, {{{5, 5, 5}, {6, 5, 5}, {1, 0, 1}}}, still,
                           still, kSkip));
}

TEST(SweptOracle, NoFloatIsTooSmallOrTooLargeOrNone) {
  const float tiny = std::numeric_limits<float>::denorm_min(), huge = 3e38F;
  expectAt({1, 2}, meetsFloor({tiny, tiny, tiny}, {tiny, tiny, -tiny}));
  EXPECT_FALSE(meetsFloor({1, 1, tiny}, {1, 1, huge}));
  expectAt(0, meetsFloor({1, 1, 0}, {1, 1, huge}));
  EXPECT_TRUE(meetsFloor({1, 1, huge}, {1, 1, -tiny}));
  for (const float bad : {std::numeric_limits<float>::infinity(), std::nanf("")}) {
    EXPECT_FALSE(meetsFloor({1, 1, 0}, {1, 1, bad}));
    EXPECT_FALSE(meetsFloor({1, bad, 0}, {1, 1, 0}));
  }
}

TEST(SweptOracle, WithoutMotionItIsTheStaticOracle) {
  std::mt19937 generator(11);
  int met = 0, sharing = 0;
  for (int round = 0; round < 3000; ++round) {
    SweptPair p = randomSweptPair(generator);
    p.a1 = p.a0;
    p.b1 = p.b0;
    const std::vector<Vec3f> shared = sharedAt(p, 0, 1);
    const OracleTriangle a{p.a0.v[0], p.a0.v[1], p.a0.v[2]}, b{p.b0.v[0], p.b0.v[1], p.b0.v[2]};
    const bool expected = meetBeyondByPredicates(a, b, shared);
    const std::optional<SweptTime> found = firstTime(p, kBeyond);
    ASSERT_EQ(expected, found.has_value()) << "round " << round;
    ASSERT_EQ(expected, sweptContact(p.a0, p.a1, p.b0, p.b1, kBeyond)) << "round " << round;
    ASSERT_EQ(expected && shared.empty(), sweptContact(p.a0, p.a1, p.b0, p.b1, kSkip));
    ASSERT_EQ(meetBeyondByPredicates(a, b, {}), sweptContact(p.a0, p.a1, p.b0, p.b1));
    if (expected) {
      ASSERT_TRUE(found->low == 0 && found->high == 0 && found->is_attained) << "round " << round;
    }
    met += expected;
    sharing += !shared.empty();
  }
  EXPECT_GT(met, 500);
  EXPECT_GT(sharing, 500);
}

// Vertex by vertex.
template <typename Map>
SweptPair mapped(SweptPair p, const Map& map0, const Map& map1) {
  for (int i = 0; i < 3; ++i) {
    for (Triangle* t : {&p.a0, &p.b0}) t->v[i] = map0(t->v[i]);
    for (Triangle* t : {&p.a1, &p.b1}) t->v[i] = map1(t->v[i]);
  }
  return p;
}

template <typename Map>
SweptPair mapped(const SweptPair& p, const Map& map) {
  return mapped(p, map, map);
}

TEST(SweptOracle, DependsOnNoOrderAxisScaleOrCommonMotion) {
  std::mt19937 generator(12);
  for (int round = 0; round < 250; ++round) {
    const SweptPair p = randomSweptPair(generator);
    const auto turned = [](const Triangle& t) { return Triangle{{t.v[2], t.v[0], t.v[1]}}; };
    const auto swapped = [](const Triangle& t) { return Triangle{{t.v[1], t.v[0], t.v[2]}}; };
    using Map = Vec3f (*)(const Vec3f&);
    const Map moved0 = [](const Vec3f& v) { return v + Vec3f{5, -3, 70}; };
    const Map moved1 = [](const Vec3f& v) { return v + Vec3f{-9, 64, 2}; };
    const SweptPair same[] = {{p.b0, p.b1, p.a0, p.a1},
                              {turned(p.a0), turned(p.a1), swapped(p.b0), swapped(p.b1)},
                              mapped(p,
                                     [](const Vec3f& v) {
                                       return Vec3f{v.y, v.z, v.x};
                                     }),
                              mapped(p,
                                     [](const Vec3f& v) {
                                       return Vec3f{v.y, v.x, v.z};
                                     }),
                              mapped(p,
                                     [](const Vec3f& v) {
                                       return Vec3f{v.x, -v.y, v.z};
                                     }),
                              mapped(p, [](const Vec3f& v) { return v * std::ldexp(1.0F, 100); }),
                              mapped(p, [](const Vec3f& v) { return v * std::ldexp(1.0F, -140); }),
                              mapped(p, moved0, moved1)};
    for (const AdjacentPairs adjacent : {kSkip, kBeyond}) {
      const std::optional<SweptTime> first = firstTime(p, adjacent);
      for (const SweptPair& other : same) {
        const std::optional<SweptTime> found = firstTime(other, adjacent);
        ASSERT_EQ(first.has_value(), found.has_value()) << "round " << round;
        if (!first) continue;
        ASSERT_TRUE(*first == *found) << "round " << round;
      }
      ASSERT_EQ(first.has_value(), sweptContact(p.a1, p.a0, p.b1, p.b0, adjacent))
          << "backwards, round " << round;
    }
  }
}

TEST(SweptOracle, AStepIsItsHalves) {
  std::mt19937 generator(13);
  for (int round = 0; round < 500; ++round) {
    const SweptPair p = mapped(randomSweptPair(generator), [](const Vec3f& v) { return v * 2.0F; });
    const Triangle a = at(p.a0, p.a1, 1, 2), b = at(p.b0, p.b1, 1, 2);
    const auto half = [](const Triangle& t) {
      return Triangle{{t.v[0] * 0.5F, t.v[1] * 0.5F, t.v[2] * 0.5F}};
    };
    ASSERT_EQ(sweptContact(p.a0, p.a1, p.b0, p.b1), sweptContact(p.a0, half(a), p.b0, half(b)) ||
                                                        sweptContact(half(a), p.a1, half(b), p.b1))
        << "round " << round;
  }
}

TEST(SweptOracle, ScenesAreJudgedPairByPair) {
  // Two soups of one body each; everything is enabled. Body 1 is posed in both states.
  std::mt19937 generator(14);
  Scene scene[2];
  std::vector<SweptPair> pairs(12);
  std::vector<Triangle> triangles[2][2];  // state, body
  for (SweptPair& p : pairs) {
    p = randomSweptPair(generator);
    triangles[0][0].push_back(p.a0);
    triangles[1][0].push_back(p.a1);
    triangles[0][1].push_back(p.b0);
    triangles[1][1].push_back(p.b1);
  }
  triangles[1][0].back().v[0].x = std::nanf("");
  for (int state = 0; state < 2; ++state) {
    scene[state] = pairScene(meshOf(triangles[state][0]), meshOf(triangles[state][1]));
    RigidTransform pose;
    pose.translation[0] = 1 + state;
    scene[state].setPose(1, pose);
    for (BodyId b : {0U, 1U}) scene[state].setPairEnabled(b, b, true);
  }
  std::vector<TrianglePair> expected;
  const auto posed = [&](std::uint32_t i, int state) {
    Triangle t = triangles[state][i / 12][i % 12];
    for (Vec3f& v : t.v) v.x += i < 12 ? 0.0F : static_cast<float>(1 + state);
    return t;
  };
  for (std::uint32_t i = 0; i < 24; ++i) {
    for (std::uint32_t j = i + 1; j < 24; ++j) {
      const Triangle a0 = posed(i, 0), a1 = posed(i, 1), b0 = posed(j, 0), b1 = posed(j, 1);
      const bool meet =
          i / 12 == j / 12 ? sweptContact(a0, a1, b0, b1, kBeyond) : sweptContact(a0, a1, b0, b1);
      if (meet) expected.emplace_back(i / 12, i % 12, j / 12, j % 12);
    }
  }
  EXPECT_GT(expected.size(), 40U);
  EXPECT_TRUE(samePairs(expected, oracleSweptContacts(scene[0], scene[1], kBeyond)));
  EXPECT_EQ(
      sweptPairs(scene[0].body(0).mesh, scene[1].body(0).mesh, kBeyond).size(),
      static_cast<std::size_t>(std::count_if(expected.begin(), expected.end(),
                                             [](const TrianglePair& p) { return p.body_b == 0; })));
}

}  // namespace
}  // namespace deformable_contact_monitor
