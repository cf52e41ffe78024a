// Steps at the limits of float32, and what one outlier or a fast common motion may cost.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "scenes.h"
#include "swept_suite.h"

namespace deformable_contact_monitor {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
const float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kLargest = std::numeric_limits<float>::max();

class SweptExtremes : public SweptSuite {
 protected:
  void expectAsTheOracle(const Scene& scene, const std::string& what) {
    for (const AdjacentPairs adjacent : kBothAdjacent) {
      const std::vector<TrianglePair> expected = oracleSwept(scene, adjacent);
      for (const int clusters : clusterCounts()) {
        Options options = timedOptions(adjacent);
        options.clusters = clusters;
        const DetectionResult& result = detector_->detect(scene, options);
        ASSERT_TRUE(samePairs(expected, result.contacts))
            << what << ", clusters " << clusters << ", " << toString(adjacent);
      }
    }
  }
};

// A small cloth that falls through another, and both with themselves.
Scene smallCloths() {
  Scene scene = pairScene(clothGrid(3, 4, 0, 0.5F), clothGrid(3, 4, -1, -0.5F));
  scene.setEarlier(1, RigidTransform(), clothGrid(3, 4, 1, -0.5F).vertices);
  for (const BodyId b : {0U, 1U}) scene.setPairEnabled(b, b, true);
  return scene;
}

Scene scaledBy(const Scene& scene, int power) {
  Scene out = scene;
  const auto scale = [power](std::vector<float> xyz) {
    for (float& x : xyz) x = std::ldexp(x, power);
    return xyz;
  };
  for (BodyId b = 0; b < scene.bodyCount(); ++b) {
    const std::vector<float> xyz = scale(scene.body(b).mesh.vertices);
    out.setVertices(b, xyz.data(), xyz.size() / 3);
    if (!scene.body(b).earlier) continue;
    out.setEarlier(b, RigidTransform(), scale(scene.body(b).earlier->vertices));
  }
  return out;
}

TEST_P(SweptExtremes, DenormalsAndHugeOnes) {
  for (const int power : {-147, -140, -126, -60, 60, 125}) {
    expectAsTheOracle(scaledBy(smallCloths(), power), "2^" + std::to_string(power));
  }
}

// One coordinate of one vertex, in one state or in both.
TEST_P(SweptExtremes, OneVertexFarOff) {
  for (const float far : {1e10F, 1e30F, kLargest, -kLargest, 1e-30F, -0x1p-149F}) {
    for (const int states : {1, 2, 3}) {
      Scene scene = smallCloths();
      std::vector<float> before = scene.body(1).earlier->vertices;
      std::vector<float> after = scene.body(1).mesh.vertices;
      if ((states & 1) != 0) before[17] = far;
      if ((states & 2) != 0) after[17] = far;
      scene.setVertices(1, after.data(), after.size() / 3);
      scene.setEarlier(1, RigidTransform(), before);
      expectAsTheOracle(scene, std::to_string(far) + " in " + std::to_string(states));
    }
  }
}

TEST_P(SweptExtremes, HugeBesideTiny) {
  const Triangle sheet{{{-1e30F, -1e30F, 0}, {1e30F, -1e30F, 0}, {0, 1e30F, 0}}};
  const Triangle speck{{{0, 0, 1e-30F}, {1e-30F, 0, 1e-30F}, {0, 1e-30F, 2e-30F}}};
  Triangle below = speck;
  for (Vec3f& v : below.v) v.z = -v.z;
  const Scene passes = movingPairScene({{sheet, sheet}}, {{speck, below}});
  EXPECT_EQ(swept(passes).size(), 1U);
  expectAsTheOracle(passes, "passes");
  const Scene stays = movingPairScene({{sheet, sheet}}, {{speck, speck}});
  EXPECT_TRUE(swept(stays).empty());
  // From one end of the numbers to the other, through the speck and beside it.
  Triangle left = sheet, right = sheet;
  for (int i = 0; i < 3; ++i) {
    left.v[i] = {-kLargest, sheet.v[i].x, sheet.v[i].y};
    right.v[i] = {kLargest, sheet.v[i].x, sheet.v[i].y};
  }
  expectAsTheOracle(movingPairScene({{left, right}}, {{speck, speck}}), "through all");
  EXPECT_EQ(swept(movingPairScene({{left, right}}, {{speck, speck}})).size(), 1U);
}

TEST_P(SweptExtremes, NotFiniteInOneStateAloneTakesNoPart) {
  for (const float bad : {kInfinity, -kInfinity, kNan}) {
    for (const bool at_end : {false, true}) {
      Scene scene = smallCloths();
      const std::size_t before = swept(scene).size();
      const std::uint64_t rejected = detector_->detect(scene, sweptOptions()).counters.rejected;
      EXPECT_EQ(rejected, 0U);
      std::vector<float> from = scene.body(1).earlier->vertices;
      std::vector<float> to = scene.body(1).mesh.vertices;
      (at_end ? to : from)[16] = bad;  // a vertex of several triangles
      scene.setVertices(1, to.data(), to.size() / 3);
      scene.setEarlier(1, RigidTransform(), from);
      expectAsTheOracle(scene, std::to_string(bad));
      EXPECT_LT(swept(scene).size(), before);
      EXPECT_GT(swept(scene).size(), 0U);
      EXPECT_GT(detector_->detect(scene, sweptOptions()).counters.rejected, 2U);
    }
  }
}

// A pose that rounds to infinity in one state.
TEST_P(SweptExtremes, APoseThatMakesVerticesInfinite) {
  Scene scene = smallCloths();
  RigidTransform far;
  far.translation[0] = 1e39;
  scene.setEarlier(1, far);
  const DetectionResult& result = detector_->detect(scene, sweptOptions());
  EXPECT_EQ(result.counters.rejected, scene.body(1).mesh.triangleCount());
  for (const TrianglePair& p : result.contacts) EXPECT_EQ(p.body_b, 0U) << p;
}

INSTANTIATE_TEST_SUITE_P(, SweptExtremes, ::testing::ValuesIn(sweptBackends()), backendName);

// On backends that have candidates: bounds on the work, which is no part of the result.
class SweptWork : public SweptSuite {
 protected:
  Counters settled(const Scene& scene) {
    detector_->reset();
    for (int cycle = 0; cycle < 3; ++cycle) detector_->detect(scene, sweptOptions());
    return detector_->detect(scene, sweptOptions()).counters;
  }
};

// Two layers, a step of a part of an edge.
Scene layers(const Vec3f& from, const Vec3f& to) {
  const auto shifted = [](TriangleMesh mesh, const Vec3f& by) {
    for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
      mesh.vertices[i] += by.x;
      mesh.vertices[i + 1] += by.y;
      mesh.vertices[i + 2] += by.z;
    }
    return mesh;
  };
  const TriangleMesh upper = clothGrid(40, 8, 0, 0.25F), lower = clothGrid(40, 8, -0.125F, 0.25F);
  Scene scene = pairScene(shifted(upper, to), shifted(lower, to));
  scene.setEarlier(0, RigidTransform(), shifted(upper, from).vertices);
  scene.setEarlier(1, RigidTransform(), shifted(lower, from + Vec3f{0, 0, -0.0625F}).vertices);
  for (const BodyId b : {0U, 1U}) scene.setPairEnabled(b, b, true);
  return scene;
}

TEST_P(SweptWork, AFastOutlierCostsOnlyItself) {
  Scene scene = layers({0, 0, 0}, {0, 0, 0});
  const std::uint64_t triangles = scene.triangleCount();
  const Counters plain = settled(scene);
  ASSERT_GT(plain.candidates, 0U);
  for (const float speed : {100.0F, 1e6F, 1e30F}) {
    Scene with_outlier = scene;
    TriangleMesh mesh = scene.body(1).mesh;
    std::vector<float> before = scene.body(1).earlier->vertices;
    const auto first = static_cast<std::uint32_t>(mesh.vertexCount());
    mesh.vertices.insert(mesh.vertices.end(), {4, 4, speed, 4.1F, 4, speed, 4, 4.1F, speed});
    before.insert(before.end(), {4, 4, -speed, 4.1F, 4, -speed, 4, 4.1F, -speed});
    mesh.triangles.insert(mesh.triangles.end(), {first, first + 1, first + 2});
    with_outlier.setMesh(1, mesh);
    with_outlier.setEarlier(1, RigidTransform(), before);
    const Counters with = settled(with_outlier);
    EXPECT_LE(with.candidates, plain.candidates + 2 * triangles) << speed;
    EXPECT_LE(with.interval_overlaps, 2 * plain.interval_overlaps + 10 * triangles) << speed;
  }
}

// Powers of two, so that no place is rounded.
TEST_P(SweptWork, AFastCommonMotionCostsLittle) {
  const Counters slow = settled(layers({0, 0, 0}, {0, 0, 0}));
  for (const Vec3f& step : {Vec3f{64, 0, 0}, Vec3f{0, 32, 0}, Vec3f{32, 64, 32}}) {
    const Counters fast = settled(layers({0, 0, 0}, step));
    EXPECT_LE(fast.candidates, 2 * slow.candidates) << step.x << " " << step.y;
    EXPECT_LE(fast.interval_overlaps, 4 * slow.interval_overlaps) << step.x << " " << step.y;
  }
}

INSTANTIATE_TEST_SUITE_P(, SweptWork, ::testing::ValuesIn(sweptProductBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
