#include "geometry_pairs.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "core/predicates/intersection_segment.h"
#include "core/predicates/narrow_phase.h"

namespace deformable_contact_monitor {

float real(GridDice* dice, float size) {
  return size * (static_cast<float>(dice->within(-(1 << 23), 1 << 23)) * 0x1p-23F);
}

Vec3f realPoint(GridDice* dice, float size) {
  return {real(dice, size), real(dice, size), real(dice, size)};
}

Triangle realTriangle(GridDice* dice, float size) {
  return {{realPoint(dice, size), realPoint(dice, size), realPoint(dice, size)}};
}

namespace {

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

double coordinate(const Vec3f& v) { return largestCoordinate(toDouble(v)); }

}  // namespace

bool meet(const TrianglesPair& pair) {
  PredicateState state;
  return trianglesIntersect(pair.a, pair.b, state);
}

double sizeOf(const Triangle& t) {
  return std::max({coordinate(t.v[0]), coordinate(t.v[1]), coordinate(t.v[2])});
}

Vec3d edgeOf(const Triangle& t, int i) { return toDouble(t.v[(i + 1) % 3]) - toDouble(t.v[i]); }

double longestEdge(const Triangle& t) {
  double longest = 0;
  for (int i = 0; i < 3; ++i) {
    longest = std::max(longest, lengthOf(edgeOf(t, i)));
  }
  return longest;
}

double pointError(const Vec3f& p) { return 0x1p-22 * coordinate(p) + 0x1p-148; }

float lengthOf(const Vec3f& v) { return std::sqrt(dot(v, v)); }

double lengthOf(const Vec3d& v) { return std::sqrt(dot(v, v)); }

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

void PairClassSuite::forPairs(long share, const std::function<void(const TrianglesPair&)>& check) {
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

std::vector<HardPairClass> geometryPairClasses() {
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

}  // namespace deformable_contact_monitor
