// Decimated surfaces: how many triangles, no holes, and no other ones while the surface moves.
#include "monitor/markers/decimated_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace deformable_contact_monitor {
namespace {

using Indices = std::vector<std::uint32_t>;
using Edge = std::pair<std::uint32_t, std::uint32_t>;

// A sheet of 2 n^2 triangles over the unit square; `height` of each point.
template <class Height>
TriangleMesh makeSheet(std::uint32_t n, const Height& height) {
  TriangleMesh mesh;
  for (std::uint32_t y = 0; y <= n; ++y) {
    for (std::uint32_t x = 0; x <= n; ++x) {
      const float u = static_cast<float>(x) / n, v = static_cast<float>(y) / n;
      for (const float c : {u, v, height(u, v)}) mesh.vertices.push_back(c);
    }
  }
  for (std::uint32_t y = 0; y < n; ++y) {
    for (std::uint32_t x = 0; x < n; ++x) {
      const std::uint32_t a = y * (n + 1) + x, b = a + n + 1;
      for (const std::uint32_t i : {a, a + 1, b, a + 1, b + 1, b}) mesh.triangles.push_back(i);
    }
  }
  return mesh;
}

TriangleMesh makeFlatSheet(std::uint32_t n) {
  return makeSheet(n, [](float, float) { return 0.0F; });
}

// A closed surface of 2 n^2 triangles: a ring, with an uneven tube.
TriangleMesh makeRing(std::uint32_t n) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t k = 0; k < n; ++k) {
      const double a = 2 * M_PI * i / n, b = 2 * M_PI * k / n;
      const double tube = 0.3 + 0.1 * std::sin(5 * a) * std::cos(3 * b);
      const double r = 1 + tube * std::cos(b);
      for (const double c : {r * std::cos(a), r * std::sin(a), tube * std::sin(b)}) {
        mesh.vertices.push_back(static_cast<float>(c));
      }
    }
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t k = 0; k < n; ++k) {
      const std::uint32_t j = (i + 1) % n, l = (k + 1) % n;
      for (const std::uint32_t v :
           {i * n + k, j * n + k, i * n + l, j * n + k, j * n + l, i * n + l})
        mesh.triangles.push_back(v);
    }
  }
  return mesh;
}

// The same triangles, each with vertices of its own.
TriangleMesh asSoup(const TriangleMesh& mesh) {
  TriangleMesh soup;
  for (const std::uint32_t i : mesh.triangles) {
    soup.triangles.push_back(static_cast<std::uint32_t>(soup.triangles.size()));
    for (std::size_t k = 0; k < 3; ++k) soup.vertices.push_back(mesh.vertices[3 * i + k]);
  }
  return soup;
}

// Edges that have an odd number of triangles.
std::set<Edge> openEdges(const Indices& triangles) {
  std::map<Edge, int> count;
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    for (std::size_t k = 0; k < 3; ++k) {
      ++count[std::minmax(triangles[i + k], triangles[i + (k + 1) % 3])];
    }
  }
  std::set<Edge> open;
  for (const auto& [edge, n] : count) {
    if (n % 2 == 1) open.insert(edge);
  }
  return open;
}

double areaOf(const TriangleMesh& mesh, const Indices& triangles) {
  double sum = 0;
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    const Vec3f a = mesh.vertex(triangles[i]), b = mesh.vertex(triangles[i + 1]),
                c = mesh.vertex(triangles[i + 2]);
    const double ux = b.x - a.x, uy = b.y - a.y, uz = b.z - a.z;
    const double vx = c.x - a.x, vy = c.y - a.y, vz = c.z - a.z;
    sum += std::hypot(uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx) / 2;
  }
  return sum;
}

TEST(DecimatedSurfaceTest, ASurfaceWithinTheLimitIsWhole) {
  const TriangleMesh sheet = makeFlatSheet(10);
  EXPECT_EQ(DecimatedSurface(200).triangles(sheet), sheet.triangles);
  EXPECT_LT(DecimatedSurface(199).triangles(sheet).size(), 3 * 200U);
}

TEST(DecimatedSurfaceTest, TheLimitHoldsAndIsMadeUseOf) {
  const TriangleMesh sheet = makeFlatSheet(100), ring = makeRing(100);
  for (const TriangleMesh& mesh : {sheet, ring, asSoup(ring)}) {
    for (const std::size_t limit : {19999, 5000, 1000, 300, 100}) {
      const std::size_t remaining = DecimatedSurface(limit).triangles(mesh).size() / 3;
      EXPECT_LE(remaining, limit);
      EXPECT_GE(3 * remaining, limit);
    }
  }
  for (const std::size_t limit : {20, 5, 1}) {
    EXPECT_LE(DecimatedSurface(limit).triangles(ring).size() / 3, limit);
  }
}

TEST(DecimatedSurfaceTest, AClosedSurfaceStaysClosed) {
  const TriangleMesh ring = makeRing(100);
  ASSERT_TRUE(openEdges(ring.triangles).empty());
  for (const std::size_t limit : {15000, 5000, 1000, 300, 100, 30}) {
    EXPECT_TRUE(openEdges(DecimatedSurface(limit).triangles(ring)).empty()) << limit;
  }
}

// Whatever it is crumpled to.
TEST(DecimatedSurfaceTest, ACrumpledOneDoes) {
  std::mt19937 random(1);
  for (int round = 0; round < 20; ++round) {
    TriangleMesh ring = makeRing(40);
    std::normal_distribution<float> shift(0, 0.01F * static_cast<float>(1 + round));
    for (float& c : ring.vertices) c += shift(random);
    for (const std::size_t limit : {2000, 500, 100}) {
      EXPECT_TRUE(openEdges(DecimatedSurface(limit).triangles(ring)).empty()) << limit;
    }
  }
}

TEST(DecimatedSurfaceTest, ASoupHangsTogetherLikeAWeldedMesh) {
  const TriangleMesh ring = makeRing(60), soup = asSoup(ring);
  const auto corners = [](const TriangleMesh& mesh, const Indices& triangles) {
    std::set<std::array<float, 3>> points;
    for (const std::uint32_t i : triangles) {
      points.insert({mesh.vertex(i).x, mesh.vertex(i).y, mesh.vertex(i).z});
    }
    return points;
  };
  const Indices welded = DecimatedSurface(1000).triangles(ring);
  const Indices of_soup = DecimatedSurface(1000).triangles(soup);
  EXPECT_EQ(of_soup.size(), welded.size());
  EXPECT_EQ(corners(soup, of_soup), corners(ring, welded));
  EXPECT_TRUE(openEdges(of_soup).empty());
}

// An open surface stays open only at its rim, and covers the same area.
TEST(DecimatedSurfaceTest, ASheetHasNoHoles) {
  const TriangleMesh sheet = makeFlatSheet(100);
  for (const std::size_t limit : {10000, 3000, 1000, 300}) {
    const Indices triangles = DecimatedSurface(limit).triangles(sheet);
    const float cell = 2 / std::sqrt(static_cast<float>(limit) / 2 / 3);
    for (const Edge& edge : openEdges(triangles)) {
      for (const std::uint32_t i : {edge.first, edge.second}) {
        const Vec3f v = sheet.vertex(i);
        EXPECT_LT(std::min({v.x, 1 - v.x, v.y, 1 - v.y}), cell) << v.x << " " << v.y;
      }
    }
    const double area = areaOf(sheet, triangles);
    EXPECT_GT(area, (1 - 2 * cell) * (1 - 2 * cell));
    EXPECT_LT(area, 1 + 2 * cell);
  }
}

TEST(DecimatedSurfaceTest, TheSameTrianglesRemainWhileItMoves) {
  DecimatedSurface surface(1000);
  const Indices at_first = surface.triangles(makeFlatSheet(100));
  for (int i = 1; i < 5; ++i) {
    const TriangleMesh moved =
        makeSheet(100, [i](float u, float v) { return 0.1F * std::sin(9 * u + 7 * v + 1.0F * i); });
    EXPECT_EQ(surface.triangles(moved), at_first);
  }
  const TriangleMesh ring = makeRing(90);
  const Indices other = surface.triangles(ring);
  EXPECT_NE(other, at_first) << "another topology";
  EXPECT_TRUE(openEdges(other).empty());
}

// Two layers that are close at first go apart: no triangle may reach from one to the other.
TEST(DecimatedSurfaceTest, LayersStayApart) {
  TriangleMesh folded = makeSheet(100, [](float, float) { return 0.0F; });
  const auto fold = [&folded](float gap) {  // along x = 0.5
    for (std::size_t i = 0; i < folded.vertexCount(); ++i) {
      float &x = folded.vertices[3 * i], &z = folded.vertices[3 * i + 2];
      if (x > 0.5F) {
        x = 1 - x;
        z = gap;
      }
    }
  };
  const TriangleMesh flat = folded;
  fold(0.0001F);
  DecimatedSurface surface(1000);
  const Indices triangles = surface.triangles(folded);
  const auto longestOf = [&triangles](const TriangleMesh& mesh) {
    float longest = 0;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      const Vec3f a = mesh.vertex(triangles[i]);
      const Vec3f b = mesh.vertex(triangles[i - i % 3 + (i + 1) % 3]);
      longest = std::max(longest, std::hypot(a.x - b.x, a.y - b.y, a.z - b.z));
    }
    return longest;
  };
  ASSERT_FALSE(triangles.empty());
  EXPECT_LT(longestOf(flat), 3 * longestOf(folded)) << "when it is unfolded";
  float farthest = 0;
  for (const std::uint32_t i : triangles) farthest = std::max(farthest, flat.vertex(i).x);
  EXPECT_GT(farthest, 0.8) << "both layers are there";
}

TEST(DecimatedSurfaceTest, VerticesThatAreNotFiniteSpoilTheFirstPictureAlone) {
  const TriangleMesh clean = makeFlatSheet(50);
  TriangleMesh spoiled = clean;
  for (std::size_t i = 0; i < spoiled.vertices.size(); i += 30) {
    spoiled.vertices[i] = std::numeric_limits<float>::quiet_NaN();
  }
  spoiled.vertices[1] = std::numeric_limits<float>::infinity();
  DecimatedSurface surface(500);
  const Indices at_first = surface.triangles(spoiled);
  EXPECT_LE(at_first.size(), 3 * 500U);
  EXPECT_EQ(surface.triangles(clean), DecimatedSurface(500).triangles(clean));
}

TEST(DecimatedSurfaceTest, ExtremesEnd) {
  TriangleMesh point = makeFlatSheet(20);
  std::fill(point.vertices.begin(), point.vertices.end(), 7.0F);
  EXPECT_TRUE(DecimatedSurface(10).triangles(point).empty());
  TriangleMesh huge = makeFlatSheet(20);
  for (float& c : huge.vertices) c = (c - 0.5F) * std::numeric_limits<float>::max();
  EXPECT_LE(DecimatedSurface(100).triangles(huge).size(), 300U);
  EXPECT_FALSE(DecimatedSurface(100).triangles(huge).empty());
  TriangleMesh outlier = makeFlatSheet(20);
  outlier.vertices[0] = 1e30F;
  EXPECT_LE(DecimatedSurface(100).triangles(outlier).size(), 300U);
  TriangleMesh nothing = makeFlatSheet(20);
  std::fill(nothing.vertices.begin(), nothing.vertices.end(),
            std::numeric_limits<float>::quiet_NaN());
  EXPECT_LE(DecimatedSurface(10).triangles(nothing).size(), 30U);
}

}  // namespace
}  // namespace deformable_contact_monitor
