// Random pairs of triangles that touch, lie in one plane or are degenerate, against the oracle: the
// narrow phase where floating point alone would guess. $DCM_FUZZ_PAIRS says how many of each class.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>
#include <string>

#include "cgal_oracle.h"
#include "pair_verdict.h"

namespace deformable_contact_monitor {
namespace {

// Integers small enough that sums of a few products with small fractions are exact in float32.
class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  int within(int low, int high) {
    return low + static_cast<int>(random_() % static_cast<unsigned>(high - low + 1));
  }
  bool half() { return random_() % 2 == 0; }
  Vec3f point(int range) {
    return {static_cast<float>(within(-range, range)), static_cast<float>(within(-range, range)),
            static_cast<float>(within(-range, range))};
  }
  Triangle triangle(int range) { return {{point(range), point(range), point(range)}}; }
  // In eighths.
  float eighths(int low, int high) { return static_cast<float>(within(low, high)) / 8; }

 private:
  std::mt19937 random_;
};

struct Pair {
  Triangle a, b;
};

Vec3f inPlane(const Triangle& t, float s, float r) {
  return t.v[0] + (t.v[1] - t.v[0]) * s + (t.v[2] - t.v[0]) * r;
}

Pair vertexOnFace(Dice* dice) {
  const Triangle a = dice->triangle(500);
  Triangle b = dice->triangle(500);
  b.v[dice->within(0, 2)] = inPlane(a, dice->eighths(-1, 5), dice->eighths(-1, 5));
  return {a, b};
}

Pair vertexOnEdge(Dice* dice) {
  const Triangle a = dice->triangle(500);
  Triangle b = dice->triangle(500);
  b.v[dice->within(0, 2)] = inPlane(a, dice->eighths(-3, 11), 0);
  return {a, b};
}

Pair edgeThroughEdge(Dice* dice) {
  const Triangle a = dice->triangle(500);
  Triangle b = dice->triangle(500);
  const Vec3f p = inPlane(a, dice->eighths(-2, 10), 0), d = dice->point(100);
  b.v[0] = p + d * static_cast<float>(dice->within(-1, 2));
  b.v[1] = p - d * static_cast<float>(dice->within(0, 3));
  return {a, b};
}

Pair edgeInPlane(Dice* dice) {
  const Triangle a = dice->triangle(500);
  Triangle b = dice->triangle(500);
  const int k = dice->within(0, 2);
  b.v[k] = inPlane(a, dice->eighths(-4, 12), dice->eighths(-4, 12));
  b.v[k == 2 ? 0 : k + 1] = inPlane(a, dice->eighths(-4, 12), dice->eighths(-4, 12));
  return {a, b};
}

Pair inOnePlane(Dice* dice) {
  const Triangle plane = dice->triangle(60);
  Pair pair;
  for (Triangle* t : {&pair.a, &pair.b}) {
    for (Vec3f& v : t->v) v = inPlane(plane, dice->eighths(-16, 16), dice->eighths(-16, 16));
  }
  return pair;
}

Pair nearlyInOnePlane(Dice* dice) {
  Pair pair = inOnePlane(dice);
  if (dice->half()) {
    float& x = pair.b.v[dice->within(0, 2)].z;
    x = std::nextafter(x, dice->half() ? INFINITY : -INFINITY);
  }
  return pair;
}

Pair smallGrid(Dice* dice) { return {dice->triangle(1), dice->triangle(1)}; }

Pair sharedCorner(Dice* dice) {
  Pair pair{dice->triangle(2000), dice->triangle(2000)};
  for (int k = dice->within(1, 3); k > 0; --k) {
    pair.b.v[dice->within(0, 2)] = pair.a.v[dice->within(0, 2)];
  }
  return pair;
}

Pair degenerate(Dice* dice) {
  const Triangle a = dice->triangle(100);
  Triangle b = dice->triangle(100);
  b.v[0] = inPlane(a, dice->eighths(-1, 5), dice->eighths(-1, 5));
  b.v[1] = dice->half() ? b.v[0] : inPlane(a, dice->eighths(-1, 5), dice->eighths(-1, 5));
  b.v[2] =
      dice->half() ? b.v[0] : b.v[0] + (b.v[1] - b.v[0]) * static_cast<float>(dice->within(-1, 2));
  return dice->half() ? Pair{a, b} : Pair{b, a};
}

// Exponents so far apart that integers do not do; the plane z = x holds all of a.
Pair farApartExponents(Dice* dice) {
  const auto any = [dice] {
    return std::ldexp(static_cast<float>(dice->within(-8388607, 8388607)), dice->within(-70, 0));
  };
  Pair pair;
  for (Vec3f& v : pair.a.v) {
    v = {any(), any(), 0};
    v.z = v.x;
  }
  for (Vec3f& v : pair.b.v) v = {any(), any(), any()};
  Vec3f& touching = pair.b.v[dice->within(0, 2)];
  if (dice->half()) touching = (pair.a.v[0] + pair.a.v[1] + pair.a.v[2]) * (1.0F / 3);
  touching.z = touching.x;
  return pair;
}

struct PairClass {
  const char* name;
  Pair (*make)(Dice*);
};

class HardPairs : public testing::TestWithParam<PairClass> {};

bool isDegenerate(const Triangle& t) {
  PredicateState state;
  return projectionAxis(t.v[0], t.v[1], t.v[2], state) < 0;
}

TEST_P(HardPairs, EqualTheOracle) {
  const char* wanted = std::getenv("DCM_FUZZ_PAIRS");
  const long count = wanted != nullptr ? std::atol(wanted) : 20000;
  Dice dice(static_cast<unsigned>(count));
  long contacts = 0, exact = 0;
  for (long i = 0; i < count; ++i) {
    Pair pair = GetParam().make(&dice);
    const int power = dice.within(-60, 40);
    for (Triangle* t : {&pair.a, &pair.b}) {
      for (Vec3f& v : t->v)
        v = {std::ldexp(v.x, power), std::ldexp(v.y, power), std::ldexp(v.z, power)};
    }
    const OracleTriangle a{pair.a.v[0], pair.a.v[1], pair.a.v[2]};
    const OracleTriangle b{pair.b.v[0], pair.b.v[1], pair.b.v[2]};
    const bool by_construction = isDegenerate(pair.a) || isDegenerate(pair.b);
    const bool expected =
        by_construction ? meetBeyondByConstruction(a, b, {}) : meetBeyondByPredicates(a, b, {});
    PredicateState state;
    const bool found = pairVerdict(pair.a, pair.b, false, AdjacentPairs::kSkip, 0, state).contact;
    ASSERT_EQ(found, expected) << "pair " << i;
    PredicateState swapped;
    ASSERT_EQ(found, pairVerdict(pair.b, pair.a, false, AdjacentPairs::kSkip, 0, swapped).contact)
        << "pair " << i;
    PredicateState conservative;
    conservative.mode = Predicates::kConservative;
    const bool safe =
        pairVerdict(pair.a, pair.b, false, AdjacentPairs::kSkip, 0, conservative).contact;
    ASSERT_TRUE(safe || !expected) << "pair " << i;
    ASSERT_TRUE(safe == expected || conservative.undecided) << "pair " << i;
    contacts += found;
    exact += state.exact > 0;
  }
  EXPECT_GT(contacts, 3 * count / 10);
  EXPECT_GT(exact, 3 * count / 10);
}

INSTANTIATE_TEST_SUITE_P(, HardPairs,
                         testing::Values(PairClass{"vertex_on_face", vertexOnFace},
                                         PairClass{"vertex_on_edge", vertexOnEdge},
                                         PairClass{"edge_through_edge", edgeThroughEdge},
                                         PairClass{"edge_in_plane", edgeInPlane},
                                         PairClass{"in_one_plane", inOnePlane},
                                         PairClass{"nearly_in_one_plane", nearlyInOnePlane},
                                         PairClass{"small_grid", smallGrid},
                                         PairClass{"shared_corner", sharedCorner},
                                         PairClass{"degenerate", degenerate},
                                         PairClass{"far_apart_exponents", farApartExponents}),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace deformable_contact_monitor
