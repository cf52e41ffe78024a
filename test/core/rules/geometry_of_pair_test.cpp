// The geometry of single pairs: against exact rationals, and what must hold of any pair. On hard
// pairs by classes, slivers, far vertices, and whatever floats there are. $DCM_FUZZ_PAIRS says how
// many of each class.
#include "core/rules/geometry_of_pair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "core/predicates/narrow_phase.h"
#include "exact_clip.h"
#include "exact_distance.h"
#include "exact_parting.h"
#include "hard_pairs.h"

namespace deformable_contact_monitor {
namespace {

float real(GridDice* dice, float size) {
  return size * (static_cast<float>(dice->within(-(1 << 23), 1 << 23)) * 0x1p-23F);
}

Vec3f realPoint(GridDice* dice, float size) {
  return {real(dice, size), real(dice, size), real(dice, size)};
}

Triangle realTriangle(GridDice* dice, float size) {
  return {{realPoint(dice, size), realPoint(dice, size), realPoint(dice, size)}};
}

TrianglesPair ordinary(GridDice* dice) { return {realTriangle(dice, 1), realTriangle(dice, 1)}; }

// Small triangles in a plane each, the planes nearly parallel: what cloth on cloth looks like.
TrianglesPair nearlyParallel(GridDice* dice) {
  TrianglesPair pair = ordinary(dice);
  for (Triangle* t : {&pair.a, &pair.b}) {
    for (Vec3f& v : t->v) v = {v.x + 3, v.y - 7, 0.5F + 1e-6F * v.z};
  }
  return pair;
}

TrianglesPair slivers(GridDice* dice) {
  TrianglesPair pair = ordinary(dice);
  const float width = std::ldexp(1.0F, -dice->within(10, 40));
  for (Triangle* t : {&pair.a, &pair.b}) {
    const Vec3f along = t->v[1] - t->v[0];
    t->v[2] = t->v[0] + along * real(dice, 1.5F) + realPoint(dice, width);
  }
  if (dice->half()) return pair;
  const Vec3f to_a = (pair.a.v[0] + pair.a.v[1]) * 0.5F - (pair.b.v[0] + pair.b.v[1]) * 0.5F;
  for (Vec3f& v : pair.b.v) v = v + to_a;
  return pair;
}

// Some vertices far away, the others about the origin.
TrianglesPair farVertices(GridDice* dice) {
  TrianglesPair pair = ordinary(dice);
  for (int moved = dice->within(1, 4); moved > 0; --moved) {
    Vec3f& v = (dice->half() ? pair.a : pair.b).v[dice->within(0, 2)];
    v = v * std::ldexp(1.0F, dice->within(10, 100));
  }
  return pair;
}

// Coordinates of any size there is.
TrianglesPair anyFloats(GridDice* dice) {
  TrianglesPair pair;
  const int low = dice->within(-149, 100);
  const int high = std::min(127, low + dice->within(0, 250));
  const auto any = [&] {
    const float x = std::ldexp(real(dice, 1.999F), dice->within(low, high));
    return std::isfinite(x) ? x : FLT_MAX;
  };
  for (Triangle* t : {&pair.a, &pair.b}) {
    for (Vec3f& v : t->v) v = {any(), any(), any()};
  }
  if (dice->within(0, 3) == 0) pair.b.v[0] = pair.a.v[dice->within(0, 2)];
  return pair;
}

// Of `others` too, which the classes of hard pairs lack.
std::vector<HardPairClass> allClasses() {
  std::vector<HardPairClass> classes = hardPairClasses();
  for (const HardPairClass& other : {HardPairClass{"ordinary", ordinary},
                                     {"nearly_parallel", nearlyParallel},
                                     {"slivers", slivers},
                                     {"far_vertices", farVertices},
                                     {"any_floats", anyFloats}}) {
    classes.push_back(other);
  }
  return classes;
}

double coordinate(const Vec3f& v) { return largestCoordinate(toDouble(v)); }

double sizeOf(const Triangle& t) {
  return std::max({coordinate(t.v[0]), coordinate(t.v[1]), coordinate(t.v[2])});
}

double longestEdge(const Triangle& t) {
  double longest = 0;
  for (int i = 0; i < 3; ++i) {
    const Vec3d edge = toDouble(t.v[(i + 1) % 3]) - toDouble(t.v[i]);
    longest = std::max(longest, std::sqrt(dot(edge, edge)));
  }
  return longest;
}

// The stated error of a point of a contact [m].
double pointError(const Vec3f& p) { return 0x1p-22 * coordinate(p) + 0x1p-148; }

double distanceTo(const Vec3f& p, const Triangle& t) { return exactDistance({{p, p, p}}, t); }

double distanceTo(const Vec3f& p, const std::array<double, 3>& q) {
  return std::sqrt((p.x - q[0]) * (p.x - q[0]) + (p.y - q[1]) * (p.y - q[1]) +
                   (p.z - q[2]) * (p.z - q[2]));
}

bool meet(const TrianglesPair& pair) {
  PredicateState state;
  return trianglesIntersect(pair.a, pair.b, state);
}

bool isFiniteGeometry(const PairGeometry& g) {
  return isFinite(g.point_a) && isFinite(g.point_b) && isFinite(g.normal) &&
         std::isfinite(g.separation_m);
}

float lengthOf(const Vec3f& v) { return std::sqrt(dot(v, v)); }

std::string describe(const TrianglesPair& pair) {
  std::string text;
  for (const Triangle* t : {&pair.a, &pair.b}) {
    for (const Vec3f& v : t->v) {
      char point[80];
      std::snprintf(point, sizeof point, "{%a,%a,%a} ", v.x, v.y, v.z);
      text += point;
    }
  }
  return text;
}

std::string describe(const PairGeometry& g) {
  char text[300];
  std::snprintf(text, sizeof text, "(%.9g %.9g %.9g) (%.9g %.9g %.9g) n (%.9g %.9g %.9g) %.9g f%d",
                g.point_a.x, g.point_a.y, g.point_a.z, g.point_b.x, g.point_b.y, g.point_b.z,
                g.normal.x, g.normal.y, g.normal.z, g.separation_m, g.flags);
  return text;
}

class GeometryOfPair : public testing::TestWithParam<HardPairClass> {
 protected:
  // Calls check(pair) for many pairs of the class.
  void forPairs(long share, const std::function<void(const TrianglesPair&)>& check) {
    const char* wanted = std::getenv("DCM_FUZZ_PAIRS");
    const long count = (wanted != nullptr ? std::atol(wanted) : 8000) / share;
    GridDice dice(17);
    const bool any_size = std::string(GetParam().name) == "any_floats";
    for (long i = 0; i < count && !HasFatalFailure(); ++i) {
      const TrianglesPair pair = GetParam().make(&dice);
      const int power = any_size ? 0 : dice.within(-60, 20);
      const TrianglesPair scaled = scaledBy(pair, power);
      if (!isFinite(scaled.a) || !isFinite(scaled.b)) continue;
      SCOPED_TRACE("pair " + std::to_string(i) + ": " + describe(scaled));
      check(scaled);
    }
  }
};

// Which the verdict alone decides; never NaN, nor infinite.
TEST_P(GeometryOfPair, SeparationIsAboveZeroIffTheyAreApart) {
  long contacts = 0, apart = 0;
  forPairs(1, [&](const TrianglesPair& pair) {
    const bool contact = meet(pair);
    const PairGeometry g = geometryOf(pair.a, pair.b, 0);
    (contact ? contacts : apart) += 1;
    ASSERT_EQ(contact, g.separation_m <= 0) << describe(g);
    ASSERT_TRUE(isFiniteGeometry(g)) << describe(g);
    const float length = lengthOf(g.normal);
    if ((g.flags & kNormalUndefined) != 0) {
      ASSERT_EQ(0, length);
    } else {
      ASSERT_NEAR(1, length, 1e-6) << describe(g);
    }
    ASSERT_EQ(detail::hasArea(pair.a) && detail::hasArea(pair.b), (g.flags & kDegenerate) == 0);
    if ((g.flags & kCoplanar) != 0) {
      ASSERT_EQ(0, g.separation_m);
    }
    if (contact) return;
    const float given = 3;
    ASSERT_EQ(given, geometryOf(pair.a, pair.b, given).separation_m);
  });
  EXPECT_GT(contacts, 30);
  EXPECT_GT(contacts + apart, 1000);
}

TEST_P(GeometryOfPair, SwappingNegatesTheNormal) {
  forPairs(1, [&](const TrianglesPair& pair) {
    if (std::equal(pair.a.v, pair.a.v + 3, pair.b.v)) return;  // there is nothing to swap
    const bool contact = meet(pair);
    const PairGeometry g = geometryOf(pair.a, pair.b, 0);
    const PairGeometry swapped = geometryOf(pair.b, pair.a, 0);
    ASSERT_EQ(g.normal, swapped.normal * -1) << describe(g) << describe(swapped);
    ASSERT_EQ(0, std::memcmp(&g.separation_m, &swapped.separation_m, sizeof(float)));
    ASSERT_EQ(g.flags, swapped.flags);
    ASSERT_EQ(g.point_a, contact ? swapped.point_a : swapped.point_b);
    ASSERT_EQ(g.point_b, contact ? swapped.point_b : swapped.point_a);
  });
}

// The ends are those of the exact intersection, so they lie on both triangles.
TEST_P(GeometryOfPair, PointsAreTheEndsOfTheExactIntersection) {
  long contacts = 0;
  forPairs(8, [&](const TrianglesPair& pair) {
    if (!meet(pair)) return;
    ++contacts;
    const PairGeometry g = geometryOf(pair.a, pair.b, 0);
    const auto corners = commonCorners({pair.a.v[0], pair.a.v[1], pair.a.v[2]},
                                       {pair.b.v[0], pair.b.v[1], pair.b.v[2]});
    ASSERT_FALSE(corners.empty());
    double longest = 0;
    for (const auto& p : corners) {
      for (const auto& q : corners) {
        longest = std::max(longest, std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]));
      }
    }
    double error = 0;
    for (const Vec3f& end : {g.point_a, g.point_b}) {
      error += pointError(end);
      const double off = std::min({distanceTo(
          end, *std::min_element(corners.begin(), corners.end(), [&](const auto& p, const auto& q) {
            return distanceTo(end, p) < distanceTo(end, q);
          }))});
      ASSERT_LE(off, pointError(end)) << describe(g);
    }
    const Vec3d chord = toDouble(g.point_b) - toDouble(g.point_a);
    ASSERT_NEAR(longest, std::sqrt(dot(chord, chord)), error) << describe(g);
    if (longest == 0) {
      ASSERT_EQ(g.point_a, g.point_b);
    }
  });
  EXPECT_GT(contacts, 5);
}

TEST_P(GeometryOfPair, SeparationIsTheShortestPartingTranslation) {
  long contacts = 0, unique = 0;
  forPairs(8, [&](const TrianglesPair& pair) {
    if (!meet(pair)) return;
    const PairGeometry g = geometryOf(pair.a, pair.b, 0);
    ++contacts;
    if ((g.flags & kCoplanar) != 0) return;
    const double least = exactParting(pair.a, pair.b);
    if (least > FLT_MAX) {
      ASSERT_NE(0, g.flags & kSeparationUndefined);
      return;
    }
    ASSERT_EQ(0, g.flags & (kSeparationUndefined | kNormalUndefined));
    ASSERT_NEAR(-least, g.separation_m, 0x1p-23 * least + 0x1p-149) << describe(g);
    // The way is as short, but for the rounding of its direction.
    const double size = longestEdge(pair.a) + longestEdge(pair.b);
    ASSERT_LE(exactPartingAlong(pair.a, pair.b, g.normal), least * (1 + 1e-6) + 0x1p-22 * size);
    unique += (g.flags & kNormalNotUnique) == 0;
  });
  EXPECT_GT(contacts, 5);
}

// No direction that somebody might think of is shorter.
TEST_P(GeometryOfPair, NoSampledDirectionIsShorter) {
  std::mt19937 random(5);
  std::normal_distribution<float> any;
  forPairs(40, [&](const TrianglesPair& pair) {
    if (!meet(pair)) return;
    const PairGeometry g = geometryOf(pair.a, pair.b, 0);
    for (int i = 0; i < 30; ++i) {
      const Vec3f near = g.normal + Vec3f{any(random), any(random), any(random)} * 0.1F;
      const Vec3f wide{any(random), any(random), any(random)};
      for (const Vec3f& d : {near, wide}) {
        ASSERT_GE(exactPartingAlong(pair.a, pair.b, d), -double{g.separation_m} * (1 - 0x1p-22));
      }
    }
  });
}

TEST_P(GeometryOfPair, ClosestPointsAreAsFarApartAsTheTriangles) {
  long apart = 0;
  forPairs(8, [&](const TrianglesPair& pair) {
    if (meet(pair)) return;
    ++apart;
    const PairGeometry g = geometryOf(pair.a, pair.b, 0);
    const double distance = exactDistance(pair.a, pair.b);
    ASSERT_EQ(0, g.flags & (kCoplanar | kNormalUndefined | kNormalNotUnique));
    if (distance > FLT_MAX) {
      ASSERT_NE(0, g.flags & kSeparationUndefined);
      return;
    }
    ASSERT_NEAR(distance, g.separation_m, 0x1p-23 * distance + 0x1p-148) << describe(g);
    const double coarse = 0x1p-24 * std::min(longestEdge(pair.a), longestEdge(pair.b));
    const double error_a = pointError(g.point_a) + pointError(g.point_b) + coarse;
    ASSERT_LE(distanceTo(g.point_a, pair.a), error_a) << describe(g);
    ASSERT_LE(distanceTo(g.point_b, pair.b), error_a) << describe(g);
    const Vec3d between = toDouble(g.point_b) - toDouble(g.point_a);
    const Vec3d along = toDouble(g.normal) * distance;
    const Vec3d off = between - along;
    ASSERT_LE(std::sqrt(dot(off, off)), error_a + 1e-6 * distance) << describe(g);
  });
  EXPECT_TRUE(apart > 5 || GetParam().name == std::string("shared_corner")) << apart;
}

// A turned or mirrored pair has the turned or mirrored geometry, but for roundings in another
// order.
TEST_P(GeometryOfPair, TurnsWithThePair) {
  const std::function<Vec3f(const Vec3f&)> turns[] = {[](const Vec3f& v) {
                                                        return Vec3f{v.y, v.z, v.x};
                                                      },
                                                      [](const Vec3f& v) {
                                                        return Vec3f{-v.x, v.y, v.z};
                                                      },
                                                      [](const Vec3f& v) {
                                                        return Vec3f{v.y, -v.x, v.z};
                                                      },
                                                      [](const Vec3f& v) {
                                                        return Vec3f{-v.z, -v.y, -v.x};
                                                      }};
  forPairs(4, [&](const TrianglesPair& pair) {
    const PairGeometry g = geometryOf(pair.a, pair.b, 0);
    for (const auto& turn : turns) {
      TrianglesPair turned;
      for (int i = 0; i < 3; ++i) {
        turned.a.v[i] = turn(pair.a.v[i]);
        turned.b.v[i] = turn(pair.b.v[i]);
      }
      const PairGeometry h = geometryOf(turned.a, turned.b, 0);
      ASSERT_NEAR(g.separation_m, h.separation_m, 0x1p-22 * std::abs(double{g.separation_m}));
      const int unstable = kNormalNotUnique;  // a tie that rounding decides
      ASSERT_EQ(g.flags & ~unstable, h.flags & ~unstable);
      if (((g.flags | h.flags) & kNormalNotUnique) != 0) continue;
      const double error = g.separation_m > 0 ? 0x1p-13 : 1e-6;
      ASSERT_LE(lengthOf(turn(g.normal) - h.normal), error) << describe(g) << describe(h);
    }
  });
}

// Moved by that and a little more, they are apart; by a little less, they touch: in floats, so on
// pairs whose depth is far above their rounding.
TEST_P(GeometryOfPair, PartsThem) {
  long parted = 0;
  forPairs(4, [&](const TrianglesPair& pair) {
    if (!meet(pair)) return;
    const PairGeometry g = geometryOf(pair.a, pair.b, 0);
    const double depth = -double{g.separation_m}, size = sizeOf(pair.a) + sizeOf(pair.b);
    if (depth < 1e-4 * size || size < 1e-25) return;
    const auto moved = [&](double by) {
      TrianglesPair away = pair;
      for (Vec3f& v : away.b.v) v = toFloat(toDouble(v) + toDouble(g.normal) * by);
      return away;
    };
    ++parted;
    ASSERT_FALSE(meet(moved(depth + 1e-6 * size))) << describe(g);
    ASSERT_TRUE(meet(moved(depth - 1e-6 * size))) << describe(g);
  });
}

INSTANTIATE_TEST_SUITE_P(, GeometryOfPair, testing::ValuesIn(allClasses()),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace deformable_contact_monitor
