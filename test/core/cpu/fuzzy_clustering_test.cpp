// Fuzzy c-means does what its name says.
#include "core/cpu/fuzzy_clustering.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "core/mesh_file.h"
#include "core/rules/half_space.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

std::vector<Vec3f> blobs(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(0, 0.1F);
  std::vector<Vec3f> points(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto blob = static_cast<float>(i % 4);
    points[i] = {blob - 1.5F + noise(random), noise(random), blob * 0.2F + noise(random)};
  }
  return points;
}

// Every n-th triangle's centroid, brought near [-1, 1].
std::vector<Vec3f> centroidsOf(const TriangleMesh& mesh, std::size_t step) {
  std::vector<Vec3f> centroids;
  for (std::size_t t = 0; t < mesh.triangleCount(); t += step) {
    Vec3f sum;
    for (int k = 0; k < 3; ++k) {
      const float* v = &mesh.vertices[3 * std::size_t{mesh.triangles[3 * t + k]}];
      sum = sum + Vec3f{v[0], v[1], v[2]};
    }
    centroids.push_back(sum * (1.0F / 3));
  }
  return centroids;
}

class Fuzzifier : public testing::TestWithParam<float> {};

TEST_P(Fuzzifier, MembershipsSumToOneEverywhere) {
  FuzzyClustering clustering(GetParam());
  clustering.initialise(blobs(500, 1), 7);
  std::vector<Vec3f> probes = blobs(200, 2);
  probes.push_back({1e6F, -1e6F, 0});
  probes.push_back({1e-30F, 0, 0});
  for (const Vec3f& prototype : clustering.prototypes()) probes.push_back(prototype);
  for (const Vec3f& probe : probes) {
    const std::vector<float> u = clustering.memberships(probe);
    ASSERT_EQ(u.size(), 7U);
    for (const float x : u) {
      ASSERT_GE(x, 0);
      ASSERT_LE(x, 1);
    }
    EXPECT_NEAR(std::accumulate(u.begin(), u.end(), 0.0), 1, 1e-5);
  }
}

TEST_P(Fuzzifier, NearerPrototypesGetMore) {
  FuzzyClustering clustering(GetParam());
  clustering.initialise(blobs(500, 3), 9);
  for (const Vec3f& probe : blobs(100, 4)) {
    const std::vector<float> u = clustering.memberships(probe);
    for (std::size_t a = 0; a < u.size(); ++a) {
      for (std::size_t b = 0; b < u.size(); ++b) {
        const float to_a = squaredDistance(probe, clustering.prototypes()[a]);
        const float to_b = squaredDistance(probe, clustering.prototypes()[b]);
        if (to_a < to_b) {
          EXPECT_GE(u[a], u[b]);
        }
      }
    }
  }
}

TEST_P(Fuzzifier, ObjectiveDoesNotRise) {
  const std::vector<Vec3f> points = blobs(3000, 5);
  FuzzyClustering clustering(GetParam());
  clustering.initialise(points, 16);
  double last = clustering.iterate(points);
  const double first = last;
  for (int i = 0; i < 30; ++i) {
    const double objective = clustering.iterate(points);
    EXPECT_LE(objective, last * (1 + 1e-6)) << "iteration " << i;
    last = objective;
  }
  EXPECT_LT(last, first * 0.95);
}

TEST_P(Fuzzifier, AgreesWithTheTextbookFormula) {
  const std::vector<Vec3f> points = blobs(40, 6);
  FuzzyClustering clustering(GetParam());
  clustering.initialise(points, 5);
  const std::vector<Vec3f> before = clustering.prototypes();
  clustering.iterate(points);
  const double m = GetParam();
  for (std::size_t j = 0; j < before.size(); ++j) {
    double weight = 0, x = 0;
    for (const Vec3f& p : points) {
      double sum = 0;
      bool on_other = false, on_this = false;
      for (std::size_t k = 0; k < before.size(); ++k) {
        if (p == before[k]) (k == j ? on_this : on_other) = true;
        const Vec3d to_j = toDouble(p) - toDouble(before[j]);
        const Vec3d to_k = toDouble(p) - toDouble(before[k]);
        sum += std::pow(std::sqrt(dot(to_j, to_j) / dot(to_k, to_k)), 2 / (m - 1));
      }
      const double u = on_this ? 1 : (on_other ? 0 : 1 / sum);
      weight += std::pow(u, m);
      x += std::pow(u, m) * p.x;
    }
    EXPECT_NEAR(clustering.prototypes()[j].x, x / weight, 2e-5);
  }
}

INSTANTIATE_TEST_SUITE_P(Range, Fuzzifier, testing::Values(1.05F, 1.25F, 1.5F, 2.0F, 4.0F));

TEST(FuzzyClustering, APointOnPrototypesIsSharedByThem) {
  FuzzyClustering clustering(2);
  clustering.setPrototypes({{0, 0, 0}, {1, 0, 0}, {1, 0, 0}});
  EXPECT_EQ(clustering.memberships({0, 0, 0}), (std::vector<float>{1, 0, 0}));
  EXPECT_EQ(clustering.memberships({1, 0, 0}), (std::vector<float>{0, 0.5F, 0.5F}));
}

TEST(FuzzyClustering, IdenticalPointsAreNoTrouble) {
  const std::vector<Vec3f> points(100, Vec3f{0.25F, -1, 3});
  FuzzyClustering clustering(1.5F);
  clustering.initialise(points, 4);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(clustering.iterate(points), 0);
  for (const Vec3f& p : clustering.prototypes()) EXPECT_EQ(p, points[0]);
}

TEST(FuzzyClustering, WarmStartOnTheNextFrameBeatsACold) {
  DCM_REQUIRE_TEST_DATA();
  const auto frame92 = centroidsOf(readMeshFile(testDataFile("cloth-ball/cloth_ball92.ply")), 20);
  const auto frame93 = centroidsOf(readMeshFile(testDataFile("cloth-ball/cloth_ball93.ply")), 20);
  FuzzyClustering warm(1.5F);
  warm.initialise(frame92, 256);
  for (int i = 0; i < 5; ++i) warm.iterate(frame92);
  FuzzyClustering cold(1.5F);
  cold.initialise(frame93, 256);
  EXPECT_LT(warm.iterate(frame93), 0.9 * cold.iterate(frame93));
  EXPECT_LT(warm.iterate(frame93), 0.95 * cold.iterate(frame93));
}

}  // namespace
}  // namespace deformable_contact_monitor
