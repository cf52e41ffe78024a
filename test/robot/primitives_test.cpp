// Primitives against their analytic surface, area and volume.
#include "robot/primitives.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "robot_test_support.h"

namespace deformable_contact_monitor {
namespace {

constexpr double kPi = 3.14159265358979323846;

// As a link has it: rounded to float32.
TriangleMesh rounded(const SourceMesh& mesh) {
  LinkMeshBuilder builder;
  builder.append(mesh, Eigen::Affine3d::Identity());
  return builder.mesh();
}

TEST(Primitives, BoxIsExact) {
  const SourceMesh box = makeBox({0.2, 0.5, 3});
  EXPECT_EQ(box.vertices.size(), 8U);
  EXPECT_EQ(box.triangles.size(), 12U);
  EXPECT_TRUE(isClosed(rounded(box)));
  EXPECT_NEAR(signedVolume(cornersOf(box)), 0.2 * 0.5 * 3, 1e-12);
  EXPECT_NEAR(surfaceArea(cornersOf(box)), 2 * (0.2 * 0.5 + 0.5 * 3 + 3 * 0.2), 1e-12);
  const Bounds bounds = boundsOf(rounded(box));
  EXPECT_TRUE(bounds.low.isApprox(Eigen::Vector3d(-0.1, -0.25, -1.5), 1e-7));
  EXPECT_TRUE(bounds.high.isApprox(Eigen::Vector3d(0.1, 0.25, 1.5), 1e-7));
}

TEST(Primitives, CylinderIsClosedAndNearTheTrueOne) {
  const double radius = 0.3, length = 2;
  const SourceMesh cylinder = makeCylinder(radius, length);
  EXPECT_EQ(cylinder.triangles.size(), 256U);
  EXPECT_TRUE(isClosed(rounded(cylinder)));
  for (const Eigen::Vector3d& v : cylinder.vertices) {
    EXPECT_NEAR(std::abs(v.z()), length / 2, 1e-15);
    const double r = v.head<2>().norm();
    if (r > 1e-12) {
      EXPECT_NEAR(r, radius, 1e-15);
    }
  }
  const auto triangles = cornersOf(cylinder);
  const double volume = kPi * radius * radius * length;
  const double area = 2 * kPi * radius * (radius + length);
  EXPECT_LT(signedVolume(triangles), volume);
  EXPECT_NEAR(signedVolume(triangles), volume, 2e-3 * volume);
  EXPECT_LT(surfaceArea(triangles), area);
  EXPECT_NEAR(surfaceArea(triangles), area, 2e-3 * area);
  for (const Corners& t : triangles) {  // the sides' distance from the axis
    if (std::abs((t[0].z() + t[1].z() + t[2].z()) / 3) > 0.45 * length) continue;
    for (int k = 0; k < 3; ++k) {
      EXPECT_GE(((t[k] + t[(k + 1) % 3]) / 2).head<2>().norm(), radius * (1 - 0.0013));
    }
  }
}

TEST(Primitives, SphereIsClosedAndNearTheTrueOne) {
  const double radius = 0.05;
  const SourceMesh sphere = makeSphere(radius);
  EXPECT_EQ(sphere.vertices.size(), 642U);
  EXPECT_EQ(sphere.triangles.size(), 1280U);
  EXPECT_TRUE(isClosed(rounded(sphere)));
  for (const Eigen::Vector3d& v : sphere.vertices) EXPECT_NEAR(v.norm(), radius, 1e-15);
  const auto triangles = cornersOf(sphere);
  const double volume = 4.0 / 3 * kPi * radius * radius * radius, area = 4 * kPi * radius * radius;
  EXPECT_LT(signedVolume(triangles), volume);
  EXPECT_NEAR(signedVolume(triangles), volume, 1e-2 * volume);
  EXPECT_NEAR(surfaceArea(triangles), area, 5e-3 * area);
  for (const Corners& t : triangles) {
    const Eigen::Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
    EXPECT_GE(normal.dot(t[0]), radius * (1 - 0.005));
  }
}

TEST(Primitives, RefuseSizesThatAreNoSizes) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {0.0, -0.0, -1.0, nan, infinity, -infinity}) {
    EXPECT_THROW(makeBox({bad, 1, 1}), std::invalid_argument) << bad;
    EXPECT_THROW(makeBox({1, bad, 1}), std::invalid_argument) << bad;
    EXPECT_THROW(makeBox({1, 1, bad}), std::invalid_argument) << bad;
    EXPECT_THROW(makeCylinder(bad, 1), std::invalid_argument) << bad;
    EXPECT_THROW(makeCylinder(1, bad), std::invalid_argument) << bad;
    EXPECT_THROW(makeSphere(bad), std::invalid_argument) << bad;
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
