// Tests which polygons the readers fan from their first corner, and which of them they note.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "polygon_oracle.h"

namespace deformable_contact_monitor {
namespace {

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

}  // namespace
}  // namespace deformable_contact_monitor
