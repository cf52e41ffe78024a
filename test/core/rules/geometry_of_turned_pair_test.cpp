// The geometry of a pair turns with it: by quarter turns and mirrors, which floats hold exactly,
// and by any rotation and translation, rounded to float32.
//
// `error` below is how far that rounding moves a vertex. The separation of two triangles follows
// their vertices: by twice that at most, once for each triangle. What is said of normals follows
// from it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/rules/geometry_of_pair.h"
#include "geometry_pairs.h"

namespace deformable_contact_monitor {
namespace {

Vec3d unitOf(const Vec3d& v) { return v * (1 / lengthOf(v)); }

// How far b must move along the unit vector d until it is clear of a [m]; < 0: as far as it is.
double wayOut(const TrianglesPair& pair, const Vec3d& d) {
  const Vec3d origin = toDouble(pair.a.v[0]);
  double top = -INFINITY, bottom = INFINITY;
  for (int i = 0; i < 3; ++i) {
    top = std::max(top, dot(d, toDouble(pair.a.v[i]) - origin));
    bottom = std::min(bottom, dot(d, toDouble(pair.b.v[i]) - origin));
  }
  return top - bottom;
}

// A rotation, uniform among all, then a translation by up to twice the pair's size.
class Motion {
 public:
  Motion(double size, std::mt19937* random) {
    std::normal_distribution<double> any;
    const auto anyVector = [&] { return Vec3d{any(*random), any(*random), any(*random)}; };
    row_[0] = unitOf(anyVector());
    row_[1] = unitOf(cross(row_[0], anyVector()));
    row_[2] = cross(row_[0], row_[1]);
    std::uniform_real_distribution<double> within(-2 * size, 2 * size);
    translation_ = {within(*random), within(*random), within(*random)};
  }

  Vec3d turned(const Vec3d& v) const { return {dot(row_[0], v), dot(row_[1], v), dot(row_[2], v)}; }
  Vec3d moved(const Vec3f& p) const { return turned(toDouble(p)) + translation_; }
  TrianglesPair moved(const TrianglesPair& pair) const {
    TrianglesPair out;
    for (int i = 0; i < 3; ++i) {
      out.a.v[i] = toFloat(moved(pair.a.v[i]));
      out.b.v[i] = toFloat(moved(pair.b.v[i]));
    }
    return out;
  }

 private:
  Vec3d row_[3], translation_;
};

// A pair and what became of it.
struct Turned {
  TrianglesPair before, after;
  PairGeometry g, h;
  double error;  // of a vertex [m]
  double slack;  // of a way out along a turned normal [m]

  Turned(const TrianglesPair& pair, const TrianglesPair& moved) : before(pair), after(moved) {
    g = geometryOf(before.a, before.b, 0);
    h = geometryOf(after.a, after.b, 0);
    error =
        0x1p-23 * std::max({sizeOf(before.a), sizeOf(before.b), sizeOf(after.a), sizeOf(after.b)}) +
        0x1p-148;
    // The slack covers the errors of both separations, and the rounding of a normal.
    slack = 4 * error + 0x1p-22 * (std::abs(double{g.separation_m}) + longestEdge(before.a) +
                                   longestEdge(before.b));
  }
};

class GeometryOfTurnedPair : public PairClassSuite {
 protected:
  // Calls check(turned, motion) for pairs that touch, turned at random, as far as floats reach.
  void forTurned(const std::function<void(const Turned&, const Motion&)>& check) {
    std::mt19937 random(23);
    forPairs(1, [&](const TrianglesPair& pair) {
      if (!meet(pair)) return;
      const Motion motion(std::max(sizeOf(pair.a), sizeOf(pair.b)), &random);
      const TrianglesPair moved = motion.moved(pair);
      if (!isFinite(moved.a) || !isFinite(moved.b)) return;
      const Turned turned(pair, moved);
      if (((turned.g.flags | turned.h.flags) & kSeparationUndefined) != 0) return;
      check(turned, motion);
    });
  }
  bool isGeneral() const { return GetParam().name == std::string("ordinary"); }
};

// A turned or mirrored pair has the turned or mirrored geometry, but for roundings in another
// order.
TEST_P(GeometryOfTurnedPair, TurnsWithThePair) {
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

TEST_P(GeometryOfTurnedPair, HasTheSameSeparation) {
  long seen = 0;
  forTurned([&](const Turned& t, const Motion&) {
    ++seen;
    const double before = t.g.separation_m, after = t.h.separation_m;
    ASSERT_NEAR(before, after, 2 * t.error + 0x1p-22 * std::abs(before)) << describe(t.h);
  });
  EXPECT_GT(seen, 30);
}

TEST_P(GeometryOfTurnedPair, ItsShortestWayOutIsTheTurnedNormal) {
  long seen = 0;
  forTurned([&](const Turned& t, const Motion& motion) {
    if ((t.g.flags & kNormalUndefined) != 0) return;
    ++seen;
    const Vec3d turned = unitOf(motion.turned(toDouble(t.g.normal)));
    ASSERT_LE(wayOut(t.after, turned), -double{t.h.separation_m} + t.slack) << describe(t.h);
  });
  EXPECT_GT(seen, 30);
}

// By how much the second-shortest way out is longer than the one along n: least of all those across
// a face of either triangle, or edges of both, but for those that are n's.
double leadOf(const TrianglesPair& pair, const Vec3d& n) {
  std::vector<Vec3d> ways = {cross(edgeOf(pair.a, 0), edgeOf(pair.a, 1)),
                             cross(edgeOf(pair.b, 0), edgeOf(pair.b, 1))};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) ways.push_back(cross(edgeOf(pair.a, i), edgeOf(pair.b, j)));
  }
  double second = INFINITY;
  for (const Vec3d& way : ways) {
    if (!(lengthOf(way) > 0)) continue;
    for (const double sign : {1, -1}) {
      const Vec3d d = unitOf(way) * sign;
      if (lengthOf(d - n) > 1e-6) second = std::min(second, wayOut(pair, d));
    }
  }
  return second - wayOut(pair, n);
}

// Where the way along the normal is shorter than the next by `lead`, the plane that it leads to
// reaches at least that far about its foot. A direction within `slack` of it is then within
// 2 slack / lead [rad], if that is small; and so are both normals.
TEST_P(GeometryOfTurnedPair, ItsNormalIsTheTurnedOne) {
  long clear = 0;
  forTurned([&](const Turned& t, const Motion& motion) {
    if ((t.g.flags & (kCoplanar | kDegenerate)) != 0) return;
    const double lead = leadOf(t.before, unitOf(toDouble(t.g.normal)));
    const double angle = 2 * t.slack / lead;
    if (!(lead > 0 && angle < std::min(0.1, lead / (2 * std::abs(t.g.separation_m))))) return;
    ++clear;
    if (isGeneral()) {  // in others several ways within that angle may be as short
      ASSERT_EQ(0, (t.g.flags | t.h.flags) & kNormalNotUnique) << describe(t.g) << describe(t.h);
    }
    const Vec3d off = unitOf(motion.turned(toDouble(t.g.normal))) - toDouble(t.h.normal);
    ASSERT_LE(lengthOf(off), 2 * angle + 2e-6) << describe(t.g) << describe(t.h);
  });
  if (isGeneral()) {
    EXPECT_GT(clear, 100);
  }
}

// The least sine of the angles of edges of either with the plane of the other.
double leastSlope(const TrianglesPair& pair) {
  double least = 1;
  for (const auto& [t, u] : {std::make_pair(pair.a, pair.b), std::make_pair(pair.b, pair.a)}) {
    const Vec3d normal = unitOf(cross(edgeOf(t, 0), edgeOf(t, 1)));
    for (int i = 0; i < 3; ++i) {
      least = std::min(least, std::abs(dot(normal, unitOf(edgeOf(u, i)))));
    }
  }
  return least;
}

// An edge that crosses a plane at a slope does so at a point that moves by three times the error
// at most, divided by the slope.
TEST_P(GeometryOfTurnedPair, ItsEndsAreTheTurnedOnes) {
  long general = 0;
  forTurned([&](const Turned& t, const Motion& motion) {
    if ((t.g.flags & (kCoplanar | kDegenerate)) != 0 || t.h.separation_m > 0) return;
    const double slope = leastSlope(t.before);
    if (!(slope > 0.02)) return;
    ++general;
    const auto off = [&](const Vec3f& p, const Vec3f& end) {
      return lengthOf(motion.moved(p) - toDouble(end));
    };
    const PairGeometry &g = t.g, &h = t.h;
    const double same = std::max(off(g.point_a, h.point_a), off(g.point_b, h.point_b));
    const double crossed = std::max(off(g.point_a, h.point_b), off(g.point_b, h.point_a));
    // The points' own errors are two of `error` each.
    ASSERT_LE(std::min(same, crossed), (3 / slope + 4) * t.error) << describe(g) << describe(h);
  });
  if (isGeneral()) {
    EXPECT_GT(general, 100);
  }
}

INSTANTIATE_TEST_SUITE_P(, GeometryOfTurnedPair, testing::ValuesIn(geometryPairClasses()),
                         pairClassName);

}  // namespace
}  // namespace deformable_contact_monitor
