// Polygons with integer corners, their OBJ files, and an exact oracle of their triangles.
#include "polygon_oracle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <sstream>
#include <utility>

#include "core/mesh_file.h"
#include "core/mesh_files/mesh_readers.h"

namespace deformable_contact_monitor {
namespace {

std::int64_t cross(const Point& a, const Point& b, const Point& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
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

}  // namespace

bool operator==(const Point& a, const Point& b) { return a.x == b.x && a.y == b.y; }

std::int64_t doubledArea(const Polygon& polygon) {
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    sum += a.x * b.y - a.y * b.x;
  }
  return sum;
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

const std::vector<Plane> kPlanes = {{},
                                    {{0, 0, 1}, {1, 0, 0}, {0, 7, 0}, 0.25},
                                    {{1, -1, 0}, {1, 0, -1}, {9, 9, 9}, 1.0 / 1024},
                                    {{3, 5, -2}, {-1, 4, 7}, {-1000, 3, 77}, 0x1p-40},
                                    {{0, 2, 1}, {1, 0, 3}, {1, 2, 3}, 0x1p60}};

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

void expectTriangulated(Polygon polygon, int samples) {
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

std::vector<std::uint32_t> fanOf(std::uint32_t size) {
  std::vector<std::uint32_t> fan;
  for (std::uint32_t i = 2; i < size; ++i) fan.insert(fan.end(), {0, i - 1, i});
  return fan;
}

}  // namespace deformable_contact_monitor
