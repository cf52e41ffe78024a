// Steps at the limits of float32, and what one outlier or a fast common motion may cost.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "scenes.h"
#include "swept_expected.h"

namespace deformable_contact_monitor {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
const float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kLargest = std::numeric_limits<float>::max();

class SweptExtremes : public SweptFixture {
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

}  // namespace
}  // namespace deformable_contact_monitor
