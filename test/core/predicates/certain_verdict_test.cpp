// Compares the certain answers of float32 with exact arithmetic: sides of planes, and verdicts on
// pairs of triangles of which two edges nearly meet in space, in a plane, or seen from a common
// vertex.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "cgal_oracle.h"
#include "core/predicates/narrow_phase.h"
#include "exact_points.h"
#include "hard_orientations.h"
#include "pair_verdict.h"

namespace deformable_contact_monitor {
namespace {

class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  int within(int low, int high) {
    return low + static_cast<int>(random_() % static_cast<unsigned>(high - low + 1));
  }
  float real() { return static_cast<float>(within(-(1 << 23), 1 << 23)) / (1 << 23); }
  Vec3f point() { return {real(), real(), real()}; }
  // A small vector, of any length down to what rounding takes away.
  Vec3f nudge() { return point() * std::ldexp(1.0F, -within(0, 30)); }

 private:
  std::mt19937 random_;
};

Triangle scaledBy(const Triangle& t, float scale) {
  return {{t.v[0] * scale, t.v[1] * scale, t.v[2] * scale}};
}

int exactSide(const Triangle& t, const Vec3f& p) {
  using exact::toPoint;
  return static_cast<int>(
      CGAL::orientation(toPoint(t.v[0]), toPoint(t.v[1]), toPoint(t.v[2]), toPoint(p)));
}

// Near the plane, at scales from where products are denormal to where they overflow, and far from
// triangles whose products are.
TEST(PlaneFilter, TellsTrueSidesOnly) {
  Dice dice(1);
  constexpr int kPoints = 100000;
  int told = 0;
  for (int i = 0; i < kPoints; ++i) {
    const Vec3f off = dice.point() * (i % 3 == 0 ? 64.0F : 0.0F);
    Triangle t{{off + dice.point(), off + dice.point(), off + dice.point()}};
    const float s = dice.real(), r = dice.real();
    Vec3f p = (t.v[1] - t.v[0]) * s + (t.v[2] - t.v[0]) * r + dice.nudge();
    const bool far = i % 4 == 1;
    if (!far) p = p + t.v[0];
    const float scale = std::ldexp(1.0F, i % 2 == 0 ? dice.within(-3, 3) : dice.within(-80, 110));
    t = scaledBy(t, far ? std::ldexp(1.0F, dice.within(-78, -68)) : scale);
    p = p * scale;
    const int side = PlaneFilter(t).side(p);
    if (side == 0) continue;
    ++told;
    ASSERT_EQ(side, exactSide(t, p)) << "point " << i;
  }
  EXPECT_GT(told, kPoints / 4);
  EXPECT_LT(told, kPoints * 9 / 10);
}

// So far off that no bound may be a third as large.
TEST(PlaneFilter, TellsNoSideThatRoundingMade) {
  const std::vector<HardOrientation> hard = hardOrientations(1, 200, FirstPoint::kAnywhere);
  EXPECT_GT(worstOf(hard), 2.5);
  for (const HardOrientation& points : hard) {
    const Triangle t{{points.p[0], points.p[1], points.p[2]}};
    const int side = PlaneFilter(t).side(points.p[3]);
    EXPECT_TRUE(side == 0 || side == exactSide(t, points.p[3])) << points.off_by;
  }
}

// Nearly on a line or exactly on one, at scales from where products are denormal to where they
// overflow.
TEST(ProjectionFilter, TellsTrueTurnsOnly) {
  Dice dice(5);
  constexpr int kTurns = 300000;
  int told = 0, on_the_line = 0;
  for (int i = 0; i < kTurns; ++i) {
    Vec3f a = dice.point() * (i % 3 == 0 ? 16.0F : 1.0F), b = dice.point();
    Vec3f c = a + (b - a) * (2.0F * dice.real()) + dice.nudge() * 0x1p-10F;
    if (i % 5 == 0) {
      const auto whole = [&] { return static_cast<float>(dice.within(-1000, 1000)) * 0x1p-10F; };
      a = {whole(), whole(), 0};
      b = a + Vec3f{whole(), whole(), 0};
      c = a + (b - a) * static_cast<float>(dice.within(-8, 8));
    }
    const int exponent = i % 2 == 0   ? dice.within(-3, 3)
                         : i % 4 == 1 ? dice.within(-76, -68)
                                      : dice.within(-80, 80);
    const float scale = std::ldexp(1.0F, exponent);
    for (Vec3f* p : {&a, &b, &c}) *p = Vec3f{p->x, p->y, 0} * scale;
    const detail::FlatPoint flat[3] = {{a, 2}, {b, 2}, {c, 2}};
    const int turn = detail::exactTurn(flat[0], flat[1], flat[2]);
    const int strict = detail::certainTurn(flat[0], flat[1], flat[2]);
    ASSERT_TRUE(strict == kUncertain || (strict == turn && turn != 0)) << "turn " << i;
    if (turn == kUncertain) continue;
    ++told;
    on_the_line += turn == 0;
    const Vec3f above{a.x, a.y, 1};
    ASSERT_EQ(turn, exactSide({{a, b, c}}, above)) << "turn " << i;
  }
  EXPECT_GT(told, kTurns / 4);
  EXPECT_LT(told, kTurns * 9 / 10);
  EXPECT_GT(on_the_line, kTurns / 20);
}

// An edge of b passes an edge of a at a distance of any size; b's third vertex is beyond.
void makeNearlyCrossing(Dice& dice, Triangle& a, Triangle& b) {
  const Vec3f off = dice.point() * (dice.within(0, 2) == 0 ? 16.0F : 0.0F);
  a = {{off + dice.point(), off + dice.point(), off + dice.point()}};
  const float s = 0.5F + 0.5F * dice.real();
  const Vec3f meeting = a.v[0] + (a.v[1] - a.v[0]) * s + dice.nudge();
  const Vec3f along = dice.point();
  const float back = -0.5F + 0.5F * dice.real(), ahead = 0.5F + 0.5F * dice.real();
  b = {{meeting + along * back, meeting + along * ahead, off + dice.point() * 2.0F}};
  const float scale = std::ldexp(1.0F, dice.within(-2, 2) * dice.within(0, 20));
  a = scaledBy(a, scale);
  b = scaledBy(b, scale);
}

// Counts the answers for pairs. The oracle must agree with each of them.
struct Told {
  int meet = 0, apart = 0, open = 0, sharing = 0;

  void add(const Triangle& a, const Triangle& b) {
    PairFacts facts, turned;
    facts.shared = sharedVertices(a, b);
    turned.shared = sharedVertices(b, a);
    std::vector<Vec3f> shared;
    for (int i = 0; i < 3; ++i) {
      if (facts.shared.in_a[i]) shared.push_back(a.v[i]);
    }
    sharing += facts.shared.any ? 1 : 0;
    if (!isCandidate(a, b, facts)) return;
    ASSERT_TRUE(isCandidate(b, a, turned));
    const bool expected =
        meetBeyondByPredicates({a.v[0], a.v[1], a.v[2]}, {b.v[0], b.v[1], b.v[2]}, shared);
    for (const PartVerdict told : {certainVerdict(a, b, facts), certainVerdict(b, a, turned)}) {
      if (told == PartVerdict::kOpen) {
        ++open;
        continue;
      }
      ASSERT_EQ(expected, told == PartVerdict::kMeet);
      (expected ? meet : apart) += 1;
    }
  }
};

constexpr int kPairs = 60000;

Told toldOf(void (*make)(Dice&, Triangle&, Triangle&), unsigned seed) {
  Dice dice(seed);
  Told told;
  for (int i = 0; i < kPairs && !testing::Test::HasFatalFailure(); ++i) {
    Triangle a, b;
    make(dice, a, b);
    SCOPED_TRACE(i);
    told.add(a, b);
  }
  return told;
}

TEST(CertainVerdict, IsTheOracles) {
  const Told told = toldOf(makeNearlyCrossing, 2);
  EXPECT_GT(told.meet, kPairs / 10);
  EXPECT_GT(told.apart, kPairs / 10);
  EXPECT_GT(told.open, kPairs / 50);
}

// An edge of b passes an edge of a nearly in a's plane, at a distance of any size.
void makeNearlyTouchingInAPlane(Dice& dice, Triangle& a, Triangle& b) {
  const Vec3f origin = dice.point() * (dice.within(0, 2) == 0 ? 16.0F : 0.0F);
  const Vec3f x = dice.point(), y = dice.point();
  const auto place = [&](float along_x, float along_y) {
    return origin + x * along_x + y * along_y + dice.nudge() * 0x1p-6F;
  };
  const float s = dice.real(), r = dice.real();
  const float gap = std::ldexp(dice.real(), -dice.within(0, 30));
  a = {{place(0, 0), place(1, s), place(r, 1)}};
  b = {{place(s, -gap), place(r, -gap - std::abs(dice.real())), place(2 * s, s * s - gap)}};
  const float scale = std::ldexp(1.0F, dice.within(-2, 2) * dice.within(0, 20));
  a = scaledBy(a, scale);
  b = scaledBy(b, scale);
}

TEST(CertainVerdict, IsTheOraclesNearlyInAPlane) {
  const Told told = toldOf(makeNearlyTouchingInAPlane, 3);
  EXPECT_GT(told.apart, kPairs / 10);
  EXPECT_GT(told.open, kPairs / 20);
}

// From their vertex p, the edges opposite to it cross in one direction, or in opposite ones, or
// miss each other by a little.
void makeSharingAVertex(Dice& dice, Triangle& a, Triangle& b) {
  const Vec3f p = dice.point() * (dice.within(0, 2) == 0 ? 16.0F : 1.0F);
  a = {{p, p + dice.point(), p + dice.point()}};
  const float s = 0.5F + 0.6F * dice.real();
  const Vec3f crossing = a.v[1] + (a.v[2] - a.v[1]) * s - p;
  const Vec3f meeting = p + crossing * (2.0F * dice.real()) + dice.nudge();
  const Vec3f end = p + dice.point();
  b = {{p, end, meeting + (meeting - end) * std::abs(dice.real())}};
  const float scale = std::ldexp(1.0F, dice.within(-2, 2) * dice.within(0, 20));
  a = scaledBy(a, scale);
  b = scaledBy(b, scale);
  for (Triangle* t : {&a, &b}) {
    std::rotate(t->v, t->v + dice.within(0, 2), t->v + 3);
    if (dice.within(0, 1) == 0) std::swap(t->v[0], t->v[1]);
  }
}

TEST(CertainVerdict, IsTheOraclesBeyondAVertex) {
  const Told told = toldOf(makeSharingAVertex, 4);
  EXPECT_EQ(told.sharing, kPairs);
  EXPECT_GT(told.meet, kPairs / 10);
  EXPECT_GT(told.apart, kPairs / 10);
  EXPECT_GT(told.open, kPairs / 100);
}

TEST(CertainVerdict, IsTheOraclesWhereRoundingTurnsEdges) {
  Told told;
  for (const TrianglesPair& pair : pairsOn(hardOrientations(1, 200, FirstPoint::kAnywhere), 50)) {
    told.add(pair.a, pair.b);
    if (HasFatalFailure()) break;
  }
  EXPECT_GT(told.open, 500) << "they hang on it";
}

TEST(CertainVerdict, LeavesOpenWhatTheFiltersLeave) {
  const Triangle a{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};
  const Triangle crossing{{{1, 1, -1}, {1, 2, 1}, {2, 1, 1}}};
  PairFacts facts;
  ASSERT_TRUE(isCandidate(a, crossing, facts));
  EXPECT_EQ(PartVerdict::kMeet, certainVerdict(a, crossing, facts));
  facts = {};
  EXPECT_EQ(PartVerdict::kOpen, certainVerdict(a, crossing, facts)) << "sides not known";
  const Triangle standing{{{1, 1, 0}, {1, 2, 1}, {2, 1, -1}}};
  ASSERT_TRUE(isCandidate(a, standing, facts));
  EXPECT_EQ(PartVerdict::kOpen, certainVerdict(a, standing, facts)) << "a vertex in the plane";
  const Triangle at_an_edge{{{2, 0, -1}, {2, 0, 1}, {2, -1, 0.5F}}};
  facts = {};
  ASSERT_TRUE(isCandidate(a, at_an_edge, facts));
  EXPECT_EQ(PartVerdict::kOpen, certainVerdict(a, at_an_edge, facts)) << "edges meet";
  const Triangle through_a_vertex{{{0, 0, 0}, {1, 1, -1}, {1, 1, 1}}};
  facts = {};
  facts.shared = sharedVertices(a, through_a_vertex);
  EXPECT_EQ(PartVerdict::kOpen, certainVerdict(a, through_a_vertex, facts)) << "sides not known";
  ASSERT_TRUE(isCandidate(a, through_a_vertex, facts));
  EXPECT_EQ(PartVerdict::kMeet, certainVerdict(a, through_a_vertex, facts));
  const Triangle along_an_edge{{{0, 0, 0}, {1, 0, -1}, {1, 0, 1}}};
  facts = {};
  facts.shared = sharedVertices(a, along_an_edge);
  ASSERT_TRUE(isCandidate(a, along_an_edge, facts));
  EXPECT_EQ(PartVerdict::kOpen, certainVerdict(a, along_an_edge, facts)) << "an edge in the plane";
}

// Triangles, the segments of ropes, and points, of which the exact verdict says that they are
// apart.
TEST(Modes, WhatIsClearlyApartTouchesInNone) {
  Dice dice(7);
  int checked[3] = {0, 0, 0};
  for (int i = 0; i < kPairs; ++i) {
    const Vec3f off = dice.point() * 0.5F;
    const Triangle a{{dice.point(), dice.point(), dice.point()}};
    Triangle b{{off + dice.point(), off + dice.point(), off + dice.point()}};
    const int kind = i % 3;
    if (kind > 0) b.v[2] = b.v[1];
    if (kind > 1) b.v[1] = b.v[2] = b.v[0];
    PredicateState exact;
    const double apart_m = trianglesIntersect(a, b, exact) ? 0 : separation(a, b);
    if (apart_m < 0.01) continue;
    ++checked[kind];
    for (const Predicates mode : {Predicates::kExact, Predicates::kConservative}) {
      for (const float margin_m : {0.0F, 0.375F, 4.0F}) {
        PredicateState state{mode};
        const Verdict verdict =
            pairVerdict(a, b, false, AdjacentPairs::kBeyondShared, margin_m, state);
        SCOPED_TRACE(testing::Message() << "pair " << i << ", " << toString(mode) << ", margin "
                                        << margin_m << ", apart " << apart_m);
        ASSERT_EQ(verdict.contact, static_cast<float>(apart_m) <= margin_m);
        if (!verdict.contact) continue;
        ASSERT_EQ(verdict.separation_m, static_cast<float>(apart_m));
      }
    }
  }
  for (const int count : checked) EXPECT_GT(count, kPairs / 12);
}

}  // namespace
}  // namespace deformable_contact_monitor
