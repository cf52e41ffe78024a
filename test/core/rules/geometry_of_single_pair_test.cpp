// The geometry of pairs that can be checked by hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cfloat>
#include <cmath>

#include "core/rules/geometry_of_pair.h"

namespace deformable_contact_monitor {
namespace {

float lengthOf(const Vec3f& v) { return std::sqrt(dot(v, v)); }

PairGeometry of(const Triangle& a, const Triangle& b) { return geometryOf(a, b, 0); }

constexpr Vec3f kOrigin{0, 0, 0};
const Triangle kFlat{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};

// A blade that stands through a flat triangle, its tip 0.5 below: that much is the shortest way.
TEST(GeometryOfSinglePair, ABladeThroughAFlatTriangle) {
  const Triangle blade{{{1, 1, -0.5F}, {0.5F, 1, 2}, {1.5F, 1, 2}}};
  const PairGeometry g = of(kFlat, blade);
  EXPECT_EQ(-0.5F, g.separation_m);
  EXPECT_EQ((Vec3f{0, 0, 1}), g.normal);
  EXPECT_EQ(0, g.flags);
  EXPECT_NEAR(0.2F, std::abs(g.point_a.x - g.point_b.x), 1e-6);
  EXPECT_EQ((Vec3f{0, 0, -1}), of(blade, kFlat).normal);
}

// The depth is the same on either side: the choice is one of two, and flagged.
TEST(GeometryOfSinglePair, TwoWaysAsShortAreFlagged) {
  const Triangle blade{{{1, 1, -1}, {0.5F, 1, 1}, {1.5F, 1, 1}}};
  const PairGeometry g = of(kFlat, blade);
  EXPECT_EQ(-1, g.separation_m);
  EXPECT_EQ(kNormalNotUnique, g.flags);
  EXPECT_EQ(1, std::abs(g.normal.z));
}

TEST(GeometryOfSinglePair, ATipThatTouches) {
  const Triangle tip{{{1, 1, 0}, {1, 0, 2}, {2, 1, 2}}};
  const PairGeometry g = of(kFlat, tip);
  EXPECT_EQ(0, g.separation_m);
  EXPECT_FALSE(std::signbit(g.separation_m));
  EXPECT_EQ((Vec3f{1, 1, 0}), g.point_a);
  EXPECT_EQ(g.point_a, g.point_b);
  EXPECT_EQ((Vec3f{0, 0, 1}), g.normal);
  EXPECT_EQ(0, g.flags);
}

TEST(GeometryOfSinglePair, VertexOnVertexHasNoOneWay) {
  const Triangle other{{{0, 0, 0}, {-1, 0, 1}, {0, -1, 1}}};
  const PairGeometry g = of(kFlat, other);
  EXPECT_EQ(0, g.separation_m);
  EXPECT_EQ(kOrigin, g.point_a);
  EXPECT_EQ(kNormalNotUnique, g.flags);
}

TEST(GeometryOfSinglePair, CoplanarOnesGiveTheLongestChord) {
  const Triangle over{{{1, 1, 0}, {-3, 1, 0}, {1, -3, 0}}};  // they share a hexagon's half
  const PairGeometry g = of(kFlat, over);
  EXPECT_EQ(kCoplanar | kNormalNotUnique, g.flags);
  EXPECT_EQ(0, g.separation_m);
  EXPECT_EQ(1, std::abs(g.normal.z));
  EXPECT_FLOAT_EQ(std::sqrt(2.0F), lengthOf(g.point_a - g.point_b));
}

TEST(GeometryOfSinglePair, SegmentsAndPoints) {
  const auto segment = [](const Vec3f& p, const Vec3f& q) { return Triangle{{p, q, p}}; };
  const auto point = [](const Vec3f& p) { return Triangle{{p, p, p}}; };
  const Triangle stick = segment({1, 1, -0.5F}, {1, 1, 3});
  PairGeometry g = of(kFlat, stick);
  EXPECT_EQ(kDegenerate, g.flags);
  EXPECT_EQ(-0.5F, g.separation_m);
  EXPECT_EQ((Vec3f{1, 1, 0}), g.point_a);
  EXPECT_EQ(g.point_a, g.point_b);

  g = of(kFlat, point({1, 1, 0}));  // a plane, left on either side
  EXPECT_EQ(kDegenerate | kCoplanar | kNormalNotUnique, g.flags);
  EXPECT_EQ(1, std::abs(g.normal.z));
  EXPECT_EQ((Vec3f{1, 1, 0}), g.point_b);

  g = of(stick, segment({0, 1, 0}, {2, 1, 0}));
  EXPECT_EQ(kDegenerate | kCoplanar | kNormalNotUnique, g.flags);
  EXPECT_EQ(1, std::abs(g.normal.y));
  EXPECT_EQ(0, g.separation_m);

  for (const Triangle& other : {point({1, 1, 2}), segment({1, 1, 1}, {1, 1, 9})}) {
    g = of(stick, other);
    EXPECT_EQ(kDegenerate | kCoplanar | kNormalUndefined, g.flags);
    EXPECT_EQ(kOrigin, g.normal);
    EXPECT_EQ(0, g.separation_m);
  }
  EXPECT_EQ(2, lengthOf(of(stick, segment({1, 1, 1}, {1, 1, 9})).point_a - Vec3f{1, 1, 1}) +
                   lengthOf(of(stick, segment({1, 1, 1}, {1, 1, 9})).point_b - Vec3f{1, 1, 1}));
  EXPECT_EQ(kDegenerate | kCoplanar | kNormalUndefined,
            of(point({1, 2, 3}), point({1, 2, 3})).flags);
}

// The whole closed intersection, also of neighbours: their common edge, or how they fold.
TEST(GeometryOfSinglePair, NeighboursFoldedOverTheirEdge) {
  const Triangle folded{{{4, 0, 0}, {0, 0, 0}, {1, 1, 0}}};
  PairGeometry g = of(kFlat, folded);
  EXPECT_EQ(kCoplanar | kNormalNotUnique, g.flags);
  EXPECT_EQ(4, lengthOf(g.point_a - g.point_b));
  const Triangle upright{{{4, 0, 0}, {0, 0, 0}, {1, 0, 1}}};
  g = of(kFlat, upright);
  EXPECT_EQ(0, g.separation_m);
  EXPECT_EQ(4, lengthOf(g.point_a - g.point_b));
}

// Where no float holds the depth, it says so.
TEST(GeometryOfSinglePair, ADepthBeyondFloats) {
  const float far = FLT_MAX;
  const Triangle a{{{-far, -far, 0}, {far, -far, 0}, {0, far, 0}}};
  const Triangle b{{{0, -far, -far}, {0, -far, far}, {0, far, 0}}};
  const PairGeometry g = of(a, b);
  EXPECT_TRUE(isFinite(g.point_a) && isFinite(g.point_b) && isFinite(g.normal));
  EXPECT_LE(g.separation_m, 0);
}

// The foot of the perpendicular from a vertex 1e10 m away has coordinates of millimetres. Its error
// is a part of the distance.
TEST(GeometryOfSinglePair, AClosestPointFarFromTheOther) {
  const Triangle slope{{{-3, -1, -2.5F}, {4, 0.5F, 2}, {-1, 3, 0.75F}}};
  const Vec3d normal = cross(toDouble(slope.v[1]) - toDouble(slope.v[0]),
                             toDouble(slope.v[2]) - toDouble(slope.v[0]));
  const double size = std::sqrt(dot(normal, normal));
  const Vec3f far = toFloat(normal * (1e10 / size));
  const PairGeometry g = of(slope, Triangle{{far, far, far}});
  EXPECT_NEAR(1e10, g.separation_m, 1e4);
  const double error = std::max(
      0x1p-22 * std::max({std::abs(g.point_a.x), std::abs(g.point_a.y), std::abs(g.point_a.z)}),
      0x1p-50 * g.separation_m);
  EXPECT_LE(std::abs(dot(toDouble(g.point_a) - toDouble(slope.v[0]), normal)) / size, error);
  EXPECT_EQ(far, g.point_b);
}

// The normal is negated if a and b are swapped. Triangles that are equal cannot be told apart.
TEST(GeometryOfSinglePair, EqualTrianglesHaveANormalOfSomeSign) {
  const PairGeometry g = of(kFlat, kFlat);
  EXPECT_EQ(1, lengthOf(g.normal));
  EXPECT_NE(0, g.flags & kCoplanar);
}

// An edge from one end of the floats to the other, through a small triangle.
TEST(GeometryOfSinglePair, AnEdgeFromFarToFar) {
  const Triangle small{{{0.1F, -1, -1}, {0.1F, 1, -1}, {0.1F, 0, 1}}};
  const Triangle far{{{-1e30F, 0.25F, -0.125F}, {1.5e30F, 0.25F, -0.125F}, {7e29F, 3e30F, 9}}};
  const PairGeometry g = of(small, far);
  EXPECT_NEAR(0.1F, g.point_a.x, 1e-7);
  EXPECT_NEAR(0.1F, g.point_b.x, 1e-7);
  const bool a_is_the_edges = std::abs(g.point_a.y - 0.25F) < 1e-6;
  const Vec3f& on_edge = a_is_the_edges ? g.point_a : g.point_b;
  EXPECT_NEAR(0.25F, on_edge.y, 1e-7);
  EXPECT_NEAR(-0.125F, on_edge.z, 1e-7);
}

}  // namespace
}  // namespace deformable_contact_monitor
