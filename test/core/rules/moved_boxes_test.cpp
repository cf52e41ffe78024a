// Bounds from boxes in the bodies' own frames, against the posed float32 vertices in them.
#include "core/rules/moved_boxes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <random>
#include <vector>

#include "core/rules/posed_vertex.h"

namespace deformable_contact_monitor {
namespace {

class Random {
 public:
  explicit Random(std::uint32_t seed) : random_(seed) {}
  double either() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
  bool oneIn(std::uint32_t n) { return random_() % n == 0; }

  RigidTransform pose(double reach_m) {
    const double a = 4 * either(), b = 4 * either();
    RigidTransform pose{
        {std::cos(a), -std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::sin(a),
         std::cos(a) * std::cos(b), -std::cos(a) * std::sin(b), 0, std::sin(b), std::cos(b)},
        {reach_m * either(), reach_m * either(), reach_m * either()}};
    if (oneIn(8)) pose = RigidTransform();
    if (oneIn(4)) {
      for (double& r : pose.rotation) r += std::pow(10.0, 8 * either() - 8) * either();
    }
    if (oneIn(8)) {
      const double scale = std::pow(10.0, oneIn(2) ? 40 * either() : either());
      for (double& r : pose.rotation) r *= scale;
    }
    if (oneIn(30)) pose.rotation[0] = 1e308;
    return pose;
  }

  // Points in a box of any place and size, from 1e-40 to 1e35 m.
  std::vector<Vec3f> points(double scale) {
    const double x = scale * either(), y = scale * either(), z = scale * either();
    double size[3];
    for (double& s : size) s = scale * std::pow(10.0, 3 * either() - 3);
    std::vector<Vec3f> points(oneIn(4) ? 1 : 20);
    for (Vec3f& p : points) {
      p = {static_cast<float>(x + size[0] * either()), static_cast<float>(y + size[1] * either()),
           static_cast<float>(z + size[2] * either())};
    }
    return points;
  }

 private:
  std::mt19937 random_;
};

CentredBox boxOf(const std::vector<Vec3f>& points) {
  Aabb box;
  for (const Vec3f& p : points) box.include(p);
  return CentredBox::of(box);
}

// Returns the points in the scene frame without those that are not finite.
std::vector<Vec3d> posed(const std::vector<Vec3f>& points, const RigidTransform& pose) {
  std::vector<Vec3d> all;
  for (const Vec3f& p : points) {
    const Vec3f v = posedVertex(pose, pose.isIdentity(), p);
    if (isFinite(v)) all.push_back(toDouble(v));
  }
  return all;
}

// Returns how many boxes were certainly apart.
std::size_t expectLowerBounds(std::uint32_t seed) {
  Random random(seed);
  const double scale = random.oneIn(2) ? 1 : std::pow(10.0, 38 * random.either() - 3);
  const std::vector<Vec3f> a = random.points(scale), b = random.points(scale);
  const RigidTransform pose_a = random.pose(scale), pose_b = random.pose(scale);
  const CentredBox box_a = boxOf(a), box_b = boxOf(b);
  // The boxes that are compared are parts of larger ones.
  std::vector<Vec3f> all_a = random.points(scale), all_b = random.points(scale);
  all_a.insert(all_a.end(), a.begin(), a.end());
  all_b.insert(all_b.end(), b.begin(), b.end());
  const auto pair = FramePair::of(pose_a, boxOf(all_a), pose_b, boxOf(all_b));
  const double low2 = pair.squaredGap(box_a, box_b, INFINITY);
  EXPECT_GE(low2, 0);
  double least2 = INFINITY;
  for (const Vec3d& p : posed(a, pose_a)) {
    for (const Vec3d& q : posed(b, pose_b)) least2 = std::min(least2, dot(p - q, p - q));
  }
  EXPECT_LE(low2, least2 * (1 + 1e-14)) << "seed " << seed;
  return low2 > 0 ? 1 : 0;
}

TEST(MovedBoxes, BoundDistancesOfPosedVertices) {
  std::size_t apart = 0;
  for (std::uint32_t seed = 0; seed < 60000 && !::testing::Test::HasFailure(); ++seed) {
    apart += expectLowerBounds(seed);
  }
  EXPECT_GT(apart, 25000U);
}

// A bound that is far too small would be right too.
TEST(MovedBoxes, AreTightForRotations) {
  const CentredBox box{{0.1F, 0.2F, -0.3F}, {0.05F, 0.02F, 0.04F}};
  RigidTransform pose_a, pose_b;
  pose_b.translation[1] = 1;
  for (int i = 0; i < 3; ++i) {
    const auto pair = FramePair::of(pose_a, box, pose_b, box);
    EXPECT_NEAR(1 - 2 * 0.02, std::sqrt(pair.squaredGap(box, box, INFINITY)), 1e-4);
    // The same about another axis: both bodies turn together.
    const double a = 0.7 * (i + 1);
    pose_a = {{std::cos(a), -std::sin(a), 0, std::sin(a), std::cos(a), 0, 0, 0, 1}, {0, 0, 0}};
    pose_b = pose_a;
    pose_b.translation[0] = -std::sin(a);
    pose_b.translation[1] = std::cos(a);
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
