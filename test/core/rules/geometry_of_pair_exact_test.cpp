// The geometry of single pairs, against exact rationals.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <random>
#include <string>

#include "core/rules/geometry_of_pair.h"
#include "exact_clip.h"
#include "exact_distance.h"
#include "exact_parting.h"
#include "geometry_pairs.h"

namespace deformable_contact_monitor {
namespace {

double distanceTo(const Vec3f& p, const Triangle& t) { return exactDistance({{p, p, p}}, t); }

double distanceTo(const Vec3f& p, const std::array<double, 3>& q) {
  return std::sqrt((p.x - q[0]) * (p.x - q[0]) + (p.y - q[1]) * (p.y - q[1]) +
                   (p.z - q[2]) * (p.z - q[2]));
}

class ExactGeometryOfPair : public PairClassSuite {};

// The ends are those of the exact intersection, so they lie on both triangles.
TEST_P(ExactGeometryOfPair, PointsAreTheEndsOfTheExactIntersection) {
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

TEST_P(ExactGeometryOfPair, SeparationIsTheShortestPartingTranslation) {
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
TEST_P(ExactGeometryOfPair, NoSampledDirectionIsShorter) {
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

TEST_P(ExactGeometryOfPair, ClosestPointsAreAsFarApartAsTheTriangles) {
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
    const auto error = [&](const Vec3f& p) {
      return std::max(pointError(p), 0x1p-50 * distance) + coarse;
    };
    ASSERT_LE(distanceTo(g.point_a, pair.a), error(g.point_a)) << describe(g);
    ASSERT_LE(distanceTo(g.point_b, pair.b), error(g.point_b)) << describe(g);
    const Vec3d between = toDouble(g.point_b) - toDouble(g.point_a);
    const Vec3d along = toDouble(g.normal) * distance;
    const Vec3d off = between - along;
    ASSERT_LE(std::sqrt(dot(off, off)), error(g.point_a) + error(g.point_b) + 1e-6 * distance)
        << describe(g);
  });
  EXPECT_TRUE(apart > 5 || GetParam().name == std::string("shared_corner")) << apart;
}

INSTANTIATE_TEST_SUITE_P(, ExactGeometryOfPair, testing::ValuesIn(geometryPairClasses()),
                         pairClassName);

}  // namespace
}  // namespace deformable_contact_monitor
