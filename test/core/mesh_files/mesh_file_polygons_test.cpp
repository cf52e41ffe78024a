// Tests that the triangles of a polygon are the polygon. The oracle uses integers only, so it is
// exact: areas, and in how many triangles sample points are.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <random>
#include <set>
#include <sstream>

#include "core/mesh_files/mesh_readers.h"
#include "mesh_file_fixture.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

struct Point {
  std::int64_t x = 0, y = 0;
};
using Polygon = std::vector<Point>;

bool operator==(const Point& a, const Point& b) { return a.x == b.x && a.y == b.y; }

std::int64_t cross(const Point& a, const Point& b, const Point& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

std::int64_t doubledArea(const Polygon& polygon) {
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    sum += a.x * b.y - a.y * b.x;
  }
  return sum;
}

bool isOnBoundary(const Polygon& polygon, const Point& p) {
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    if (cross(a, b, p) == 0 && std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) &&
        std::min(a.y, b.y) <= p.y && p.y <= std::max(a.y, b.y)) {
      return true;
    }
  }
  return false;
}

// By the number of sides to the right of the point, which must not be on one.
bool isInside(const Polygon& polygon, const Point& p) {
  bool is_inside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    Point a = polygon[i], b = polygon[(i + 1) % polygon.size()];
    if (a.y > b.y) std::swap(a, b);
    if (a.y <= p.y && p.y < b.y && cross(a, b, p) > 0) is_inside = !is_inside;
  }
  return is_inside;
}

// Where the plane of the polygon is: a point is u x + v y + offset, exact in float32.
struct Plane {
  std::array<int, 3> u = {1, 0, 0}, v = {0, 1, 0}, offset = {0, 0, 0};
  double unit = 1;  // a power of two
};
const std::vector<Plane> kPlanes = {{},
                                    {{0, 0, 1}, {1, 0, 0}, {0, 7, 0}, 0.25},
                                    {{1, -1, 0}, {1, 0, -1}, {9, 9, 9}, 1.0 / 1024},
                                    {{3, 5, -2}, {-1, 4, 7}, {-1000, 3, 77}, 0x1p-40},
                                    {{0, 2, 1}, {1, 0, 3}, {1, 2, 3}, 0x1p60}};

// An OBJ file of the polygon, from corner `start` on.
std::string objOf(const Polygon& polygon, const Plane& plane, std::size_t start) {
  std::ostringstream text;
  text.precision(9);
  for (const Point& p : polygon) {
    text << "v";
    for (int axis = 0; axis < 3; ++axis) {
      text << " "
           << plane.unit * static_cast<double>(plane.u[axis] * p.x + plane.v[axis] * p.y +
                                               plane.offset[axis]);
    }
    text << "\n";
  }
  text << "f";
  for (std::size_t i = 0; i < polygon.size(); ++i) text << " " << (start + i) % polygon.size() + 1;
  text << "\n";
  return text.str();
}

using Triangles = std::vector<Polygon>;

TriangleMesh readObjText(const std::string& text, std::vector<std::string>* notes) {
  MeshFileReport report;
  TriangleMesh mesh = readMeshContent("polygon.obj", text, &report);
  *notes = report.notes;
  return mesh;
}

Triangles trianglesOf(const Polygon& polygon, const Plane& plane, std::size_t start) {
  std::vector<std::string> notes;
  const TriangleMesh mesh = readObjText(objOf(polygon, plane, start), &notes);
  EXPECT_TRUE(notes.empty()) << notes[0];
  EXPECT_EQ(mesh.triangleCount(), polygon.size() - 2);
  Triangles triangles;
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t) {
    triangles.emplace_back();
    for (int k = 0; k < 3; ++k) triangles.back().push_back(polygon[mesh.triangles[3 * t + k]]);
  }
  return triangles;
}

// Each side of the polygon belongs to one triangle, and each other side to two, in both directions:
// the surface stays closed where its polygons are.
void expectEdgesMatch(const Polygon& polygon, const Plane& plane) {
  std::vector<std::string> notes;
  const TriangleMesh mesh = readObjText(objOf(polygon, plane, 0), &notes);
  std::multiset<std::pair<std::uint32_t, std::uint32_t>> open;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::uint32_t a = mesh.triangles[i], b = mesh.triangles[i % 3 == 2 ? i - 2 : i + 1];
    const auto other = open.find({b, a});
    other == open.end() ? (void)open.insert({a, b}) : (void)open.erase(other);
  }
  ASSERT_EQ(open.size(), polygon.size());
  for (std::uint32_t i = 0; i < polygon.size(); ++i) {
    const std::pair<std::uint32_t, std::uint32_t> side(i, (i + 1) % polygon.size());
    ASSERT_EQ(open.count(side), 1U) << i;
  }
}

// The triangles' areas add up to the polygon's, and sample points are in one triangle if they are
// in the polygon, and else in none. Points on sides are left out.
void expectCovers(const Triangles& triangles, const Polygon& polygon, int samples) {
  std::int64_t sum = 0;
  const std::int64_t whole = doubledArea(polygon);
  for (const Polygon& triangle : triangles) {
    const std::int64_t area = doubledArea(triangle);
    ASSERT_TRUE(area == 0 || (area > 0) == (whole > 0));  // the outside is kept
    sum += area;
  }
  ASSERT_EQ(sum, whole);
  std::int64_t low_x = polygon[0].x, high_x = low_x, low_y = polygon[0].y, high_y = low_y;
  for (const Point& p : polygon) {
    low_x = std::min(low_x, p.x);
    high_x = std::max(high_x, p.x);
    low_y = std::min(low_y, p.y);
    high_y = std::max(high_y, p.y);
  }
  std::mt19937_64 random(11);
  for (int i = 0; i < samples; ++i) {
    const auto within = [&random](std::int64_t low, std::int64_t high) {
      return low + static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(high - low + 1));
    };
    const Point p{within(low_x, high_x), within(low_y, high_y)};
    if (isOnBoundary(polygon, p)) continue;
    int inside = 0;
    bool is_clear = true;
    for (const Polygon& triangle : triangles) {
      if (doubledArea(triangle) == 0) continue;
      is_clear &= !isOnBoundary(triangle, p);
      inside += isInside(triangle, p) ? 1 : 0;
    }
    if (is_clear) {
      ASSERT_EQ(inside, isInside(polygon, p) ? 1 : 0) << p.x << " " << p.y;
    }
  }
}

std::multiset<std::vector<std::pair<std::int64_t, std::int64_t>>> asSet(
    const Triangles& triangles) {
  std::multiset<std::vector<std::pair<std::int64_t, std::int64_t>>> set;
  for (const Polygon& triangle : triangles) {
    std::vector<std::pair<std::int64_t, std::int64_t>> corners;
    for (const Point& p : triangle) corners.emplace_back(p.x, p.y);
    std::sort(corners.begin(), corners.end());
    set.insert(corners);
  }
  return set;
}

bool isConvex(const Polygon& polygon) {
  bool left = false, right = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const std::int64_t turn =
        cross(polygon[i], polygon[(i + 1) % polygon.size()], polygon[(i + 2) % polygon.size()]);
    left |= turn > 0;
    right |= turn < 0;
  }
  return !left || !right;
}

// In every plane, from some corners, and the other way round.
void expectTriangulated(Polygon polygon, int samples = 200) {
  for (int round = 0; round < 2; ++round) {
    for (const Plane& plane : kPlanes) {
      const Triangles first = trianglesOf(polygon, plane, 0);
      expectCovers(first, polygon, samples);
      if (testing::Test::HasFatalFailure()) return;
      for (std::size_t start = 1; start < polygon.size(); start += 1 + polygon.size() / 7) {
        const Triangles other = trianglesOf(polygon, plane, start);
        expectCovers(other, polygon, samples / 4);
        if (!isConvex(polygon)) {
          ASSERT_EQ(asSet(other), asSet(first)) << start;
        }
      }
    }
    expectEdgesMatch(polygon, kPlanes[2]);
    std::reverse(polygon.begin(), polygon.end());
  }
}

bool sidesMeet(const Point& a, const Point& b, const Point& c, const Point& d) {
  const auto sign = [](std::int64_t value) { return (value > 0) - (value < 0); };
  return sign(cross(a, b, c)) * sign(cross(a, b, d)) <= 0 &&
         sign(cross(c, d, a)) * sign(cross(c, d, b)) <= 0 &&
         std::max(std::min(a.x, b.x), std::min(c.x, d.x)) <=
             std::min(std::max(a.x, b.x), std::max(c.x, d.x)) &&
         std::max(std::min(a.y, b.y), std::min(c.y, d.y)) <=
             std::min(std::max(a.y, b.y), std::max(c.y, d.y));
}

// Random corners, whose sides are uncrossed by turning parts of the polygon round (2-opt). Empty if
// that does not end.
Polygon randomSimplePolygon(std::mt19937& random, std::size_t size, std::int64_t extent) {
  Polygon polygon;
  while (polygon.size() < size) {
    const auto coordinate = [&] { return static_cast<std::int64_t>(random() % extent); };
    const Point p{coordinate(), coordinate()};
    if (std::find(polygon.begin(), polygon.end(), p) == polygon.end()) polygon.push_back(p);
  }
  for (int tries = 0; tries < 5000; ++tries) {
    bool is_simple = true;
    for (std::size_t i = 0; i < size && is_simple; ++i) {
      for (std::size_t j = i + 2; j < size && is_simple; ++j) {
        if (i == 0 && j == size - 1) continue;
        if (!sidesMeet(polygon[i], polygon[i + 1], polygon[j], polygon[(j + 1) % size])) continue;
        is_simple = false;
        std::reverse(polygon.begin() + i + 1, polygon.begin() + j + 1);
      }
    }
    if (is_simple) return polygon;
  }
  return {};
}

// Adds corners in the middle of sides, and corners twice.
Polygon withFlatAndEqualCorners(const Polygon& polygon, std::mt19937& random) {
  Polygon more;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    more.push_back({2 * a.x, 2 * a.y});
    if (random() % 4 == 0) more.push_back(more.back());
    if (random() % 3 == 0) more.push_back({a.x + b.x, a.y + b.y});
  }
  return more;
}

const Polygon kL = {{0, 0}, {20, 0}, {20, 10}, {10, 10}, {10, 20}, {0, 20}};

TEST(MeshFilePolygons, ConcavePolygonsOfEveryKind) {
  expectTriangulated(kL);
  expectTriangulated({{0, 0}, {40, 30}, {80, 0}, {40, 100}});  // a dart
  expectTriangulated({{0, 0}, {40, 0}, {40, 40}, {30, 40}, {30, 10}, {10, 10}, {10, 40}, {0, 40}});
  // Needles: the notch is one unit wide, and the polygon 2^17 long.
  expectTriangulated({{0, 0}, {131072, 0}, {131072, 1}, {131071, 2}, {131070, 1}, {0, 1}});
  expectTriangulated({{0, 0}, {131072, 1}, {131072, 3}, {65536, 2}, {131072, 4}, {131072, 6}});
  // Flat corners, at a notch too, and corners twice.
  expectTriangulated({{0, 0},
                      {10, 0},
                      {20, 0},
                      {20, 10},
                      {20, 10},
                      {15, 10},
                      {10, 10},
                      {10, 10},
                      {10, 10},
                      {10, 15},
                      {10, 20},
                      {0, 20},
                      {0, 10},
                      {0, 10}});
  // A line there and back, outwards and inwards.
  expectTriangulated({{0, 0}, {20, 0}, {20, 10}, {30, 10}, {20, 10}, {20, 20}, {0, 20}});
  expectTriangulated({{0, 0}, {20, 0}, {20, 10}, {10, 12}, {20, 10}, {20, 20}, {0, 20}});
}

TEST(MeshFilePolygons, RandomSimplePolygons) {
  std::mt19937 random(1);
  int polygons = 0;
  for (int i = 0; i < 60; ++i) {
    // A small extent makes corners on one line and on each other's lines.
    const std::int64_t extent = i % 3 == 0 ? 8 : (i % 3 == 1 ? 64 : 4000);
    const std::size_t size = 4 + random() % (i % 3 == 0 ? 12 : 26);
    Polygon polygon = randomSimplePolygon(random, size, extent);
    if (polygon.empty() || doubledArea(polygon) == 0) continue;
    ++polygons;
    if (i % 2 == 0) polygon = withFlatAndEqualCorners(polygon, random);
    expectTriangulated(polygon, 60);
    ASSERT_FALSE(testing::Test::HasFailure()) << objOf(polygon, {}, 0);
  }
  EXPECT_GT(polygons, 40);
}

TEST(MeshFilePolygons, HolesByBridges) {
  const Polygon hole = {{30, 30}, {30, 60}, {60, 60}, {60, 30}};  // clockwise
  // The bridge leads from each corner that sees the hole.
  const Polygon square = {{0, 0}, {90, 0}, {90, 90}, {0, 90}};
  for (std::size_t from = 0; from < 4; ++from) {
    for (std::size_t to = 0; to < 4; ++to) {
      Polygon polygon;
      for (std::size_t i = 0; i <= from; ++i) polygon.push_back(square[i]);
      for (std::size_t i = 0; i <= 4; ++i) polygon.push_back(hole[(to + i) % 4]);
      for (std::size_t i = from; i < 4; ++i) polygon.push_back(square[i]);
      // A bridge through the hole is none.
      bool crosses = false;
      for (std::size_t i = 0; i < 4; ++i) {
        const Point &a = hole[i], &b = hole[(i + 1) % 4];
        if (a == hole[to] || b == hole[to]) continue;
        crosses |= sidesMeet(square[from], hole[to], a, b);
      }
      if (!crosses) expectTriangulated(polygon);
      ASSERT_FALSE(testing::Test::HasFailure()) << from << " " << to;
    }
  }
  // Two holes from one corner, and a chain of two.
  expectTriangulated({{0, 0},
                      {90, 0},
                      {90, 90},
                      {0, 90},
                      {0, 0},
                      {10, 40},
                      {10, 50},
                      {20, 50},
                      {20, 40},
                      {10, 40},
                      {0, 0},
                      {40, 10},
                      {40, 20},
                      {50, 20},
                      {50, 10},
                      {40, 10}});
  expectTriangulated({{0, 0},
                      {90, 0},
                      {90, 90},
                      {0, 90},
                      {0, 0},
                      {10, 10},
                      {10, 30},
                      {30, 30},
                      {50, 50},
                      {50, 70},
                      {70, 70},
                      {70, 50},
                      {50, 50},
                      {30, 30},
                      {30, 10},
                      {10, 10}});
  // A hole that touches the outline in a corner of its own, or in the middle of a side.
  expectTriangulated({{0, 0}, {90, 0}, {90, 90}, {45, 90}, {60, 45}, {30, 45}, {45, 90}, {0, 90}});
  // Two squares that share a corner only.
  expectTriangulated({{0, 0}, {10, 0}, {10, 10}, {20, 10}, {20, 20}, {10, 20}, {10, 10}, {0, 10}});
}

// A grid of holes, each bridged to the one before: many coincident corners and sides.
TEST(MeshFilePolygons, ManyHoles) {
  Polygon there, back;
  const std::int64_t kHoles = 12;
  for (std::int64_t i = 0; i < kHoles; ++i) {
    const std::int64_t x = 10 + 20 * i;
    there.insert(there.end(), {{x, 50}, {x + 5, 60}, {x + 10, 50}});
    back.insert(back.begin(), {{x + 10, 50}, {x + 5, 40}, {x, 50}});
  }
  Polygon polygon = {{0, 50}};
  polygon.insert(polygon.end(), there.begin(), there.end());
  polygon.insert(polygon.end(), back.begin(), back.end());
  polygon.insert(polygon.end(), {{0, 50}, {0, 0}, {20 * kHoles, 0}, {20 * kHoles, 100}, {0, 100}});
  expectTriangulated(polygon);
}

std::vector<std::uint32_t> fanOf(std::uint32_t size) {
  std::vector<std::uint32_t> fan;
  for (std::uint32_t i = 2; i < size; ++i) fan.insert(fan.end(), {0, i - 1, i});
  return fan;
}

// Reads the polygon from its first corner on; expects a fan, and so many polygons in notes.
void expectFan(const std::string& obj, std::uint32_t size, int noted) {
  std::vector<std::string> notes;
  const TriangleMesh mesh = readObjText(obj, &notes);
  EXPECT_EQ(std::vector<std::uint32_t>(mesh.triangles), fanOf(size)) << obj;
  ASSERT_EQ(notes.size(), noted == 0 ? 0U : 1U) << obj << (notes.empty() ? "" : notes[0]);
  if (noted > 0) {
    EXPECT_EQ(notes[0].find(std::to_string(noted) + " of "), 0U) << notes[0];
  }
}

TEST(MeshFilePolygons, ConvexPolygonsAreFansFromTheirFirstCorner) {
  const Polygon octagon = {{10, 0},  {20, 0},  {30, 10}, {30, 20},
                           {20, 30}, {10, 30}, {0, 20},  {0, 10}};
  const Polygon flat = {{0, 0}, {5, 0}, {10, 0}, {10, 0}, {10, 10}, {5, 10}, {0, 10}};
  const Polygon line = {{0, 0}, {5, 5}, {9, 9}, {3, 3}};
  for (const Polygon& polygon : {octagon, flat, line, Polygon(5, Point{1, 2})}) {
    for (const Plane& plane : kPlanes) {
      for (std::size_t start = 0; start < polygon.size(); ++start) {
        Polygon rotated = polygon;
        std::rotate(rotated.begin(), rotated.begin() + start, rotated.end());
        expectFan(objOf(rotated, plane, 0), static_cast<std::uint32_t>(polygon.size()), 0);
        std::reverse(rotated.begin(), rotated.end());
        expectFan(objOf(rotated, plane, 0), static_cast<std::uint32_t>(polygon.size()), 0);
      }
    }
  }
}

TEST(MeshFilePolygons, PolygonsThatCrossThemselvesAreFansAndCounted) {
  const std::vector<Polygon> crossing = {
      {{0, 0}, {10, 10}, {10, 0}, {0, 10}},                                      // a bow tie
      {{0, 0}, {10, 10}, {10, 0}, {0, 9}},                                       // with some area
      {{50, 0}, {80, 90}, {0, 35}, {100, 35}, {20, 90}},                         // a pentagram
      {{0, 0}, {10, 0}, {10, 10}, {0, 10}, {0, 0}, {10, 0}, {10, 10}, {0, 10}},  // round twice
      {{0, 0}, {20, 0}, {20, 20}, {0, 20}, {0, 0}, {10, 0}, {10, 10}, {0, 10}},
      {{0, 0}, {20, 0}, {20, 20}, {10, 20}, {10, 0}, {5, 0}, {10, 0}, {30, 10}, {0, 10}},
      // It overlaps itself, and yet turns round but once.
      {{0, 0},
       {90, 0},
       {90, 60},
       {30, 60},
       {30, -30},
       {40, -30},
       {40, 50},
       {80, 50},
       {80, 10},
       {0, 10}}};
  for (const Polygon& polygon : crossing) {
    for (const Plane& plane : kPlanes) {
      expectFan(objOf(polygon, plane, 0), static_cast<std::uint32_t>(polygon.size()), 1);
    }
  }
}

TEST(MeshFilePolygons, PolygonsWithoutAPlaneAreFansAndCounted) {
  const std::string l = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 ";
  const std::string face = "\nf 1 2 3 4 5 6\n";
  expectFan(l + "0.5" + face, 6, 1);
  expectFan("v 0 0 0\nv 1 0 0\nv 1 1 0.2\nv 0 1 0\nf 1 2 3 4\n", 4, 1);  // a bent quadrilateral
  for (const std::string bad : {"nan", "inf", "-inf", "1e39", "1.#QNAN", "-1.#IND", "1.#INF"}) {
    expectFan(l + bad + face, 6, 1);
  }
  std::vector<std::string> notes;
  readObjText(l + "0.5" + face + "f 2 3 4 5 6 1\nf 1 2 3 4\nf 1 2 3\n", &notes);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(notes[0].find("2 of 3 polygons of 4 or more corners are not planar"), 0U) << notes[0];
  EXPECT_NE(notes[0].find("begins with triangle 0)"), std::string::npos) << notes[0];
}

// The corners of a slanted polygon have rounded decimals, so they are in one plane only nearly.
TEST(MeshFilePolygons, RoundedPolygonsAreTriangulatedTheSameFromEveryCorner) {
  for (const char* how : {"%.3f", "%.6g", "%.9g"}) {
    std::string vertices;
    for (const Point& p : kL) {
      const double x = 0.05 * p.x, y = 0.05 * p.y;
      for (const double c : {0.6 * x - 0.48 * y + 100, 0.8 * x + 0.36 * y, 0.8 * y - 3}) {
        char text[40];
        std::snprintf(text, sizeof text, how, c);
        vertices += (c == 0.6 * x - 0.48 * y + 100 ? "v " : " ") + std::string(text);
      }
      vertices += "\n";
    }
    std::set<std::set<std::set<std::uint32_t>>> surfaces;
    for (int start = 0; start < 6; ++start) {
      std::string face = "f";
      for (int i = 0; i < 6; ++i) face += " " + std::to_string((start + i) % 6 + 1);
      std::vector<std::string> notes;
      const TriangleMesh mesh = readObjText(vertices + face + "\n", &notes);
      EXPECT_TRUE(notes.empty());
      std::set<std::set<std::uint32_t>> surface;
      for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
        surface.insert({&mesh.triangles[i], &mesh.triangles[i] + 3});
      }
      surfaces.insert(surface);
      double area = 0;
      for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
        const Vec3d a = toDouble(mesh.vertex(mesh.triangles[i]));
        const Vec3d n = cross(toDouble(mesh.vertex(mesh.triangles[i + 1])) - a,
                              toDouble(mesh.vertex(mesh.triangles[i + 2])) - a);
        area += std::sqrt(dot(n, n)) / 2;
      }
      EXPECT_NEAR(area, 0.75, 3e-3) << how << " " << start;
    }
    EXPECT_EQ(surfaces.size(), 1U) << how;
  }
}

Polygon comb(std::int64_t teeth) {
  Polygon polygon = {{0, -5}, {2 * teeth, -5}};
  for (std::int64_t i = teeth; i > 0; --i)
    polygon.insert(polygon.end(), {{2 * i, 0}, {2 * i - 1, 99}});
  polygon.push_back({0, 0});
  return polygon;
}

// A band that leads outwards, and its sides at the same angles.
Polygon spiral(int corners) {
  Polygon polygon;
  for (int i = 0; i < corners; ++i) {
    const bool is_outer = 2 * i >= corners;
    const int k = is_outer ? corners - 1 - i : i;
    const double angle = M_PI * k / 30, radius = 1000 + 300.0 * k + (is_outer ? 5000 : 0);
    polygon.push_back(
        {std::llround(radius * std::cos(angle)), std::llround(radius * std::sin(angle))});
  }
  return polygon;
}

Polygon star(std::size_t points) {
  Polygon polygon;
  for (std::size_t i = 0; i < 2 * points; ++i) {
    const double angle = M_PI * static_cast<double>(i) / static_cast<double>(points);
    const double radius = i % 2 == 0 ? 4e6 : 2e6 + 1e6 * std::sin(5 * angle);
    polygon.push_back(
        {std::llround(radius * std::cos(angle)), std::llround(radius * std::sin(angle))});
  }
  return polygon;
}

// Some have sides whose boxes all overlap. The time is limited by the test's own.
TEST(MeshFilePolygons, PolygonsOfManyCorners) {
  Polygon slanted = comb(1500);
  for (Point& p : slanted) p = {p.x + 40 * p.y, p.y - p.x};
  Polygon circle = star(0);
  for (int i = 0; i < 10000; ++i) {
    const double angle = M_PI * i / 5000;
    const double radius = i % 97 == 0 ? 3e6 : 4e6;
    circle.push_back(
        {std::llround(radius * std::cos(angle)), std::llround(radius * std::sin(angle))});
  }
  for (const Polygon& polygon : {comb(5000), slanted, spiral(6000), star(3000), circle}) {
    for (const std::size_t start : {std::size_t{0}, polygon.size() / 3}) {
      SCOPED_TRACE(polygon.size());
      expectCovers(trianglesOf(polygon, Plane(), start), polygon, 20);
    }
  }
}

// The sides meet each other in nearly all pairs.
TEST(MeshFilePolygons, AFaceOfTheSameCornersAgainAndAgain) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0.5 0.2 0\nf";
  constexpr std::uint32_t kCorners = 3'000;
  std::mt19937 random(3);
  for (std::uint32_t i = 0; i < kCorners; ++i) text += " " + std::to_string(1 + random() % 4);
  std::vector<std::string> notes;
  EXPECT_EQ(readObjText(text + "\n", &notes).triangleCount(), kCorners - 2);
  EXPECT_EQ(notes.size(), 1U);
}

TEST_F(MeshFileTest, EveryFormatTriangulates) {
  const std::string vertices = "0 0 0\n2 0 0\n2 1 0\n1 1 0\n1 2 0\n0 2 0\n";
  std::string obj;
  std::istringstream lines(vertices);
  for (std::string line; std::getline(lines, line);) obj += "v " + line + "\n";
  const TriangleMesh of_obj = read("a.obj", "f 2 3 4 5 6 1\n" + obj);  // the face comes first
  const TriangleMesh of_off = read("a.off", "OFF\n6 1 0\n" + vertices + "6 1 2 3 4 5 0\n");
  const TriangleMesh of_ply =
      read("a.ply",
           "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\n"
           "element vertex 6\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
           "6 1 2 3 4 5 0\n" +
               vertices);
  EXPECT_EQ(of_obj.triangles, of_off.triangles);
  EXPECT_EQ(of_obj.triangles, of_ply.triangles);
  // Another state of the same face has other triangles, but the same fan.
  MeshFileReport concave, convex;
  readMeshFile(path("a.obj"), &concave);
  const std::string flat = obj.substr(0, obj.find("v 1 1 0")) + "v 1.6 1.6 0\nv 1 2 0\nv 0 2 0\n";
  EXPECT_NE(readMeshFile(write("b.obj", "f 2 3 4 5 6 1\n" + flat), &convex).triangles,
            of_obj.triangles);
  EXPECT_EQ(concave.fans, convex.fans);
  EXPECT_NE(std::vector<std::uint32_t>(of_obj.triangles), fanOf(6));
}

TEST_F(MeshFileTest, FieldPolygonsAreOneSurface) {
  DCM_REQUIRE_TEST_DATA();
  std::set<std::set<std::set<std::uint32_t>>> surfaces;
  for (const char* name : {"L_from_corner.obj", "L_from_next.obj", "L_from_tip.obj"}) {
    const TriangleMesh mesh = readMeshFile(testDataFile(std::string("field/meshes/") + name));
    std::set<std::set<std::uint32_t>> surface;
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
      surface.insert({&mesh.triangles[i], &mesh.triangles[i] + 3});
    }
    surfaces.insert(surface);
  }
  EXPECT_EQ(surfaces.size(), 1U);
}

}  // namespace
}  // namespace deformable_contact_monitor
