// The geometry of triangles that are near each other, against FCL's closest points.
//
// FCL works in double, with rounding, and passes over faces whose doubled area is below 3.2e-8 m2:
// with edges of 15 um it says of two thirds of near pairs that they touch. So these triangles are
// not tiny; and they are no slivers, and no edge is nearly parallel to an edge or the plane of the
// other, where closest points hang on rounding. Those are held against exact rationals
// (geometry_of_pair_exact_test.cpp).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/predicates/narrow_phase.h"
#include "core/rules/geometry_of_pair.h"
#include "geometry_pairs.h"

#ifdef DCM_HAVE_FCL

#include <fcl/narrowphase/detail/primitive_shape_algorithm/triangle_distance.h>

namespace deformable_contact_monitor {
namespace {

// Where two triangles are closest, as FCL computes it: in double, with rounding.
struct FclClosestPoints {
  Vec3d on_a, on_b;
  double distance = 0;  // [m]
};

fcl::Vector3d toFcl(const Vec3f& v) { return {v.x, v.y, v.z}; }

Vec3d fromFcl(const fcl::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

// Returns the closest points of triangles that do not intersect.
FclClosestPoints fclClosestPoints(const Triangle& a, const Triangle& b) {
  const fcl::Vector3d of_a[3] = {toFcl(a.v[0]), toFcl(a.v[1]), toFcl(a.v[2])};
  const fcl::Vector3d of_b[3] = {toFcl(b.v[0]), toFcl(b.v[1]), toFcl(b.v[2])};
  fcl::Vector3d on_a, on_b;
  const double distance =
      fcl::detail::TriangleDistance<double>::triDistance(of_a, of_b, on_a, on_b);
  return {fromFcl(on_a), fromFcl(on_b), distance};
}

double sine(const Vec3d& u, const Vec3d& v) {
  return lengthOf(cross(u, v)) / (lengthOf(u) * lengthOf(v));
}

bool isWellConditioned(const TrianglesPair& pair) {
  constexpr double kLeast = 0.05;
  const auto normalOf = [](const Triangle& t) { return cross(edgeOf(t, 0), edgeOf(t, 1)); };
  const Vec3d normal_a = normalOf(pair.a), normal_b = normalOf(pair.b);
  const auto slope = [](const Vec3d& edge, const Vec3d& normal) {
    return std::abs(dot(edge, normal)) / (lengthOf(edge) * lengthOf(normal));
  };
  for (int i = 0; i < 3; ++i) {
    for (const Triangle* t : {&pair.a, &pair.b}) {
      if (sine(edgeOf(*t, i), edgeOf(*t, (i + 1) % 3)) < 0.2) return false;
    }
    if (slope(edgeOf(pair.a, i), normal_b) < kLeast) return false;
    if (slope(edgeOf(pair.b, i), normal_a) < kLeast) return false;
    for (int j = 0; j < 3; ++j) {
      if (sine(edgeOf(pair.a, i), edgeOf(pair.b, j)) < kLeast) return false;
    }
  }
  return true;
}

// A vertex, or a point within an edge or the face.
Vec3f pointOn(const Triangle& t, GridDice* dice) {
  const int kind = dice->within(0, 2), first = dice->within(0, 2);
  const Vec3f &p = t.v[first], &q = t.v[(first + 1) % 3], &r = t.v[(first + 2) % 3];
  const float s = kind == 0 ? 0 : dice->eighths(1, 4), u = kind < 2 ? 0 : dice->eighths(1, 3);
  return p + (q - p) * s + (r - p) * u;
}

// b is put where a point of it is at most `gap` away from a point of a, 2^-16 to 1/4 of their size.
TrianglesPair nearPair(GridDice* dice, float* gap) {
  const float size = std::ldexp(1.0F, dice->within(-4, 8));
  TrianglesPair pair{realTriangle(dice, size), realTriangle(dice, size)};
  *gap = std::ldexp(size, -dice->within(2, 16));
  const Vec3f on_a = pointOn(pair.a, dice), on_b = pointOn(pair.b, dice);
  const Vec3f by = on_a + realPoint(dice, *gap * 0.5F) - on_b;
  for (Vec3f& v : pair.b.v) v = v + by;
  return pair;
}

// Calls check(pair, its geometry as a NEAR pair, what FCL says).
template <class Check>
void forNearPairs(const Check& check) {
  GridDice dice(29);
  long seen = 0;
  for (int i = 0; i < 60000 && !testing::Test::HasFatalFailure(); ++i) {
    float gap;
    const TrianglesPair pair = nearPair(&dice, &gap);
    if (!isWellConditioned(pair) || meet(pair)) continue;
    ++seen;
    SCOPED_TRACE("pair " + std::to_string(i) + ": " + describe(pair));
    const Verdict verdict = nearVerdict(pair.a, pair.b, gap);
    ASSERT_TRUE(verdict.contact);
    check(pair, geometryOf(pair.a, pair.b, verdict.separation_m), fclClosestPoints(pair.a, pair.b));
  }
  EXPECT_GT(seen, 5000);
}

double sizeOf(const TrianglesPair& pair) { return std::max(sizeOf(pair.a), sizeOf(pair.b)); }

// But for the rounding of ours to float32, and of FCL's in double.
TEST(GeometryOfNearPair, SeparationIsFcls) {
  forNearPairs([](const TrianglesPair& pair, const PairGeometry& g, const FclClosestPoints& fcl) {
    ASSERT_NEAR(fcl.distance, g.separation_m, 0x1p-24 * fcl.distance + 0x1p-44 * sizeOf(pair));
  });
}

// But for the stated error of ours.
TEST(GeometryOfNearPair, ClosestPointsAreFcls) {
  forNearPairs([](const TrianglesPair& pair, const PairGeometry& g, const FclClosestPoints& fcl) {
    const double error =
        0x1p-22 * sizeOf(pair) + 0x1p-24 * std::min(longestEdge(pair.a), longestEdge(pair.b));
    ASSERT_LE(lengthOf(toDouble(g.point_a) - fcl.on_a), error) << describe(g);
    ASSERT_LE(lengthOf(toDouble(g.point_b) - fcl.on_b), error) << describe(g);
  });
}

// The way from FCL's one point to the other, but for the same roundings.
TEST(GeometryOfNearPair, NormalIsTheWayBetweenFclsPoints) {
  forNearPairs([](const TrianglesPair& pair, const PairGeometry& g, const FclClosestPoints& fcl) {
    const Vec3d between = fcl.on_b - fcl.on_a;
    const Vec3d off = between - toDouble(g.normal) * fcl.distance;
    ASSERT_LE(lengthOf(off), 0x1p-22 * fcl.distance + 0x1p-44 * sizeOf(pair)) << describe(g);
  });
}

}  // namespace
}  // namespace deformable_contact_monitor

#endif
