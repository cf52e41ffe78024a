// Margins: pairs near each other, against brute force and against CGAL's distances.
#include <gtest/gtest.h>

#include <cmath>

#include "cgal_oracle.h"
#include "core/rules/posed_vertex.h"
#include "detector_suite.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

Triangle posedTriangle(const Body& body, std::uint32_t index) {
  Triangle t;
  for (std::size_t k = 0; k < 3; ++k) {
    const float* v = &body.mesh.vertices[std::size_t{3} * body.mesh.triangles[3 * index + k]];
    t.v[k] = apply(body.pose, {v[0], v[1], v[2]});
  }
  return t;
}

// Two cloths of 128 triangles each some way apart, and a third between them.
Scene threeCloths(float gap) {
  Scene scene;
  for (int b = 0; b < 3; ++b) {
    const float height = gap * static_cast<float>(b);
    scene.addBody("cloth " + std::to_string(b), clothGrid(8, 1, height, 0.05F * (1 - b)));
  }
  for (BodyId a = 0; a < 3; ++a) {
    for (BodyId b = a; b < 3; ++b) scene.setPairEnabled(a, b, true);
  }
  RigidTransform pose;
  pose.translation[0] = 0.031;
  scene.setPose(1, pose);
  return scene;
}

class Margin : public DetectorSuite {};

TEST_P(Margin, EqualsBruteForceForAnyClusters) {
  const auto reference = makeBruteForceDetector();
  for (const float gap : {0.01F, 0.04F, 0.2F}) {
    Scene scene = threeCloths(gap);
    for (const float margin : {0.0F, 0.005F, 0.05F, 0.3F}) {
      scene.setMargin(0, margin);
      scene.setMargin(1, margin / 4);
      const DetectionResult& expected = reference->detect(scene, Options());
      for (const int clusters : {1, 7, 64, 0}) {
        Options options;
        options.clusters = clusters;
        const DetectionResult& result = detector_->detect(scene, options);
        EXPECT_TRUE(samePairs(expected.contacts, result.contacts))
            << "gap " << gap << ", margin " << margin;
        EXPECT_EQ(expected.separations_m, result.separations_m)
            << "gap " << gap << ", margin " << margin;
      }
    }
  }
}

TEST_P(Margin, SeparationsAreDistancesUpToTheLargerMargin) {
  Scene scene = threeCloths(0.04F);
  scene.setMargin(0, 0.03F);
  scene.setMargin(2, 0.01F);
  const DetectionResult& result = detector_->detect(scene, Options());
  ASSERT_EQ(result.contacts.size(), result.separations_m.size());
  std::size_t near = 0;
  auto found = result.contacts.begin();
  const std::uint32_t count = 128;
  for (std::uint32_t a = 0; a < 3 * count; ++a) {
    for (std::uint32_t b = a + 1; b < 3 * count; ++b) {
      const TrianglePair pair{a / count, a % count, b / count, b % count};
      const bool reported = found != result.contacts.end() && *found == pair;
      const float separation = reported ? result.separations_m[found - result.contacts.begin()] : 0;
      if (reported) ++found;
      if (pair.body_a == pair.body_b) continue;  // neighbours are always near
      const float margin =
          std::max(scene.body(pair.body_a).margin_m, scene.body(pair.body_b).margin_m);
      const double distance =
          oracleDistance(posedTriangle(scene.body(pair.body_a), pair.triangle_a),
                         posedTriangle(scene.body(pair.body_b), pair.triangle_b));
      if (reported) {
        EXPECT_NEAR(distance, separation, 1e-6) << pair;
        near += distance > 0;
      }
      if (std::abs(distance - margin) > 1e-6) {
        EXPECT_EQ(distance < margin, reported) << pair << " at " << distance;
      }
    }
  }
  EXPECT_EQ(result.contacts.end(), found);
  EXPECT_GT(near, 100U);
}

TEST_P(Margin, IsClosedAndTheLargerOfTheTwo) {
  const Triangle low{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  const Triangle high{{{0, 0, 0.5F}, {1, 0, 0.5F}, {0, 1, 0.5F}}};
  Scene scene = pairScene(meshOf({low}), meshOf({high}));
  scene.setMargin(0, std::nextafter(0.5F, 0.0F));
  EXPECT_TRUE(contacts(scene).empty());
  scene.setMargin(0, 0);
  scene.setMargin(1, 0.5F);
  ASSERT_EQ(1U, contacts(scene).size());
  EXPECT_EQ(0.5F, detector_->detect(scene, Options()).separations_m.at(0));
}

// Upright triangles and the segments of a rope, well above a cloth whose plane they cross, and
// whose planes the cloth crosses.
TEST_P(Margin, NearPairsAreTheSameByConservativePredicates) {
  std::vector<Triangle> upright, rope;
  for (int i = 0; i < 6; ++i) {
    const float x = 0.1F + 0.13F * static_cast<float>(i);
    upright.push_back({{{x, 0.2F, 0.3F}, {x + 0.1F, 0.7F, 0.35F}, {x, 0.4F, 0.9F}}});
    const Vec3f from{x, 0.1F, 0.25F}, to{x + 0.13F, 0.9F, 0.6F};
    rope.push_back({{from, to, to}});
  }
  Scene scene;
  scene.addBody("cloth", clothGrid(8, 1, 0, 0.05F));
  scene.addBody("upright", meshOf(upright));
  scene.addBody("rope", meshOf(rope));
  for (BodyId a = 0; a < 3; ++a) {
    for (BodyId b = a + 1; b < 3; ++b) scene.setPairEnabled(a, b, a == 0);
  }
  const RigidTransform turned{{0.36, 0.48, -0.8, -0.8, 0.6, 0, 0.48, 0.64, 0.6}, {1, -0.5, 0.3}};
  for (BodyId id = 0; id < 3; ++id) scene.setPose(id, turned);
  for (const float margin : {0.0F, 0.4F, 2.0F}) {
    scene.setMargin(0, margin);
    const DetectionResult exact = detector_->detect(scene, Options());
    EXPECT_EQ(exact.contacts.empty(), margin == 0);
    for (const float separation : exact.separations_m) EXPECT_GT(separation, 0.1F);
    Options options;
    options.predicates = Predicates::kConservative;
    const DetectionResult& result = detector_->detect(scene, options);
    EXPECT_TRUE(samePairs(exact.contacts, result.contacts)) << margin;
    EXPECT_EQ(exact.separations_m, result.separations_m) << margin;
  }
}

INSTANTIATE_TEST_SUITE_P(, Margin, ::testing::ValuesIn(allBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
