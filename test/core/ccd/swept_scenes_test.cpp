// Real steps: counts that are known, and sets equal to those of the oracle, or of the exact verdict
// on every pair of overlapping swept boxes.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/mesh_file.h"
#include "core/predicates/swept_exact.h"
#include "moving_meshes.h"
#include "scenes.h"
#include "swept/swept_oracle.h"
#include "swept_suite.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

struct Step {
  TriangleMesh from, to;

  Step(const std::string& file0, const std::string& file1)
      : from(readMeshFile(testDataFile(file0))), to(readMeshFile(testDataFile(file1))) {}

  Scene scene() const {
    Scene scene = selfScene(to);
    scene.setEarlier(0, RigidTransform(), from.vertices);
    return scene;
  }
};

class SweptScenes : public DetectorSuite {};

TEST_P(SweptScenes, ClothFunnelEqualsTheOracle) {
  DCM_REQUIRE_TEST_DATA();
  const Step step("cloth-funnel/227.ply", "cloth-funnel/228.ply");
  const Scene scene = step.scene();
  for (const AdjacentPairs adjacent : kBothAdjacent) {
    const std::vector<TrianglePair> expected =
        oracleSweptContacts(selfScene(step.from), selfScene(step.to), adjacent);
    ASSERT_EQ(adjacent == AdjacentPairs::kSkip ? 381U : 510U, expected.size());
    Options options = sweptOptions(adjacent);
    for (const int clusters : {0, 1, 7, 64, 1000}) {
      for (const int threads : {1, 2}) {
        options.clusters = clusters;
        options.threads = threads;
        options.first_times = threads == 2;
        const DetectionResult& result = detector_->detect(scene, options);
        EXPECT_TRUE(samePairs(expected, result.contacts)) << clusters << ", " << threads;
        EXPECT_EQ(threads == 2 ? expected.size() : 0, result.first_times.size());
      }
    }
  }
}

TEST_P(SweptScenes, WithoutMotionItIsTheInstantResult) {
  DCM_REQUIRE_TEST_DATA();
  for (const char* file : {"cloth-funnel/228.ply", "cloth-ball/cloth_ball93.ply"}) {
    const Scene scene = Step(file, file).scene();
    for (const AdjacentPairs adjacent : kBothAdjacent) {
      const std::vector<TrianglePair> still = contacts(scene, withAdjacent(adjacent));
      EXPECT_TRUE(samePairs(still, contacts(scene, sweptOptions(adjacent)))) << file;
    }
  }
}

TEST_P(SweptScenes, ClothBallIsTheVerdictOnEveryPairOfBoxes) {
  DCM_REQUIRE_TEST_DATA();
  const Step step("cloth-ball/cloth_ball92.ply", "cloth-ball/cloth_ball93.ply");
  const std::vector<MovingTriangle> triangles = movingTriangles(step.from, step.to);
  std::vector<TrianglePair> expected;
  PredicateState state;
  std::size_t boxes = 0;
  for (const auto& [i, j] : sweptBoxPairs(triangles)) {
    const MovingTriangle &a = triangles[i], &b = triangles[j];
    const SharedVertices shared = sharedTrajectories(a, b);
    if (shared.any) continue;
    // Some by the oracle too.
    const bool contact =
        sweptVerdict(a, b, shared, AdjacentPairs::kSkip, false, state).part == PartVerdict::kMeet;
    if (++boxes % 20000 == 0) {
      ASSERT_EQ(sweptContact(a.from, a.to, b.from, b.to), contact) << i << " " << j;
    }
    if (contact) expected.emplace_back(0, i, 0, j);
    if (contact && expected.size() % 2000 == 0) {
      ASSERT_TRUE(sweptContact(a.from, a.to, b.from, b.to)) << i << " " << j;
    }
  }
  EXPECT_EQ(3975589U, boxes);
  ASSERT_EQ(204491U, expected.size());
  Options options = sweptOptions(AdjacentPairs::kSkip);
  for (const int threads : {1, 2}) {
    options.threads = threads;
    EXPECT_TRUE(samePairs(expected, contacts(step.scene(), options))) << threads;
  }
}

INSTANTIATE_TEST_SUITE_P(, SweptScenes, ::testing::ValuesIn(sweptProductBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
