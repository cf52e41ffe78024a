// Steps by name: what tunnels, what only touches, when, what is degenerate.
#include <gtest/gtest.h>

#include <cmath>

#include "scenes.h"
#include "swept_expected.h"

namespace deformable_contact_monitor {
namespace {

const Triangle kSheet{{{0, 0, 0}, {8, 0, 0}, {0, 8, 0}}};

MovingTriangle still(const Triangle& t) { return {t, t}; }

MovingTriangle moved(const Triangle& t, const Vec3f& step) {
  return {t, {{t.v[0] + step, t.v[1] + step, t.v[2] + step}}};
}

Triangle pointAt(const Vec3f& p) { return {{p, p, p}}; }

// A wall that turns about the z axis, y = t x.
const MovingTriangle kWall{{{{0, 0, -8}, {0, 0, 8}, {64, 0, 0}}},
                           {{{0, 0, -8}, {0, 0, 8}, {64, 64, 0}}}};

class SweptEvents : public SweptFixture {
 protected:
  // As bodies that are each other's first, and with other triangles about them, so that there are
  // clusters; the pair alone is a contact, first at `time` (for what is rational and not dyadic,
  // by the rounded number).
  void expectFirstAt(double time, const MovingTriangle& a, const MovingTriangle& b) {
    for (const bool swap : {false, true}) {
      for (const int others : {0, 40}) {
        const DetectionResult& result = detect(swap ? b : a, swap ? a : b, others);
        ASSERT_TRUE(samePairs({{0, 0, 1, 0}}, result.contacts)) << others << " others";
        const FirstContact& first = result.first_times[0];
        EXPECT_LE(first.low, time);
        EXPECT_GE(first.high, time);
        EXPECT_LE(first.high - first.low, 0x1p-20F);
      }
    }
  }

  // None at either end.
  void expectPassedAt(double time, const MovingTriangle& a, const MovingTriangle& b) {
    expectFirstAt(time, a, b);
    const Scene scene = movingPairScene({a}, {b});
    EXPECT_TRUE(contacts(earlierScene(scene)).empty());
    EXPECT_TRUE(contacts(laterScene(scene)).empty());
  }

  void expectNone(const MovingTriangle& a, const MovingTriangle& b) {
    for (const bool swap : {false, true}) {
      for (const int others : {0, 40}) {
        EXPECT_TRUE(detect(swap ? b : a, swap ? a : b, others).contacts.empty());
      }
    }
  }

 private:
  const DetectionResult& detect(const MovingTriangle& a, const MovingTriangle& b, int others) {
    std::vector<MovingTriangle> of_a{a}, of_b{b};
    for (int i = 0; i < others; ++i) {  // they pass one another, a little apart
      const Vec3f place{static_cast<float>(i % 7), static_cast<float>(i / 7), 100};
      const Triangle t{{place, place + Vec3f{0.5F, 0, 0.5F}, place + Vec3f{0, 0.5F, 0}}};
      of_a.push_back(moved(t, {7, 0, 0}));
      of_b.push_back(
          moved({{t.v[0] + Vec3f{7, 0, 1}, t.v[1] + Vec3f{7, 0, 1}, t.v[2] + Vec3f{7, 0, 1}}},
                {-7, 0, 0}));
    }
    Options options = timedOptions();
    options.clusters = others > 0 ? 5 : 0;
    return detector_->detect(movingPairScene(of_a, of_b), options);
  }
};

TEST_P(SweptEvents, TunnellingThroughTheFace) {
  expectPassedAt(1.0 / 3, still(kSheet), moved({{{1, 1, 1}, {1, 2, 1}, {2, 1, 2}}}, {0, 0, -3}));
  expectPassedAt(0.5, moved(kSheet, {0, 0, 4}),
                 moved({{{1, 1, 4}, {1, 2, 5}, {2, 1, 6}}}, {0, 0, -4}));
  // A segment and a point.
  expectPassedAt(0.25, still(kSheet), moved({{{1, 1, 1}, {2, 2, 2}, {1, 1, 1}}}, {0, 0, -4}));
  expectPassedAt(0.25, still(kSheet), moved(pointAt({3, 3, 1}), {0, 0, -4}));
}

TEST_P(SweptEvents, TunnellingThroughTheBorderExactly) {
  // A point through an edge, a corner, and just beside them.
  expectPassedAt(0.5, still(kSheet), moved(pointAt({4, 4, 1}), {0, 0, -2}));
  expectPassedAt(0.5, still(kSheet), moved(pointAt({4, 0, 1}), {0, 0, -2}));
  expectPassedAt(0.5, still(kSheet), moved(pointAt({8, 0, 1}), {0, 0, -2}));
  expectPassedAt(0.5, still(kSheet), moved(pointAt({0, 0, 1}), {0, 0, -2}));
  expectNone(still(kSheet), moved(pointAt({4, std::nextafter(4.0F, 5.0F), 1}), {0, 0, -2}));
  expectNone(still(kSheet), moved(pointAt({4, -0x1p-149F, 1}), {0, 0, -2}));
  expectNone(still(kSheet), moved(pointAt({std::nextafter(8.0F, 9.0F), 0, 1}), {0, 0, -2}));
  // The tip of a triangle, the rest of which is beyond the border.
  expectPassedAt(0.25, still(kSheet), moved({{{4, 0, 1}, {3, -1, 3}, {5, -1, 3}}}, {0, 0, -4}));
  expectPassedAt(0.25, still(kSheet), moved({{{0, 0, 1}, {-1, -1, 3}, {-1, 0, 3}}}, {0, 0, -4}));
  expectPassedAt(0.25, still(kSheet), moved({{{8, 0, 1}, {9, -1, 3}, {10, 0, 3}}}, {0, 0, -4}));
}

TEST_P(SweptEvents, TunnellingEdgeThroughEdge) {
  expectPassedAt(0.0625, still(kSheet),
                 moved({{{-3, -3, 0}, {-1, 2, -1}, {-1, 2, 1}}}, {16, 0, 0}));
  // Vertex onto vertex.
  expectPassedAt(0.5, moved(pointAt({-1, 0, 0}), {2, 0, 0}), moved(pointAt({0, 1, 0}), {0, -2, 0}));
  // Segments, end onto edge.
  expectPassedAt(0.5, still({{{0, 0, 0}, {4, 0, 0}, {4, 0, 0}}}),
                 moved({{{2, 0, 1}, {2, 5, 1}, {2, 0, 1}}}, {0, 0, -2}));
}

// A fast point between a sheet's two states: the sheet moves more than its size.
TEST_P(SweptEvents, BothMoveFast) {
  expectPassedAt(0.5, moved(kSheet, {1024, 0, 4}), moved(pointAt({1, 1, 4}), {1024, 0, -4}));
  expectNone(moved(kSheet, {1024, 0, 4}), moved(pointAt({1, 1, 4}), {-1024, 0, -4}));
  expectPassedAt(1018.0 / 2048, moved(kSheet, {1024, 0, 0}),
                 moved(pointAt({1025, 1, 0}), {-1024, 0, 0}));
}

TEST_P(SweptEvents, AtTheEnds) {
  expectFirstAt(0, still(kSheet), moved(pointAt({1, 1, 0}), {0, 0, 5}));
  expectFirstAt(1, still(kSheet), moved(pointAt({1, 1, 5}), {0, 0, -5}));
  expectNone(still(kSheet), {pointAt({1, 1, 5}), pointAt({1, 1, 0x1p-149F})});
  expectNone(still(kSheet), {pointAt({1, 1, 0x1p-149F}), pointAt({1, 1, 5})});
}

TEST_P(SweptEvents, TouchesWithoutCrossing) {
  // At (1 - t, 1/4): (t - 1/2)^2. At (6 - 9 t, 1): (3 t - 1)^2. At (2 - t, 1): (t - 1)^2.
  expectPassedAt(0.5, kWall, {pointAt({1, 0.25F, 0}), pointAt({0, 0.25F, 0})});
  expectPassedAt(1.0 / 3, kWall, {pointAt({6, 1, 0}), pointAt({-3, 1, 0})});
  expectFirstAt(1, kWall, {pointAt({2, 1, 0}), pointAt({1, 1, 0})});
  expectNone(kWall, {pointAt({6, 1.0000001F, 0}), pointAt({-3, 1.0000001F, 0})});
  expectNone(kWall, {pointAt({1, 0.25000003F, 0}), pointAt({0, 0.25000003F, 0})});
  // At t = 0, and away from it.
  expectFirstAt(0, kWall, {pointAt({1, 0, 0}), pointAt({1, 5, 0})});
}

TEST_P(SweptEvents, IrrationalTimes) {
  // At (2 t, 1): 1 = 2 t^2. At (t, 1/3): t^2 = float(1/3).
  expectPassedAt(std::sqrt(0.5), kWall, {pointAt({0, 1, 0}), pointAt({2, 1, 0})});
  expectPassedAt(std::sqrt(static_cast<double>(1.0F / 3)), kWall,
                 {pointAt({0, 1.0F / 3, 0}), pointAt({1, 1.0F / 3, 0})});
}

// Above a wall y = (t - 1/2) x, at (t - 1/2, 2^-82): the two roots are 2^-40 apart. At height 0
// they are one, below there is none.
TEST_P(SweptEvents, RootsThatLieCloseTogether) {
  const MovingTriangle wall{{{{-64, 32, -8}, {64, -32, -8}, {0, 0, 64}}},
                            {{{-64, -32, -8}, {64, 32, -8}, {0, 0, 64}}}};
  const auto flight = [](float height) {
    return MovingTriangle{pointAt({-0.5F, height, 0}), pointAt({0.5F, height, 0})};
  };
  expectPassedAt(0.5 - 0x1p-41, wall, flight(0x1p-82F));
  expectPassedAt(0.5, wall, flight(0));
  expectNone(wall, flight(-0x1p-82F));
}

TEST_P(SweptEvents, WhatPiercesAllTheTimeIsInContactAtTheStart) {
  expectFirstAt(0, moved({{{2, 2, -9}, {2, 2, 9}, {3, 2, 9}}}, {0, 1, 0}), still(kSheet));
}

TEST_P(SweptEvents, InOnePlane) {
  // Onto an edge, onto a corner, past it; with a plane that moves.
  for (const float rise : {0.0F, 3.0F}) {
    const MovingTriangle sheet = moved(kSheet, {0, 0, rise});
    expectPassedAt(0.5, sheet, moved(pointAt({-10, 9, 0}), {20, -16, rise}));
    expectFirstAt(0.5, sheet, moved(pointAt({-1, 2, 0}), {2, 0, rise}));
    expectFirstAt(0.25, sheet, moved(pointAt({-1, -1, 0}), {4, 4, rise}));
    expectPassedAt(0.5, sheet, moved(pointAt({-1, 1, 0}), {2, -2, rise}));
    expectNone(sheet, moved(pointAt({-1, 0.5F, 0}), {2, -2, rise}));
    // Triangles: a corner onto an edge, an edge along an edge.
    expectFirstAt(0.5, sheet, moved({{{-1, 1, 0}, {-2, 1, 0}, {-2, 2, 0}}}, {2, 0, rise}));
    expectFirstAt(0.5, sheet, moved({{{-1, 1, 0}, {-1, 3, 0}, {-2, 2, 0}}}, {2, 0, rise}));
  }
}

TEST_P(SweptEvents, OnOneLine) {
  const MovingTriangle bar = still({{{0, 0, 0}, {4, 0, 0}, {2, 0, 0}}});
  expectFirstAt(0.5, bar, moved({{{5, 0, 0}, {7, 0, 0}, {6, 0, 0}}}, {-2, 0, 0}));
  expectPassedAt(1.0 / 12, bar, moved({{{5, 0, 0}, {7, 0, 0}, {6, 0, 0}}}, {-12, 0, 0}));
  expectNone(bar, moved({{{5, 0, 0}, {7, 0, 0}, {6, 0, 0}}}, {-0.5F, 0, 0}));
}

TEST_P(SweptEvents, DegenerateAtOneTimeAlone) {
  // The sheet collapses onto a segment at t = 1/2, and the point is there then, and only then.
  const MovingTriangle collapsing{{{{0, 0, 0}, {8, 0, 0}, {4, 4, 0}}},
                                  {{{0, 0, 0}, {8, 0, 0}, {4, -4, 0}}}};
  expectPassedAt(0.5, collapsing, moved(pointAt({4, 0, 1}), {0, 0, -2}));
  // Onto a point.
  const MovingTriangle to_point{{{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}},
                                {{{1, 1, 0}, {-1, 1, 0}, {0, -1, 0}}}};
  expectPassedAt(0.5, to_point, moved(pointAt({0, 0, 1}), {0, 0, -2}));
  expectNone(to_point, moved(pointAt({0.001F, 0, 1}), {0, 0, -2}));
}

// Neighbours in one body: by trajectories, so points that coincide in one state touch there.
TEST_P(SweptEvents, SharedVerticesAreSharedTrajectories) {
  const Vec3f p{0, 0, 0}, q{4, 0, 0};
  const auto found = [&](const MovingTriangle& a, const MovingTriangle& b, AdjacentPairs adjacent) {
    return detector_->detect(movingSelfScene({a, b}), timedOptions(adjacent));
  };
  const MovingTriangle sheet = still({{p, q, {0, 4, 0}}});
  // It folds flat onto its neighbour at 1/2.
  const MovingTriangle folding{{{p, q, {0, 4, 4}}}, {{p, q, {0, 4, -4}}}};
  EXPECT_TRUE(found(sheet, folding, AdjacentPairs::kSkip).contacts.empty());
  const DetectionResult& fold = found(sheet, folding, AdjacentPairs::kBeyondShared);
  ASSERT_EQ(fold.contacts.size(), 1U);
  EXPECT_LE(fold.first_times[0].low, 0.5F);
  EXPECT_GE(fold.first_times[0].high, 0.5F);
  // Away from it: flat, and never folded.
  const MovingTriangle opening{{{p, q, {0, -4, 4}}}, {{p, q, {0, -4, -4}}}};
  EXPECT_TRUE(found(sheet, opening, AdjacentPairs::kBeyondShared).contacts.empty());
  // The corner q is the sheet's at the end alone.
  const MovingTriangle arriving{{{{4, 0, 5}, {9, 0, 5}, {9, 1, 5}}}, {{q, {9, 0, 0}, {9, 1, 1}}}};
  for (const AdjacentPairs adjacent : kBothAdjacent) {
    const DetectionResult& result = found(sheet, arriving, adjacent);
    ASSERT_EQ(result.contacts.size(), 1U);
    EXPECT_EQ(result.first_times[0].high, 1);
  }
}

INSTANTIATE_TEST_SUITE_P(, SweptEvents, ::testing::ValuesIn(sweptBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
