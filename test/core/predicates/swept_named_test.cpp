// Swept contacts by name: what tunnels, what only touches, what is degenerate, and the extremes.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/predicates/swept_exact.h"
#include "moving_pairs.h"

namespace deformable_contact_monitor {
namespace {

SweptVerdict verdictOf(const MovingPair& pair, bool wants_time = true) {
  PredicateState state;
  return sweptVerdict(pair.a, pair.b, sharedTrajectories(pair.a, pair.b),
                      AdjacentPairs::kBeyondShared, wants_time, state);
}

// None at either end, and one first at `time`, whichever is a and whichever is b.
void expectPassedAt(const MovingPair& pair, double time) {
  PredicateState state;
  const SharedVertices shared = sharedTrajectories(pair.a, pair.b);
  EXPECT_FALSE(detail::meetInState(pair.a.from, pair.b.from, shared, state));
  EXPECT_FALSE(detail::meetInState(pair.a.to, pair.b.to, shared, state));
  for (const MovingPair& p : {pair, MovingPair{pair.b, pair.a}}) {
    const SweptVerdict verdict = verdictOf(p);
    ASSERT_EQ(verdict.part, PartVerdict::kMeet);
    EXPECT_EQ(verdictOf(p, false).part, PartVerdict::kMeet);
    EXPECT_LE(verdict.first_low, time);
    EXPECT_GE(verdict.first_high, time);
    EXPECT_LE(verdict.first_high - verdict.first_low, 1.0F / (1 << 20));
  }
}

void expectFirstAt(const MovingPair& pair, double time) {
  const SweptVerdict verdict = verdictOf(pair);
  ASSERT_EQ(verdict.part, PartVerdict::kMeet);
  EXPECT_LE(verdict.first_low, time);
  EXPECT_GE(verdict.first_high, time);
}

void expectNone(const MovingPair& pair) {
  for (const bool wants_time : {false, true}) {
    EXPECT_EQ(verdictOf(pair, wants_time).part, PartVerdict::kApart);
    EXPECT_EQ(verdictOf({pair.b, pair.a}, wants_time).part, PartVerdict::kApart);
  }
}

MovingTriangle still(const Triangle& t) { return {t, t}; }

MovingTriangle moved(const Triangle& t, const Vec3f& step) {
  return {t, {{t.v[0] + step, t.v[1] + step, t.v[2] + step}}};
}

const Triangle kSheet{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};

TEST(SweptTunnelling, ThroughTheFace) {
  expectPassedAt({still(kSheet), moved({{{1, 1, 1}, {1, 2, 1}, {2, 1, 2}}}, {0, 0, -3})}, 1.0 / 3);
}

// Its lowest vertex is above the border or a corner, the rest beyond: it touches at one time alone.
TEST(SweptTunnelling, ThroughTheBorderExactly) {
  expectPassedAt({still(kSheet), moved({{{2, 0, 1}, {1, -1, 3}, {3, -1, 3}}}, {0, 0, -4})}, 0.25);
  expectPassedAt({still(kSheet), moved({{{2, 2, 1}, {3, 3, 3}, {3, 4, 3}}}, {0, 0, -4})}, 0.25);
}

TEST(SweptTunnelling, ThroughAnEdgeOfBoth) {
  expectPassedAt({still(kSheet), moved({{{-3, -3, 0}, {-1, 2, -1}, {-1, 2, 1}}}, {8, 0, 0})},
                 0.125);
}

TEST(SweptTunnelling, ThroughAVertexExactly) {
  expectPassedAt({still(kSheet), moved({{{0, 0, 1}, {-1, -1, 3}, {-1, 0, 3}}}, {0, 0, -4})}, 0.25);
  expectPassedAt({still(kSheet), moved({{{4, 0, 1}, {5, -1, 3}, {6, 0, 3}}}, {0, 0, -4})}, 0.25);
}

TEST(SweptTunnelling, PastTheBorderByTheSmallestStep) {
  const float near = std::nextafter(0.0F, -1.0F);
  expectNone({still(kSheet), moved({{{2, near, 1}, {1, -1, 3}, {3, -1, 3}}}, {0, 0, -4})});
}

// The corner of b is at height t - 1/4 - t^2 + gap over a's plane, which turns: -(t - 1/2)^2 + gap.
MovingPair touching(float gap) {
  const Triangle from{{{0, 0, 0}, {8, 0, 0}, {0, 8, -8 * gap}}};
  const Triangle to{{{0, 0, 0}, {8, 0, 8}, {0, 8, -8 * gap}}};
  return {{from, to}, moved({{{0, 1, -0.25F}, {0, 1, -20}, {1, 1, -20}}}, {1, 0, 1})};
}

TEST(SweptTouch, WithoutCrossingAtADyadicTime) {
  expectPassedAt(touching(0), 0.5);
  expectNone(touching(std::ldexp(-1.0F, -140)));
}

TEST(SweptTouch, RootsOf2ToTheMinus40Apart) {
  expectPassedAt(touching(std::ldexp(1.0F, -82)), 0.5);
  expectNone(touching(std::ldexp(-1.0F, -82)));
}

// As above, with -(3 t - 1)^2 / 9.
TEST(SweptTouch, WithoutCrossingAtARationalTime) {
  const Triangle from{{{0, 0, 0}, {8, 0, 0}, {0, 8, 0}}}, to{{{0, 0, 0}, {8, 0, 72}, {0, 8, 0}}};
  const Triangle b{{{0, 1, -1}, {0, 1, -90}, {1, 1, -90}}};
  expectPassedAt({{from, to}, moved(b, {1, 0, 6})}, 1.0 / 3);
}

// p = (2 t, 1, 1) crosses the plane of the face 0, (2, 2 t, 2 t), (0, 0, 5) where it is on the line
// of the first two: at 2 t^2 = 1.
TEST(SweptTouch, OnTheBorderAtAnIrrationalTime) {
  const Triangle from{{{0, 0, 0}, {2, 0, 0}, {0, 0, 5}}}, to{{{0, 0, 0}, {2, 2, 2}, {0, 0, 5}}};
  const Triangle b{{{0, 1, 1}, {5, 20, -30}, {6, 20, -30}}};
  expectFirstAt({{from, to}, moved(b, {2, 0, 0})}, std::sqrt(0.5));
}

TEST(SweptTouch, AtTheStartAndAtTheEnd) {
  const MovingTriangle leaving = moved({{{1, 1, 0}, {1, 1, 2}, {2, 1, 2}}}, {0, 0, 1});
  const SweptVerdict start = verdictOf({still(kSheet), leaving});
  EXPECT_EQ(start.part, PartVerdict::kMeet);
  EXPECT_EQ(start.first_high, 0);
  const SweptVerdict end = verdictOf({still(kSheet), reversed(leaving)});
  EXPECT_EQ(end.part, PartVerdict::kMeet);
  EXPECT_EQ(end.first_low, 1);
  EXPECT_EQ(end.first_high, 1);
}

TEST(SweptTouch, PiercingAllTheTimeHasNoEvent) {
  const MovingPair pair{moved(kSheet, {1, 2, 3}),
                        moved({{{1, 1, 2}, {1, 1, -2}, {9, 9, 1}}}, {1, 2, 3})};
  const SweptVerdict verdict = verdictOf(pair);
  EXPECT_EQ(verdict.part, PartVerdict::kMeet);
  EXPECT_EQ(verdict.first_high, 0);
}

// All in the plane z = 0 at all times.
TEST(SweptInOnePlane, AVertexComesToAnEdge) {
  const Triangle b{{{-2, 1, 0}, {-5, 1, 0}, {-5, 2, 0}}};
  expectFirstAt({still(kSheet), moved(b, {4, 0, 0})}, 0.5);
  expectNone({still(kSheet), moved(b, {0, 4, 0})});
}

TEST(SweptInOnePlane, AVertexComesToAnEdgeOfItsFace) {
  for (int turn = 0; turn < 3; ++turn) {
    Feature feature{FeatureKind::kVertexFace, {{}, {}, {}, {{-2, 1, 0}, {2, 1, 0}}}};
    for (int i = 0; i < 3; ++i) feature.x[i] = {kSheet.v[(i + turn) % 3], kSheet.v[(i + turn) % 3]};
    const FirstTime time = exactFeatureTime(feature, true);
    EXPECT_EQ(time.low, 0.5F);
    EXPECT_EQ(time.high, 0.5F);
  }
}

TEST(SweptInOnePlane, AVertexComesToAVertex) {
  const Triangle b{{{-2, 6, 0}, {-5, 7, 0}, {-5, 8, 0}}};
  expectFirstAt({still(kSheet), moved(b, {4, -4, 0})}, 0.5);
}

TEST(SweptInOnePlane, EdgesOnOneLineMeetEndToEnd) {
  const MovingTriangle a = still({{{0, 0, 0}, {1, 2, 3}, {1, 2, 3}}});
  const Triangle b{{{3, 6, 9}, {4, 8, 12}, {4, 8, 12}}};
  expectFirstAt({a, moved(b, {-4, -8, -12})}, 0.5);
  expectNone({a, moved(b, {-1, -2, -3})});
}

// Any two ends of two segments on one line, which come from apart.
TEST(SweptInOnePlane, EachEndMeetsEachEnd) {
  const MovingPoint near{{0, 0, 0}, {0, 0, 0}}, far{{-1, -2, -3}, {-1, -2, -3}};
  const MovingPoint coming{{2, 4, 6}, {-2, -4, -6}}, behind{{3, 6, 9}, {2, 4, 6}};
  for (const bool turn_first : {false, true}) {
    for (const bool turn_second : {false, true}) {
      const FirstTime time =
          exactFeatureTime({FeatureKind::kEdgeEdge,
                            {turn_first ? far : near, turn_first ? near : far,
                             turn_second ? behind : coming, turn_second ? coming : behind}},
                           true);
      EXPECT_EQ(time.low, 0.5F);
      EXPECT_EQ(time.high, 0.5F);
    }
  }
}

TEST(SweptDegenerate, PointsMeet) {
  const MovingTriangle point = still({{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}});
  const MovingTriangle passing = moved({{{-1, -2, -3}, {-1, -2, -3}, {-1, -2, -3}}}, {2, 4, 6});
  expectPassedAt({point, passing}, 0.5);
  MovingTriangle missing = passing;
  for (Vec3f& v : missing.to.v) v.z = std::nextafter(3.0F, 4.0F);
  expectNone({point, missing});
}

TEST(SweptDegenerate, ParallelSegmentsMeetAlongTheirLength) {
  const MovingTriangle a = still({{{0, 0, 0}, {4, 0, 0}, {4, 0, 0}}});
  expectPassedAt({a, moved({{{1, 1, -2}, {2, 1, -2}, {2, 1, -2}}}, {0, -4, 8})}, 0.25);
  expectNone({a, moved({{{5, 1, -2}, {6, 1, -2}, {6, 1, -2}}}, {0, -4, 8})});
}

// Flat where it meets the other one, and nowhere else.
TEST(SweptDegenerate, ASegmentAtTheTimeOfContactAlone) {
  const MovingTriangle turning{{{{0, 0, 0}, {4, 0, 0}, {2, 4, 4}}},
                               {{{0, 0, 0}, {4, 0, 0}, {2, -4, -4}}}};
  const Triangle b{{{1, 0, -4}, {1, 0, -6}, {2, 0, -6}}};
  expectFirstAt({turning, moved(b, {0, 0, 8})}, 0.5);
}

TEST(SweptDegenerate, ATriangleThatIsAPointAtTheStart) {
  const MovingTriangle growing{{{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}},
                               {{{1, 1, -1}, {1, 2, -1}, {2, 1, -1}}}};
  expectPassedAt({still(kSheet), growing}, 0.5);
}

const Vec3f kP{0, 0, 0}, kQ{4, 0, 0};

TEST(SweptBeyondShared, AnEdgeFoldsFlatAndOn) {
  const MovingTriangle a = still({{kP, kQ, {1, 3, 0}}});
  const MovingTriangle closing{{{kP, kQ, {2, 3, 1}}}, {{kP, kQ, {2, 3, -1}}}};
  const MovingTriangle flattening{{{kP, kQ, {2, -3, 1}}}, {{kP, kQ, {2, -3, -1}}}};
  expectPassedAt({a, closing}, 0.5);
  expectNone({a, flattening});
}

TEST(SweptBeyondShared, AnEdgeFoldsFlatAtTheEnd) {
  const MovingTriangle a = still({{kP, kQ, {1, 3, 0}}});
  expectFirstAt({a, {{{kP, kQ, {2, 3, 1}}}, {{kP, kQ, {2, 3, 0}}}}}, 1);
}

TEST(SweptBeyondShared, InOnePlaneAnEdgeFoldsWhereATriangleTurnsOver) {
  const MovingTriangle a = still({{kP, kQ, {1, -3, 0}}});
  const MovingTriangle b{{{kP, kQ, {2, 3, 0}}}, {{kP, kQ, {2, -1, 0}}}};
  const SweptVerdict verdict = verdictOf({a, b});  // from right after 3/4 on
  ASSERT_EQ(verdict.part, PartVerdict::kMeet);
  EXPECT_LE(verdict.first_low, 0.75F);
  EXPECT_GT(verdict.first_high, 0.75F);
}

TEST(SweptBeyondShared, AVertexSwingsThroughTheOtherTriangle) {
  const MovingTriangle a = still({{kP, {4, 0, 0}, {0, 4, 0}}});
  const MovingTriangle swinging{{{kP, {1, 1, 1}, {1, 1, 2}}}, {{kP, {1, 1, -2}, {1, 1, -1}}}};
  expectPassedAt({a, swinging}, 1.0 / 3);
  const MovingTriangle beside{{{kP, {-1, -1, 1}, {-1, -1, 2}}}, {{kP, {-1, -1, -2}, {-1, -1, -1}}}};
  expectNone({a, beside});
}

// At t = 1/3 both opposite edges run through the shared vertex, and cross in it alone.
TEST(SweptBeyondShared, OppositeEdgesCrossInTheSharedVertex) {
  const MovingTriangle a{{{kP, {-1, 0, 1}, {1, 0, 1}}}, {{kP, {-1, 0, -2}, {1, 0, -2}}}};
  const MovingTriangle b{{{kP, {0, -1, -1}, {0, 1, -1}}}, {{kP, {0, -1, 2}, {0, 1, 2}}}};
  expectNone({a, b});
}

// The triangles are in contact at all times except both ends, when a's edge runs through the shared
// vertex.
TEST(SweptBeyondShared, InAnOpenInterval) {
  const MovingTriangle a{{{kP, {1, 0, 0}, {-1, 0, 0}}}, {{kP, {1, 1, 0}, {-2, -2, 0}}}};
  const MovingTriangle b = still({{kP, {0, -1, 1}, {0, -1, -1}}});
  const SweptVerdict verdict = verdictOf({a, b});
  ASSERT_EQ(verdict.part, PartVerdict::kMeet);
  EXPECT_EQ(verdict.first_low, 0);
  EXPECT_GT(verdict.first_high, 0);
  EXPECT_LE(verdict.first_high, 1.0F / (1 << 20));
}

TEST(SweptBeyondShared, OpeningOutOfTheSharedVertex) {
  const MovingTriangle a{{{kP, kP, kP}}, {{kP, {4, 0, 0}, {0, 4, 0}}}};
  const SweptVerdict into = verdictOf({a, still({{kP, {1, 1, 1}, {1, 1, -1}}})});
  ASSERT_EQ(into.part, PartVerdict::kMeet);
  EXPECT_EQ(into.first_low, 0);
  EXPECT_GT(into.first_high, 0);
  expectNone({a, still({{kP, {-1, -1, 1}, {-1, -1, -1}}})});
}

TEST(SweptBeyondShared, APointSharedInOneStateAloneIsATouch) {
  const MovingTriangle a = still(kSheet);
  const MovingTriangle b{{{{0, 0, 0}, {-1, -1, 1}, {-1, -1, 2}}},
                         {{{0, -1, 1}, {-1, -2, 2}, {-1, -2, 3}}}};
  EXPECT_FALSE(sharedTrajectories(a, b).any);
  const SweptVerdict verdict = verdictOf({a, b});
  EXPECT_EQ(verdict.part, PartVerdict::kMeet);
  EXPECT_EQ(verdict.first_high, 0);
}

TEST(SweptBeyondShared, MinusZeroIsZeroAndSkipLeavesThemOut) {
  const MovingTriangle a = still(kSheet);
  const MovingTriangle b = still({{{-0.0F, 0, -0.0F}, {1, 1, 1}, {1, 1, -1}}});
  const SharedVertices shared = sharedTrajectories(a, b);
  EXPECT_TRUE(shared.in_a[0] && shared.in_b[0]);
  PredicateState state;
  EXPECT_EQ(sweptVerdict(a, b, shared, AdjacentPairs::kBeyondShared, true, state).part,
            PartVerdict::kMeet);
  EXPECT_EQ(sweptVerdict(a, b, shared, AdjacentPairs::kSkip, true, state).part,
            PartVerdict::kApart);
}

TEST(SweptExtremes, DenormalsAndTheLargestNumbers) {
  const MovingPair pair{still(kSheet), moved({{{2, 2, 1}, {3, 3, 3}, {3, 4, 3}}}, {0, 0, -4})};
  for (const int power : {-149, -140, -75, 100, 125}) {
    SCOPED_TRACE(power);
    expectPassedAt(scaled(pair, power), 0.25);
  }
}

TEST(SweptExtremes, LargeBesideSmall) {
  const float large = 1e30F, small = 1e-30F;
  const MovingTriangle sheet = still({{{0, 0, 0}, {large, 0, 0}, {0, large, 0}}});
  const Triangle tip{{{small, 0, small}, {2 * small, -small, 1}, {0, -small, 1}}};
  MovingTriangle passing{tip, {{{small, 0, -small}, {0, -small, 0.5F}, {small, -small, 0.5F}}}};
  expectFirstAt({sheet, passing}, 0.5);
  passing.to.v[0].y = std::nextafter(0.0F, -1.0F);
  expectNone({sheet, passing});
}

TEST(SweptExtremes, NotFiniteInOneState) {
  MovingTriangle t = still(kSheet);
  EXPECT_TRUE(isFinite(t));
  t.to.v[1].y = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(isFinite(t));
  t.to.v[1].y = INFINITY;
  EXPECT_FALSE(isFinite(reversed(t)));
}

// A translation of all, another one in the other state, with integers: nothing changes.
TEST(SweptInvariance, TranslationsOfBothStates) {
  MotionDice dice(5);
  long contacts = 0;
  for (int i = 0; i < 500; ++i) {
    const MovingPair pair = dice.pair(dice.half() ? 2 : 9);
    MovingPair other = pair;
    const Vec3f from = dice.point(1000), to = dice.point(1000);
    for (MovingTriangle* t : {&other.a, &other.b}) {
      for (int k = 0; k < 3; ++k) {
        t->from.v[k] = t->from.v[k] + from;
        t->to.v[k] = t->to.v[k] + to;
      }
    }
    const SweptVerdict before = verdictOf(pair), after = verdictOf(other);
    ASSERT_EQ(before.part, after.part) << i;
    ASSERT_LE(before.first_low, after.first_high) << i;
    ASSERT_LE(after.first_low, before.first_high) << i;
    contacts += before.part == PartVerdict::kMeet ? 1 : 0;
  }
  EXPECT_GT(contacts, 0);
}

}  // namespace
}  // namespace deformable_contact_monitor
