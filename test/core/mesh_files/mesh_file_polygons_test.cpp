// Tests that the triangles of a polygon are the polygon.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <set>
#include <sstream>

#include "core/mesh_files/mesh_readers.h"
#include "mesh_file_fixture.h"
#include "polygon_oracle.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

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