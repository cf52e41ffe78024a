// Only what an enabled pair can need is posed, clustered and swept; results never change.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "cgal_oracle.h"
#include "detector_suite.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

// Two cloths that cross each other, body 0 and body 1.
Scene crossingCloths() {
  return pairScene(clothGrid(40, 1, 0, 0.1F), clothGrid(40, 1, 0.01F, -0.1F));
}

RigidTransform shifted(double x) {
  RigidTransform pose;
  pose.translation[0] = x;
  return pose;
}

class Culling : public DetectorSuite {
 protected:
  // Returns the counters of a cold start. Unlike the result, the work depends on what earlier
  // cycles left.
  Counters counters(const Scene& scene) {
    detector_->reset();
    return detector_->detect(scene, Options()).counters;
  }
};

TEST_P(Culling, EveryPosedTriangleIsAccountedFor) {
  Scene scene = crossingCloths();
  scene.setPose(1, shifted(0.5));
  const Counters c = counters(scene);
  EXPECT_EQ(scene.triangleCount(), c.triangles);
  EXPECT_EQ(scene.triangleCount(), c.posed);
  EXPECT_EQ(c.posed, c.culled + c.clustered + c.large + c.rejected);
  EXPECT_LE(c.clustered, c.cluster_entries);
  EXPECT_LE(c.candidates, c.interval_overlaps + c.large * c.posed);
  EXPECT_LE(detector_->detect(scene, Options()).contacts.size(), c.candidates);
  EXPECT_GT(c.culled, 1000U) << "the halves that stick out";
}

// Beside all partners too, where others are culled.
TEST_P(Culling, TrianglesThatAreNotFiniteAreRejectedWhereverTheyAre) {
  Scene scene = crossingCloths();
  scene.setPose(1, shifted(0.5));
  const auto expected = oracleContacts(scene, AdjacentPairs::kBeyondShared);
  TriangleMesh mesh = scene.body(0).mesh;
  const std::uint64_t whole = mesh.triangleCount();
  for (const float x : {INFINITY, -INFINITY, NAN}) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float corners[] = {-3, -3, -3, -4, -4, -4, -5, -5, -5};
      for (std::size_t i = 0; i < 9; ++i) {
        mesh.vertices.push_back(i == axis ? x : corners[i]);
        if (i % 3 == 0) mesh.triangles.push_back(static_cast<std::uint32_t>(mesh.vertexCount()));
      }
    }
  }
  scene.setMesh(0, mesh);
  EXPECT_EQ(mesh.triangleCount() - whole, counters(scene).rejected);
  EXPECT_TRUE(samePairs(expected, contacts(scene)));
}

TEST_P(Culling, FarBodiesDropOut) {
  Scene scene = crossingCloths();
  const auto expected = oracleContacts(scene, AdjacentPairs::kBeyondShared);
  ASSERT_GT(expected.size(), 100U);
  ASSERT_TRUE(samePairs(expected, contacts(scene)));
  const Counters before = counters(scene);
  for (int i = 0; i < 10; ++i) {
    const BodyId far = scene.addBody("far", clothGrid(10, 1, 0, 0));
    scene.setPose(far, shifted(100 + 10 * i));
    scene.setPairEnabled(far, 0, true);
  }
  EXPECT_TRUE(samePairs(expected, contacts(scene)));
  const Counters after = counters(scene);
  EXPECT_EQ(before.culled + 10 * 200, after.culled);
  EXPECT_EQ(before.clustered, after.clustered);
  // Boxes that the sweeps round make a few more or less.
  EXPECT_NEAR(static_cast<double>(before.candidates), static_cast<double>(after.candidates),
              0.01 * static_cast<double>(before.candidates));
}

TEST_P(Culling, BodiesOutOfEveryEnabledPairAreNotEvenPosed) {
  Scene scene = crossingCloths();
  const auto expected = contacts(scene);
  const Counters before = counters(scene);
  const BodyId off = scene.addBody("off", clothGrid(20, 1, 0.005F, 0.1F));
  scene.setPose(off, shifted(0.1));
  EXPECT_TRUE(samePairs(expected, contacts(scene)));
  const Counters after = counters(scene);
  EXPECT_EQ(before.posed, after.posed);
  EXPECT_EQ(before.clustered, after.clustered);
  EXPECT_EQ(before.interval_overlaps, after.interval_overlaps);
  EXPECT_EQ(scene.triangleCount(), after.triangles);
}

TEST_P(Culling, WithEveryClassOffNothingIsDone) {
  Scene scene = crossingCloths();
  contacts(scene);
  scene.setPairEnabled(0, 1, false);
  const DetectionResult& result = detector_->detect(scene, Options());
  EXPECT_TRUE(result.contacts.empty());
  EXPECT_EQ(0U, result.counters.posed);
  EXPECT_EQ(0U, result.counters.clustered);
  EXPECT_EQ(0U, result.counters.cluster_entries);
  EXPECT_EQ(0U, result.counters.interval_overlaps);
  EXPECT_EQ(0U, result.counters.candidates);
  scene.setPairEnabled(0, 1, true);
  EXPECT_FALSE(contacts(scene).empty()) << "after a cycle with nothing to do";
}

TEST_P(Culling, ClassesThatAreOffAreNotReported) {
  // Both cloths also fold through themselves.
  Scene scene;
  for (int b = 0; b < 2; ++b) {
    TriangleMesh folded = clothGrid(20, 1, 0.01F * static_cast<float>(b), 0.1F);
    for (std::size_t i = 0; i < folded.vertices.size(); i += 3) {
      folded.vertices[i] = std::abs(folded.vertices[i] - 0.5F);
    }
    scene.addBody("folded", folded);
  }
  std::size_t found = 0;
  for (int enabled = 0; enabled < 8; ++enabled) {
    scene.setPairEnabled(0, 0, (enabled & 1) != 0);
    scene.setPairEnabled(1, 1, (enabled & 2) != 0);
    scene.setPairEnabled(0, 1, (enabled & 4) != 0);
    const auto expected = oracleContacts(scene, AdjacentPairs::kBeyondShared);
    EXPECT_TRUE(samePairs(expected, contacts(scene))) << "enabled classes " << enabled;
    found += expected.size();
  }
  EXPECT_GT(found, 1000U);
}

TEST_P(Culling, SceneThatShrinksAndGrowsLeavesNothingBehind) {
  for (const int n : {30, 3, 0, 12, 40}) {
    Scene scene = n == 0 ? Scene() : pairScene(clothGrid(n, 1, 0, 0.1F), clothGrid(n, 1, 0, -0.1F));
    const auto expected = oracleContacts(scene, AdjacentPairs::kBeyondShared);
    EXPECT_TRUE(samePairs(expected, contacts(scene))) << n;
  }
}

TEST_P(Culling, TouchingBoxesAreNotFar) {
  // The bodies' boxes share one plane, and one point of contact in it.
  const Scene scene = pairScene(meshOf({{{{0, 0, 0}, {1, 0, 0}, {0.5F, 1, 0}}}}),
                                meshOf({{{{0.5F, 1, 0}, {0, 2, 0}, {1, 2, 0}}}}));
  EXPECT_EQ(1U, contacts(scene).size());
}

INSTANTIATE_TEST_SUITE_P(, Culling, ::testing::ValuesIn(productBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
