// Tests of the surface of tetrahedra: which faces it has, which side is out, and what is refused.
#include "monitor/rules/tetrahedra.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace deformable_contact_monitor {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

constexpr int kSide = 3, kPoints = kSide + 1;  // cubes and points along an axis

std::uint32_t pointAt(const Eigen::Vector3i& at) {
  return static_cast<std::uint32_t>((at.x() * kPoints + at.y()) * kPoints + at.z());
}

Eigen::Vector3d positionOf(std::uint32_t point) {
  return {double(point / (kPoints * kPoints)), double(point / kPoints % kPoints),
          double(point % kPoints)};
}

double volumeOf(const std::array<std::uint32_t, 4>& c) {
  const Eigen::Vector3d a = positionOf(c[0]);
  return (positionOf(c[1]) - a).cross(positionOf(c[2]) - a).dot(positionOf(c[3]) - a) / 6;
}

// Cuts each cube of a grid into six cells along its diagonal, all of positive volume.
std::vector<Cell> gridCells() {
  std::vector<Cell> cells;
  for (int cube = 0; cube < kSide * kSide * kSide; ++cube) {
    int axes[3] = {0, 1, 2};
    do {
      Eigen::Vector3i at(cube / (kSide * kSide), cube / kSide % kSide, cube % kSide);
      Cell cell{{pointAt(at)}, static_cast<std::uint32_t>(cells.size() + 1)};
      for (int i = 0; i < 3; ++i) {
        at[axes[i]] += 1;
        cell.corners[i + 1] = pointAt(at);
      }
      if (volumeOf(cell.corners) < 0) std::swap(cell.corners[0], cell.corners[1]);
      cells.push_back(cell);
    } while (std::next_permutation(axes, axes + 3));
  }
  return cells;
}

std::vector<Triangle> trianglesOf(const PointTriangles& surface) {
  std::vector<Triangle> all;
  for (std::size_t i = 0; i < surface.triangles.size(); i += 3) {
    all.push_back({surface.triangles[i], surface.triangles[i + 1], surface.triangles[i + 2]});
  }
  return all;
}

template <std::size_t N>
std::array<std::uint32_t, N> sorted(std::array<std::uint32_t, N> corners) {
  std::sort(corners.begin(), corners.end());
  return corners;
}

TEST(Tetrahedra, TheSurfaceIsTheFacesOfExactlyOneCell) {
  std::mt19937 random(1);
  for (int round = 0; round < 50; ++round) {
    std::vector<Cell> cells = gridCells();
    std::shuffle(cells.begin(), cells.end(), random);
    cells.resize(1 + random() % cells.size());
    std::map<Triangle, int> count;
    double volume = 0;
    for (const Cell& cell : cells) {
      volume += volumeOf(cell.corners);
      for (std::size_t left_out = 0; left_out < 4; ++left_out) {
        Triangle face{};
        std::size_t filled = 0;
        for (std::size_t i = 0; i < 4; ++i) {
          if (i != left_out) face[filled++] = cell.corners[i];
        }
        ++count[sorted(face)];
      }
    }
    std::set<Triangle> expected, found;
    for (const auto& [face, cells_of_it] : count) {
      if (cells_of_it == 1) expected.insert(face);
    }
    double enclosed = 0;
    const std::vector<Triangle> triangles = trianglesOf(surfaceOf(cells));
    for (const Triangle& triangle : triangles) {
      found.insert(sorted(triangle));
      enclosed +=
          positionOf(triangle[0]).cross(positionOf(triangle[1])).dot(positionOf(triangle[2])) / 6;
    }
    EXPECT_EQ(found, expected);
    EXPECT_EQ(triangles.size(), expected.size()) << "none is there twice";
    EXPECT_NEAR(enclosed, volume, 1e-9) << "triangles point outwards";
  }
}

TEST(Tetrahedra, TheOrderIsTheCells) {
  const PointTriangles surface = surfaceOf(readCells("0 1 2 3\n4 3 2 1\n"));
  EXPECT_EQ(surface.point_count, 5U);
  EXPECT_EQ(
      trianglesOf(surface),
      (std::vector<Triangle>{{0, 3, 2}, {0, 1, 3}, {0, 2, 1}, {4, 1, 2}, {4, 3, 1}, {4, 2, 3}}));
}

TEST(Tetrahedra, AFileMayHaveCommentsAndAnyGaps) {
  const std::vector<Cell> cells =
      readCells("# my cells\r\n\n 0 1\t2  3 \r\n\t# more\n4,5, 6,7\n2147483646 1 2 3");
  ASSERT_EQ(cells.size(), 3U);
  EXPECT_EQ(cells[0].corners, (std::array<std::uint32_t, 4>{0, 1, 2, 3}));
  EXPECT_EQ(cells[1].corners, (std::array<std::uint32_t, 4>{4, 5, 6, 7}));
  EXPECT_EQ(cells[1].line, 5U);
  EXPECT_EQ(surfaceOf(cells).point_count, 2147483647U) << "which takes no memory";
}

std::string refusalOfCells(const std::string& text) {
  try {
    surfaceOf(readCells(text));
    return "";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

TEST(Tetrahedra, WhatIsNoMeshIsRefusedByItsLine) {
  const std::string kFour = "', must be the four point indices of a cell";
  EXPECT_EQ(refusalOfCells(""), "there is no cell");
  EXPECT_EQ(refusalOfCells("# nothing\n\n"), "there is no cell");
  for (const std::string& bad :
       {std::string("1 2 3"), std::string("1 2 3 4 5"), std::string("1 2 3 -4"),
        std::string("1 2 3 4.0"), std::string("1 2 3 x"), std::string("1 2 3 4x"),
        std::string("1 2 3 2147483647"), std::string("1 2 3 99999999999999999999"),
        std::string("nan 1 2 3"), std::string("1 2,,3"), std::string("+1 2 3 4")}) {
    EXPECT_EQ(refusalOfCells("0 1 2 3\n" + bad + "\n"), "line 2 is '" + bad + kFour);
  }
  EXPECT_EQ(refusalOfCells("1 2 3 " + std::string(100000, '4')).size(), 11 + 40 + kFour.size());
  EXPECT_EQ(refusalOfCells("0 1 2 3\n5 6 5 7\n"), "line 2 has point 5 twice, so the cell is empty");
  EXPECT_EQ(refusalOfCells("0 1 2 3\n\n3 1 0 2\n"), "line 1 and line 3 are the same cell");
  EXPECT_EQ(refusalOfCells("0 1 2 3\n0 1 2 4\n5 2 1 0\n"),
            "line 1, line 2, line 3: the face 0 1 2 belongs to 3 cells, must be at most two");
  EXPECT_EQ(refusalOfCells("0 1 2 3\n0 1 2 4\n0 1 3 4\n0 2 3 4\n1 2 3 4\n"),
            "the cells have no surface");
}

TEST(Tetrahedra, AnyBytesDoNoHarm) {
  std::mt19937 random(2);
  const std::string letters = "0123456789 \n\r\t,#-.x";
  int taken = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string text = i % 2 == 0 ? "0 1 2 3\n1 2 3 4\n9 8 7 6\n" : "";
    for (std::size_t left = random() % 20; left > 0; --left) {
      text.insert(text.begin() + static_cast<long>(random() % (text.size() + 1)),
                  letters[random() % letters.size()]);
    }
    taken += refusalOfCells(text).empty();
  }
  EXPECT_GT(taken, 500);
}

}  // namespace
}  // namespace deformable_contact_monitor
