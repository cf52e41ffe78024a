// The geometry that detectors give with their contacts: for each the rule's, bit by bit, on every
// backend.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <random>

#include "core/common/posed_body.h"
#include "core/detector_pool.h"
#include "core/rules/geometry_of_pair.h"
#include "detector_suite.h"
#include "random_scenes.h"
#include "reference/reference_detectors.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

Options withGeometry() {
  Options options;
  options.geometry = true;
  return options;
}

bool sameBits(float a, float b) { return std::memcmp(&a, &b, sizeof a) == 0; }

bool sameBits(const Vec3f& a, const Vec3f& b) {
  return sameBits(a.x, b.x) && sameBits(a.y, b.y) && sameBits(a.z, b.z);
}

bool sameBits(const PairGeometry& a, const PairGeometry& b) {
  return sameBits(a.point_a, b.point_a) && sameBits(a.point_b, b.point_b) &&
         sameBits(a.normal, b.normal) && sameBits(a.separation_m, b.separation_m) &&
         a.flags == b.flags;
}

// One for each contact, in their order, of that contact.
void expectRulesGeometry(const Scene& scene, const DetectionResult& result) {
  ASSERT_EQ(result.contacts.size(), result.geometry.size());
  for (std::size_t i = 0; i < result.contacts.size(); ++i) {
    const TrianglePair& pair = result.contacts[i];
    const float separation_m = result.separations_m.empty() ? 0 : result.separations_m[i];
    const PairGeometry expected =
        geometryOf(PosedBody(scene.body(pair.body_a)).triangle(pair.triangle_a),
                   PosedBody(scene.body(pair.body_b)).triangle(pair.triangle_b), separation_m);
    ASSERT_TRUE(sameBits(expected, result.geometry[i])) << pair;
    if (separation_m > 0) {
      ASSERT_TRUE(sameBits(separation_m, result.geometry[i].separation_m)) << pair;
    }
  }
}

// Two waving cloths through each other, and each with itself.
Scene twoCloths(float margin_m) {
  Scene scene = pairScene(clothGrid(24, 1, 0, 0.05F), clothGrid(23, 1, 0.01F, -0.05F));
  scene.setPairEnabled(0, 0, true);
  scene.setPairEnabled(1, 1, true);
  scene.setMargin(0, margin_m);
  RigidTransform pose;
  pose.translation[1] = 0.0123;
  scene.setPose(1, pose);
  return scene;
}

class Geometry : public DetectorSuite {};

TEST_P(Geometry, IsThereIfAskedForAlone) {
  const Scene scene = twoCloths(0);
  const std::vector<TrianglePair> without = contacts(scene);
  EXPECT_TRUE(detector_->detect(scene).geometry.empty());
  const DetectionResult& with = detector_->detect(scene, withGeometry());
  EXPECT_GT(with.geometry.size(), 100U);
  EXPECT_TRUE(samePairs(without, with.contacts));
  EXPECT_TRUE(detector_->detect(scene).geometry.empty());
}

TEST_P(Geometry, IsTheRulesForEachContact) {
  for (const float margin_m : {0.0F, 0.02F}) {
    const Scene scene = twoCloths(margin_m);
    const DetectionResult& result = detector_->detect(scene, withGeometry());
    expectRulesGeometry(scene, result);
    EXPECT_GT(result.contacts.size(), 500U);
  }
}

TEST_P(Geometry, IsTheRulesInRandomScenes) {
  std::mt19937 random(3);
  std::size_t found = 0;
  for (std::uint32_t seed = 0; seed < 400 && !HasFatalFailure(); ++seed) {
    Scene scene = randomScene(seed);
    for (BodyId id = 0; id < scene.bodyCount() && seed % 3 == 0; ++id) {
      scene.setMargin(id, std::ldexp(1.0F, static_cast<int>(random() % 40) - 20));
    }
    const DetectionResult& result = detector_->detect(scene, withGeometry());
    found += result.contacts.size();
    expectRulesGeometry(scene, result);
  }
  EXPECT_GT(found, 10000U);
  if (GetParam().name == std::string("brute_force")) return;
  const Scene large = largeRandomScene(1);
  expectRulesGeometry(large, detector_->detect(large, withGeometry()));
}

// Returns a cloth with vertices on a grid of 1/64 m, in a plane that is level or slopes along x.
TriangleMesh flatCloth(float slope, float shift) {
  TriangleMesh mesh = clothGrid(16, 0.25F, 0, 0);
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
    mesh.vertices[i] += shift;
    mesh.vertices[i + 1] += 0.5F * shift;
    mesh.vertices[i + 2] = slope * mesh.vertices[i];
  }
  return mesh;
}

// Cloths that are equal, and cloths in one plane: contacts share vertices or are coplanar.
TEST_P(Geometry, IsTheRulesForLayersOfCloth) {
  const TriangleMesh wave = clothGrid(16, 0.25F, 0, 0.02F);
  for (const Scene& scene : {pairScene(wave, wave), pairScene(flatCloth(0, 0), flatCloth(0, 0)),
                             pairScene(flatCloth(0, 0), flatCloth(0, 0.0078125F)),
                             pairScene(flatCloth(0.25F, 0), flatCloth(0.25F, 0.0078125F)),
                             pairScene(flatCloth(0.3F, 0), flatCloth(0.3F, 0.0078125F))}) {
    for (int cycle = 0; cycle < 2; ++cycle) {
      const DetectionResult& result = detector_->detect(scene, withGeometry());
      EXPECT_GT(result.contacts.size(), 1000U);
      expectRulesGeometry(scene, result);
    }
  }
}

// Pairs that conservative predicates list although they are apart must be reported as apart.
TEST_P(Geometry, MakesNothingUp) {
  std::size_t apart = 0;
  Options options = withGeometry();
  options.predicates = Predicates::kConservative;
  for (std::uint32_t seed = 0; seed < 200; ++seed) {
    const Scene scene = randomScene(seed);
    const DetectionResult& result = detector_->detect(scene, options);
    expectRulesGeometry(scene, result);
    for (const PairGeometry& g : result.geometry) {
      ASSERT_TRUE(std::isfinite(g.separation_m) && isFinite(g.normal) && isFinite(g.point_a) &&
                  isFinite(g.point_b));
      apart += g.separation_m > 0;
    }
  }
  EXPECT_GT(apart, 0U);
}

TEST_P(Geometry, OfExactContactsNeverSaysApart) {
  for (std::uint32_t seed = 0; seed < 200; ++seed) {
    const DetectionResult& result = detector_->detect(randomScene(seed), withGeometry());
    for (const PairGeometry& g : result.geometry) ASSERT_LE(g.separation_m, 0) << seed;
  }
}

// More contacts than a backend may bring into their order by counting: first all at once, then once
// it expects so many.
TEST_P(Geometry, IsThatOfAllContactsOfOneTriangle) {
  constexpr std::uint32_t kNeedles = 2500;
  std::vector<Triangle> needles;
  for (std::uint32_t i = 0; i < kNeedles; ++i) {
    const float x = 0.01F + 0.0003F * static_cast<float>(i % 50);
    const float y = 0.01F + 0.0003F * static_cast<float>(i / 50);
    needles.push_back({{{x, y, -0.1F}, {x + 0.0001F, y, 0.1F}, {x, y + 0.0001F, 0.2F}}});
  }
  const Triangle floor{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  Scene scene = pairScene(meshOf({floor}), meshOf(needles));
  for (const float margin_m : {0.0F, 0.0F, 0.0F, 0.001F}) {
    scene.setMargin(0, margin_m);
    const DetectionResult& result = detector_->detect(scene, withGeometry());
    EXPECT_EQ(result.contacts.size(), kNeedles);
    expectRulesGeometry(scene, result);
  }
}

TEST_P(Geometry, WithoutContactsThereIsNone) {
  const Triangle here{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  const Triangle there{{{0, 0, 5}, {1, 0, 5}, {0, 1, 5}}};
  EXPECT_TRUE(detector_->detect(pairScene(meshOf({here}), meshOf({there})), withGeometry())
                  .geometry.empty());
  EXPECT_TRUE(detector_->detect(Scene(), withGeometry()).geometry.empty());
}

// As many as contacts, or none.
TEST_P(Geometry, StaysInStepWhereACycleEndsEarly) {
  const Scene scene = twoCloths(0.02F);
  Options options = withGeometry();
  for (int us = 0; us < 40000; us += us / 8 + 50) {
    options.limits.deadline = std::chrono::steady_clock::now() + std::chrono::microseconds(us);
    const DetectionResult& result = detector_->detect(scene, options);
    if (!result.geometry.empty()) expectRulesGeometry(scene, result);
  }
  const std::atomic<bool> stop{true};
  options.limits = Limits();
  options.limits.stop = &stop;
  EXPECT_TRUE(detector_->detect(scene, options).geometry.empty());
  expectRulesGeometry(scene, detector_->detect(scene, withGeometry()));
}

// Detectors that have others do the work.
TEST_P(Geometry, IsPassedOn) {
  const Scene scene = twoCloths(0.01F);
  PoolSettings settings;
  settings.cpu = GetParam().make;
  const auto on_cpu = makeDetectorPool(settings);
  expectRulesGeometry(scene, on_cpu->detect(scene, withGeometry()));
  settings.device = GetParam().make;
  const auto on_device = makeDetectorPool(settings);
  expectRulesGeometry(scene, on_device->detect(scene, withGeometry()));
}

INSTANTIATE_TEST_SUITE_P(, Geometry, ::testing::ValuesIn(allBackends()), backendName);

#ifdef DCM_HAVE_FCL
// FCL's contacts are approximate; their geometry is not.
TEST(GeometryOfFcl, IsTheRules) {
  const Scene scene = twoCloths(0);
  const auto fcl = makeFclDetector();
  const DetectionResult& result = fcl->detect(scene, withGeometry());
  EXPECT_GT(result.contacts.size(), 100U);
  expectRulesGeometry(scene, result);
}
#endif

}  // namespace
}  // namespace deformable_contact_monitor
