// Random pairs of triangles as layers of cloth have them: with equal vertices, in one plane, side
// by side in it, or in parallel planes, at all scales. Each part of the narrow phase must agree
// with the oracle where it decides. $DCM_FUZZ_PAIRS says how many pairs of each family.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ostream>
#include <string>
#include <vector>

#include "cgal_oracle.h"
#include "core/predicates/narrow_phase.h"
#include "hard_pairs.h"

namespace deformable_contact_monitor {
namespace {

// Lattice points of a plane: origin + u x + v y, whose coordinates are small integers.
struct Lattice {
  Vec3f origin, x, y;

  Vec3f at(int u, int v) const {
    return origin + x * static_cast<float>(u) + y * static_cast<float>(v);
  }
};

Lattice levelLattice(GridDice* dice) {
  const Vec3f axis[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const int k = dice->within(0, 2);
  return {dice->point(1000), axis[k], axis[(k + 1) % 3]};
}

Lattice slopingLattice(GridDice* dice) {
  return {dice->point(1000), dice->point(9), dice->point(9)};
}

Triangle on(const Lattice& lattice, GridDice* dice, int range_u, int range_v) {
  Triangle t;
  for (Vec3f& v : t.v) {
    v = lattice.at(dice->within(-range_u, range_u), dice->within(-range_v, range_v));
  }
  return t;
}

TrianglesPair equalTriangles(GridDice* dice) {
  TrianglesPair pair{dice->triangle(500), {}};
  pair.b = pair.a;
  std::rotate(pair.b.v, pair.b.v + dice->within(0, 2), pair.b.v + 3);
  if (dice->half()) std::swap(pair.b.v[0], pair.b.v[1]);
  return pair;
}

TrianglesPair equalVertices(GridDice* dice) {
  TrianglesPair pair{dice->triangle(500), dice->triangle(500)};
  for (int k = dice->within(0, 1); k < 2; ++k) {
    pair.b.v[dice->within(0, 2)] = pair.a.v[dice->within(0, 2)];
  }
  return pair;
}

// On a narrow lattice vertices lie on edges, and edges on lines, more often than not.
TrianglesPair level(GridDice* dice) {
  const Lattice lattice = levelLattice(dice);
  return {on(lattice, dice, 3, 3), on(lattice, dice, 3, 3)};
}

TrianglesPair levelAtDistance(GridDice* dice) {
  Lattice lattice = levelLattice(dice);
  const Triangle a = on(lattice, dice, 40, 40);
  lattice.origin = lattice.at(dice->within(-60, 60), dice->within(-60, 60));
  return {a, on(lattice, dice, 40, 40)};
}

TrianglesPair levelSlivers(GridDice* dice) {
  const Lattice lattice = levelLattice(dice);
  return {on(lattice, dice, 900, 1), on(lattice, dice, 900, 1)};
}

TrianglesPair sloping(GridDice* dice) {
  const Lattice lattice = slopingLattice(dice);
  return {on(lattice, dice, 4, 4), on(lattice, dice, 4, 4)};
}

TrianglesPair slopingSlivers(GridDice* dice) {
  const Lattice lattice = slopingLattice(dice);
  return {on(lattice, dice, 90, 1), on(lattice, dice, 90, 1)};
}

// One vertex is beside the plane by the least step, or lies in it still.
TrianglesPair nearlySloping(GridDice* dice) {
  TrianglesPair pair = sloping(dice);
  float& x = pair.b.v[dice->within(0, 2)].y;
  x = std::nextafter(x, dice->half() ? INFINITY : -INFINITY);
  return pair;
}

TrianglesPair parallel(GridDice* dice) {
  const Lattice lattice = dice->half() ? levelLattice(dice) : slopingLattice(dice);
  Lattice other = lattice;
  other.origin = other.origin + Vec3f{0, 0, static_cast<float>(dice->within(-1, 1))};
  return {on(lattice, dice, 4, 4), on(other, dice, 4, 4)};
}

TrianglesPair segmentsAndPoints(GridDice* dice) {
  const Lattice lattice = dice->half() ? levelLattice(dice) : slopingLattice(dice);
  TrianglesPair pair{on(lattice, dice, 3, 3), on(lattice, dice, 3, 0)};
  if (dice->half()) pair.a.v[2] = pair.a.v[dice->within(0, 1)];
  if (dice->half()) std::swap(pair.a, pair.b);
  return pair;
}

// Where single numbers, their products or the errors of these are denormal, and where products
// overflow.
int anyPower(GridDice* dice) {
  constexpr int kLow[] = {-149, -100, -80, -60, 90};
  const int k = dice->within(0, 4);
  return dice->within(kLow[k], k < 3 ? kLow[k] + 20 : (k == 3 ? 40 : 110));
}

struct Family {
  HardPairClass made;
  double certain;  // the least part that float32 decides
};

std::ostream& operator<<(std::ostream& out, const Family& family) { return out << family.made; }

class LayeredPairs : public testing::TestWithParam<Family> {};

bool hasArea(const Triangle& t) {
  PredicateState state;
  return projectionAxis(t.v[0], t.v[1], t.v[2], state) >= 0;
}

struct Decided {
  long pairs = 0, certain = 0, meet = 0;

  // Compares each part's answer with the oracle's. With `same_body`, equal vertices are shared.
  void check(const Triangle& a, const Triangle& b, bool same_body) {
    PairFacts facts;
    if (same_body) facts.shared = sharedVertices(a, b);
    std::vector<Vec3f> shared;
    for (int i = 0; i < 3; ++i) {
      if (facts.shared.in_a[i]) shared.push_back(a.v[i]);
    }
    const OracleTriangle oracle_a{a.v[0], a.v[1], a.v[2]}, oracle_b{b.v[0], b.v[1], b.v[2]};
    const bool expected = hasArea(a) && hasArea(b)
                              ? meetBeyondByPredicates(oracle_a, oracle_b, shared)
                              : meetBeyondByConstruction(oracle_a, oracle_b, shared);
    ++pairs;
    meet += expected;
    if (!isCandidate(a, b, facts)) {
      ASSERT_FALSE(expected);
      ++certain;
      return;
    }
    const PartVerdict in_float = certainVerdict(a, b, facts);
    certain += in_float != PartVerdict::kOpen;
    for (const PartVerdict part : {in_float, quickVerdict(a, b, facts)}) {
      ASSERT_TRUE(part == PartVerdict::kOpen || (part == PartVerdict::kMeet) == expected);
    }
    PredicateState state;
    ASSERT_EQ(expected, fullVerdict(a, b, facts, state).contact);
    PredicateState conservative;
    conservative.mode = Predicates::kConservative;
    ASSERT_TRUE(fullVerdict(a, b, facts, conservative).contact || !expected);
    ASSERT_TRUE(candidateVerdict(a, b, facts, conservative).contact || !expected);
  }
};

TEST_P(LayeredPairs, EqualTheOracle) {
  const char* wanted = std::getenv("DCM_FUZZ_PAIRS");
  const long count = wanted != nullptr ? std::atol(wanted) : 10000;
  GridDice dice(static_cast<unsigned>(count) + 1);
  Decided usual, extreme;
  for (long i = 0; i < count && !HasFatalFailure(); ++i) {
    const TrianglesPair pair = GetParam().made.make(&dice);
    SCOPED_TRACE(i);
    for (const bool same_body : {false, true}) {
      usual.check(pair.a, pair.b, same_body);
      usual.check(pair.b, pair.a, same_body);
      const TrianglesPair scaled = scaledBy(pair, anyPower(&dice));
      extreme.check(scaled.a, scaled.b, same_body);
    }
  }
  EXPECT_GT(usual.meet, usual.pairs / 20);
  EXPECT_GT(usual.certain, GetParam().certain * static_cast<double>(usual.pairs));
  EXPECT_GT(extreme.certain, extreme.pairs / 20);
}

INSTANTIATE_TEST_SUITE_P(, LayeredPairs,
                         testing::Values(Family{{"equal_triangles", equalTriangles}, 0.4},
                                         Family{{"equal_vertices", equalVertices}, 0.4},
                                         Family{{"level", level}, 0.4},
                                         Family{{"level_at_distance", levelAtDistance}, 0.9},
                                         Family{{"level_slivers", levelSlivers}, 0.4},
                                         Family{{"sloping", sloping}, 0.2},
                                         Family{{"sloping_slivers", slopingSlivers}, 0.2},
                                         Family{{"nearly_sloping", nearlySloping}, 0.2},
                                         Family{{"parallel", parallel}, 0.4},
                                         Family{{"segments_and_points", segmentsAndPoints}, 0.05}),
                         [](const auto& info) { return std::string(info.param.made.name); });

}  // namespace
}  // namespace deformable_contact_monitor
