// Tests of the simulated cloth.
#include "tools/common/cloth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

namespace deformable_contact_monitor {
namespace {

constexpr double kFrame = 1 / 30.;  // [s]

ClothOptions options() {
  ClothOptions o;
  o.triangles = 800;  // 20 cells along each edge
  o.edge_m = 1;
  o.held_at = {0.5, 0, 1};
  return o;
}

// Along y, below the middle of the sheet; moves up and down.
Capsule bar(double time_s) {
  const double z = 0.8 + 0.1 * std::sin(2 * time_s);
  return {{0, -0.3, z}, {0, 0.3, z}, 0.1};
}

std::vector<Eigen::Vector3d> vertices(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
    points.emplace_back(mesh.vertices[i], mesh.vertices[i + 1], mesh.vertices[i + 2]);
  }
  return points;
}

double distanceToAxis(const Capsule& c, const Eigen::Vector3d& p) {
  const Eigen::Vector3d axis = c.b - c.a;
  const double t = std::clamp((p - c.a).dot(axis) / axis.squaredNorm(), 0.0, 1.0);
  return (p - c.a - t * axis).norm();
}

TEST(ClothTest, isASquareSheetOfAboutTheTrianglesAskedFor) {
  const TriangleMesh mesh = Cloth(options()).mesh();
  EXPECT_EQ(mesh.triangleCount(), 800U);
  EXPECT_EQ(mesh.vertexCount(), 21U * 21U);
  EXPECT_NO_THROW(validate(mesh, "cloth"));
  // Each directed edge once: the sheet is one oriented surface.
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_TRUE(edges.insert({mesh.triangles[t + i], mesh.triangles[t + (i + 1) % 3]}).second);
    }
  }
  ClothOptions odd = options();
  odd.triangles = 5000;
  EXPECT_NEAR(static_cast<double>(Cloth(odd).mesh().triangleCount()), 5000, 100);
}

TEST(ClothTest, theSeedDecidesEverything) {
  Cloth one(options()), same(options());
  ClothOptions differently = options();
  differently.seed = 2;
  Cloth other(differently);
  for (int frame = 0; frame < 60; ++frame) {
    for (Cloth* cloth : {&one, &same, &other}) cloth->step(kFrame, {bar(frame * kFrame)});
  }
  EXPECT_EQ(one.mesh().vertices, same.mesh().vertices);
  EXPECT_NE(one.mesh().vertices, other.mesh().vertices);
}

TEST(ClothTest, fallsButHangsOnByItsEdge) {
  ClothOptions fine = options();
  fine.triangles = 7200;  // 60 cells
  Cloth cloth(fine);
  const auto start = vertices(cloth.mesh());
  for (int frame = 0; frame < 200; ++frame) {
    cloth.step(kFrame, {});
    const auto now = vertices(cloth.mesh());
    for (std::size_t i = 0; i < now.size(); ++i) {
      ASSERT_TRUE(now[i].allFinite());
      const double cloth_between_m = static_cast<double>(i / 61) / 60;
      ASSERT_LE((now[i] - start[i % 61]).norm(), 1.03 * cloth_between_m + 1e-6) << frame;
    }
  }
  const auto end = vertices(cloth.mesh());
  for (std::size_t i = 0; i <= 60; ++i) EXPECT_EQ(end[i], start[i]);
  for (const Eigen::Vector3d& p : end) EXPECT_NEAR(p.x(), 0.5, 0.3);  // at rest, below the edge
  EXPECT_LT(end.back().z(), 0.1);
}

TEST(ClothTest, staysOutsideAnObstacleThatMoves) {
  Cloth cloth(options());
  int over_the_bar = 0;
  for (int frame = 0; frame < 300; ++frame) {
    const Capsule obstacle = bar(frame * kFrame);
    cloth.step(kFrame, {obstacle});
    const auto points = vertices(cloth.mesh());
    for (const Eigen::Vector3d& p : points) {
      ASSERT_TRUE(p.allFinite());
      ASSERT_GE(distanceToAxis(obstacle, p), obstacle.radius_m - 1e-5) << "frame " << frame;
    }
    // Never through it: of the part between hold and bar, what is over the bar lies on top.
    for (std::size_t i = 0; i < 11 * 21; ++i) {
      if (std::abs(points[i].x()) > 0.05 || std::abs(points[i].y()) > 0.2) continue;
      ASSERT_GT(points[i].z(), obstacle.a.z()) << "frame " << frame;
      ++over_the_bar;
    }
  }
  EXPECT_GT(over_the_bar, 300);
}

TEST(ClothTest, refusesSizesThatMakeNoSheet) {
  for (const double edge : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(),
                            std::numeric_limits<double>::infinity()}) {
    ClothOptions o = options();
    o.edge_m = edge;
    EXPECT_THROW(Cloth{o}, std::invalid_argument) << edge;
  }
  ClothOptions o = options();
  o.triangles = 0;
  EXPECT_THROW(Cloth{o}, std::invalid_argument);
}

}  // namespace
}  // namespace deformable_contact_monitor
