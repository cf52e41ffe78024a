// The references behind the detector's interface: what they find where arithmetic decides nothing.
#include <gtest/gtest.h>

#include <cmath>

#include "cgal_oracle.h"
#include "detector_suite.h"
#include "random_scenes.h"
#include "reference/reference_detectors.h"
#include "refusal.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

#ifdef DCM_HAVE_FCL

TEST(FclDetector, FindsTheContactsOfBodiesInGeneralPosition) {
  Scene scene = pairScene(clothGrid(30, 1, 0, 0.1F), clothGrid(25, 1.1F, 0.013F, -0.1F));
  RigidTransform pose;
  pose.translation[0] = 0.0123;
  scene.setPose(1, pose);
  const auto expected = oracleContacts(scene, AdjacentPairs::kSkip);
  ASSERT_GT(expected.size(), 100U);
  const auto detector = makeFclDetector();
  EXPECT_EQ("fcl", detector->backend());
  const DetectionResult& result = detector->detect(scene, Options());
  EXPECT_TRUE(samePairs(expected, result.contacts));
  EXPECT_FALSE(result.guaranteed);
}

TEST(FclDetector, LeavesSharersOutOfSelfContacts) {
  TriangleMesh folded = clothGrid(30, 1, 0, 0.1F);
  for (std::size_t i = 0; i < folded.vertices.size(); i += 3) {
    folded.vertices[i] = std::abs(folded.vertices[i] - 0.507F);
  }
  const Scene scene = selfScene(folded);
  const auto expected = oracleContacts(scene, AdjacentPairs::kSkip);
  ASSERT_GT(expected.size(), 100U);
  for (const AdjacentPairs adjacent : kBothAdjacent) {
    EXPECT_TRUE(
        samePairs(expected, makeFclDetector()->detect(scene, withAdjacent(adjacent)).contacts));
  }
}

TEST(FclDetector, SurvivesDegenerateAndNonFiniteTriangles) {
  const auto detector = makeFclDetector();
  for (std::uint32_t seed = 0; seed < 500; ++seed) {
    EXPECT_TRUE(isOrdered(detector->detect(randomScene(seed), Options()).contacts));
  }
}

TEST(FclDetector, RefusesSweptMotion) {
  Options options;
  options.motion = Motion::kSwept;
  const auto detector = makeFclDetector();
  EXPECT_EQ(refusal([&] { detector->detect(randomScene(0), options); }),
            "backend \"fcl\" knows no swept motion");
}

TEST(FclDetector, CountsWhatItHas) {
  TriangleMesh broken = clothGrid(4, 1, 0, 0.1F);
  broken.vertices[0] = NAN;
  const Scene scene = pairScene(broken, clothGrid(4, 1, 0.01F, -0.1F));
  const auto detector = makeFclDetector();
  for (int cycle = 0; cycle < 2; ++cycle) {
    const DetectionResult& result = detector->detect(scene, Options());
    EXPECT_GT(result.contacts.size(), 0U);
    EXPECT_EQ(scene.triangleCount(), result.counters.triangles);
    EXPECT_EQ(2U, result.counters.rejected);
    EXPECT_EQ(0U, result.counters.candidates) << "it does not tell which pairs came to its test";
  }
}

TEST(FclDetector, GivesSeparationsByTheRuleOfAll) {
  Scene scene = pairScene(clothGrid(9, 1, 0, 0.1F), clothGrid(8, 1, 0.01F, -0.1F));
  const BodyId idle = scene.addBody("idle", clothGrid(2, 1, 0, 0));
  scene.setMargin(idle, 1);
  const auto detector = makeFclDetector();
  const std::size_t count = detector->detect(scene, Options()).contacts.size();
  ASSERT_GT(count, 10U);
  EXPECT_TRUE(detector->detect(scene, Options()).separations_m.empty());
  scene.setMargin(0, 0.01F);
  EXPECT_EQ(detector->detect(scene, Options()).separations_m, std::vector<float>(count, 0));
}

#endif

TEST(BruteForceDetector, IsGuaranteedWhateverTheOptions) {
  const auto detector = makeBruteForceDetector();
  EXPECT_EQ("brute_force", detector->backend());
  Options options;
  const Scene scene = pairScene(clothGrid(2, 1, 0, 0), clothGrid(2, 1, 0, 0));
  EXPECT_TRUE(detector->detect(scene, options).guaranteed);
  options.predicates = Predicates::kConservative;
  options.overlap = 0;
  EXPECT_TRUE(detector->detect(scene, options).guaranteed) << "it has no clusters";
}

}  // namespace
}  // namespace deformable_contact_monitor
