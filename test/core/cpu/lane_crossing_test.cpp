// Crossings by float32 determinants in vector lanes never contradict exact arithmetic.
// $DCM_FUZZ_PAIRS says how many pairs of each class.
#include "core/cpu/lane_crossing.h"

#include <gtest/gtest.h>

#include <cfloat>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "cgal_oracle.h"
#include "core/cpu/lane_triangle.h"
#include "hard_orientations.h"

namespace deformable_contact_monitor {
namespace {

long pairsWanted() {
  const char* wanted = std::getenv("DCM_FUZZ_PAIRS");
  return wanted != nullptr ? std::atol(wanted) : 20000;
}

// Counts the answers for pairs, four at a time, that certainly cross each other's planes.
struct Tally {
  std::vector<LaneTriangle> a, b;
  std::vector<TrianglesPair> pairs;
  long crossing = 0, meet = 0, apart = 0;

  void add(const TrianglesPair& pair) {
    pairs.push_back(pair);
    if (pairs.size() == 256) settle();
  }

  // No lane contradicts the oracle.
  void settle() {
    a.clear();
    b.clear();
    for (const TrianglesPair& pair : pairs) {
      a.emplace_back(pair.a);
      b.emplace_back(pair.b);
    }
    std::vector<CrossingPair> all;
    std::vector<std::size_t> which;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const CrossingPair pair{&a[i], &b[i], sidesOf(PlaneFilter(pairs[i].b), a[i]),
                              sidesOf(PlaneFilter(pairs[i].a), b[i])};
      if (!pair.sides_a.allStrict() || !pair.sides_b.allStrict()) continue;
      if (pair.sides_a.allOnOne() || pair.sides_b.allOnOne()) continue;
      all.push_back(pair);
      which.push_back(i);
    }
    for (std::size_t i = 0; i + 4 <= all.size(); ++i) {  // each pair in each lane
      const LaneCrossings crossings = crossingsOf({all[i], all[i + 1], all[i + 2], all[i + 3]});
      const int says_meet = laneBits(crossings.meet), says_apart = laneBits(crossings.apart);
      EXPECT_EQ(says_meet & says_apart, 0);
      for (std::size_t lane = 0; lane < 4; ++lane) {
        const Triangle &s = pairs[which[i + lane]].a, &t = pairs[which[i + lane]].b;
        const bool expected =
            meetBeyondByPredicates({s.v[0], s.v[1], s.v[2]}, {t.v[0], t.v[1], t.v[2]}, {});
        EXPECT_TRUE(expected || (says_meet >> lane & 1) == 0) << "pair " << which[i + lane];
        EXPECT_TRUE(!expected || (says_apart >> lane & 1) == 0) << "pair " << which[i + lane];
        meet += says_meet >> lane & 1;
        apart += says_apart >> lane & 1;
        ++crossing;
      }
    }
    pairs.clear();
  }
};

// An affine map keeps what touches, and fills mantissas so that products are rounded.
TrianglesPair mapped(TrianglesPair pair) {
  const float rows[3][3] = {{2011, 313, -1021}, {-707, 1503, 203}, {511, -911, 1701}};
  for (Triangle* t : {&pair.a, &pair.b}) {
    for (Vec3f& v : t->v) {
      const Vec3f p = v;
      v = {dot({rows[0][0], rows[0][1], rows[0][2]}, p),
           dot({rows[1][0], rows[1][1], rows[1][2]}, p),
           dot({rows[2][0], rows[2][1], rows[2][2]}, p)};
    }
  }
  return pair;
}

class HardCrossings : public testing::TestWithParam<HardPairClass> {};

TEST_P(HardCrossings, NeverContradictsTheOracle) {
  GridDice dice(3);
  Tally tally;
  for (long i = 0; i < pairsWanted(); ++i) {
    TrianglesPair pair = GetParam().make(&dice);
    if (dice.half()) pair = mapped(pair);
    if (dice.half()) {  // one step off what may touch
      float& x = pair.b.v[dice.within(0, 2)].x;
      x = std::nextafter(x, dice.half() ? INFINITY : -INFINITY);
    }
    const TrianglesPair scaled = scaledBy(pair, dice.within(-130, 100));
    if (isFinite(scaled.a) && isFinite(scaled.b)) tally.add(scaled);
  }
  tally.settle();
}

INSTANTIATE_TEST_SUITE_P(, HardCrossings, testing::ValuesIn(hardPairClasses()),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(LaneProduct, TellsThePlaneFiltersSides) {
  const auto lanes = [](const Vec3f& v) {
    return LanePoint{{v.x, v.x, v.x, v.x}, {v.y, v.y, v.y, v.y}, {v.z, v.z, v.z, v.z}};
  };
  int crossings = 0;
  const auto check = [&](const Vec3f& p, const Vec3f& q, const Vec3f& r, const Vec3f& s) {
    const int side = PlaneFilter(Triangle{{p, q, r}}).side(s);
    const LaneSigns signs = LaneProduct(lanes(q - p), lanes(r - p)).signWith(lanes(s - p));
    EXPECT_EQ(side == 1 ? 15 : 0, laneBits(signs.positive));
    EXPECT_EQ(side == -1 ? 15 : 0, laneBits(signs.negative));
    crossings += side != 0;
  };
  for (const HardOrientation& hard : hardOrientations(1, 200, FirstPoint::kAnywhere)) {
    // The sizes go from where the filter hardly finds a side to where it finds each.
    for (int power = -26; power < 0; ++power) {
      const Vec3f off = Vec3f{1, -1, 1} * std::ldexp(1.0F, power);
      check(hard.p[0], hard.p[1], hard.p[2], hard.p[3] + off);
    }
  }
  EXPECT_GT(crossings, 2000);
  EXPECT_LT(crossings, 5000);
}

TEST(LaneCrossing, NeverContradictsTheOracleWhereRoundingTurnsEdges) {
  Tally tally;
  for (const TrianglesPair& pair : pairsOn(hardOrientations(1, 200, FirstPoint::kAnywhere), 50)) {
    tally.add(pair);
  }
  tally.settle();
  EXPECT_GT(tally.crossing - tally.meet - tally.apart, 500) << "they hang on it";
}

// Small ones in any place: what scenes are made of.
TEST(LaneCrossing, SettlesNearlyAllInGeneralPosition) {
  GridDice dice(4);
  Tally tally;
  for (long i = 0; i < pairsWanted(); ++i) {
    tally.add(mapped({dice.triangle(60), dice.triangle(60)}));
  }
  tally.settle();
  EXPECT_GT(tally.crossing, pairsWanted() / 10);
  EXPECT_GT(tally.meet, tally.crossing / 10);
  EXPECT_GT(tally.apart, tally.crossing / 10);
  EXPECT_GT(tally.meet + tally.apart, tally.crossing * 98 / 100);
}

// Each coordinate of its own size, from the least denormal to the largest number.
TEST(LaneCrossing, SizesFarApart) {
  GridDice dice(5);
  const auto size = [&dice] {
    const float of[] = {0, 1.4e-45F, 1e-40F, 1e-38F, 1e-19F, 1e-12F,
                        1, 1e12F,    1e19F,  1e30F,  FLT_MAX};
    return of[dice.within(0, 10)] * dice.eighths(-8, 8);
  };
  Tally tally;
  for (long i = 0; i < 4 * pairsWanted(); ++i) {
    TrianglesPair pair;
    const bool by_axis = dice.half();
    const Vec3f scale{size(), size(), size()};
    for (Triangle* t : {&pair.a, &pair.b}) {
      for (Vec3f& v : t->v) {
        const Vec3f p = dice.point(9) * 0.125F;
        v = by_axis ? Vec3f{scale.x * p.x, scale.y * p.y, scale.z * p.z}
                    : Vec3f{size(), size(), size()};
      }
    }
    if (isFinite(pair.a) && isFinite(pair.b)) tally.add(pair);
  }
  tally.settle();
  EXPECT_GT(tally.meet, 100);
  EXPECT_GT(tally.apart, 100);
}

}  // namespace
}  // namespace deformable_contact_monitor
