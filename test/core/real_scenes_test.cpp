// Real scenes: counts that are known, and sets equal to the oracle's.
#include <gtest/gtest.h>

#include <tuple>

#include "cgal_oracle.h"
#include "core/mesh_file.h"
#include "detector_suite.h"
#include "scenes.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

struct RealScene {
  const char* name;
  const char* file;
  std::size_t skip, beyond_shared;  // contacts with itself
  std::size_t box_pairs;            // overlapping AABBs, sharers left out
};

constexpr RealScene kScenes[] = {
    {"cloth_ball92", "cloth-ball/cloth_ball92.ply", 61530, 63602, 773566},
    {"cloth_ball93", "cloth-ball/cloth_ball93.ply", 97320, 99872, 980183},
    {"funnel227", "cloth-funnel/227.ply", 261, 309, 25433},
    {"funnel228", "cloth-funnel/228.ply", 332, 382, 25806},
};

std::ostream& operator<<(std::ostream& out, const RealScene& scene) { return out << scene.name; }

class RealScenes : public ::testing::TestWithParam<std::tuple<Backend, RealScene>> {};

TEST_P(RealScenes, EqualTheOracleForAnyClustersAndThreads) {
  DCM_REQUIRE_TEST_DATA();
  const auto& [backend, real] = GetParam();
  const Scene scene = selfScene(readMeshFile(testDataFile(real.file)));
  ASSERT_EQ(real.box_pairs, oracleBoxPairs(scene));
  for (const AdjacentPairs adjacent : kBothAdjacent) {
    const std::vector<TrianglePair> expected = oracleContacts(scene, adjacent);
    ASSERT_EQ(adjacent == AdjacentPairs::kSkip ? real.skip : real.beyond_shared, expected.size());
    Options options = withAdjacent(adjacent);
    const auto detector = backend.make();
    const auto check = [&] {
      const DetectionResult& result = detector->detect(scene, options);
      EXPECT_TRUE(samePairs(expected, result.contacts))
          << "clusters " << options.clusters << ", threads " << options.threads;
      EXPECT_TRUE(result.guaranteed);
      EXPECT_TRUE(result.separations_m.empty());
      EXPECT_EQ(scene.triangleCount(), result.counters.triangles);
    };
    options.threads = 2;
    for (options.clusters = 1; options.clusters <= 256; options.clusters *= 2) check();
    for (const int clusters : {7, 1000, 0}) {
      options.clusters = clusters;
      check();
    }
    options.threads = 1;
    check();
  }
}

INSTANTIATE_TEST_SUITE_P(, RealScenes,
                         ::testing::Combine(::testing::ValuesIn(productBackends()),
                                            ::testing::ValuesIn(kScenes)),
                         [](const auto& info) {
                           return std::string(std::get<0>(info.param).name) + "_" +
                                  std::get<1>(info.param).name;
                         });

class RealMeshes : public DetectorSuite {};

TEST_P(RealMeshes, SoupOfUnsharedVerticesGivesTheSameSets) {
  DCM_REQUIRE_TEST_DATA();
  const TriangleMesh mesh = readMeshFile(testDataFile(kScenes[0].file));
  const Scene welded = selfScene(mesh), soup = selfScene(soupOf(mesh));
  for (const AdjacentPairs adjacent : kBothAdjacent) {
    const std::vector<TrianglePair> expected = oracleContacts(welded, adjacent);
    EXPECT_TRUE(samePairs(expected, contacts(soup, withAdjacent(adjacent))));
  }
}

TEST_P(RealMeshes, WarmStartsOnAMovingSceneChangeNothing) {
  DCM_REQUIRE_TEST_DATA();
  const Scene frames[] = {selfScene(readMeshFile(testDataFile(kScenes[2].file))),
                          selfScene(readMeshFile(testDataFile(kScenes[3].file)))};
  std::vector<TrianglePair> expected[2];
  for (int i = 0; i < 2; ++i) expected[i] = oracleContacts(frames[i], AdjacentPairs::kSkip);
  Options options = withAdjacent(AdjacentPairs::kSkip);
  for (int cycle = 0; cycle < 6; ++cycle) {
    options.refresh_period = 1 + cycle % 3;
    EXPECT_TRUE(samePairs(expected[cycle % 2], contacts(frames[cycle % 2], options)))
        << "cycle " << cycle;
  }
}

TEST_P(RealMeshes, RobotLinksAgainstATShirtOnPosesThatRound) {
  DCM_REQUIRE_TEST_DATA();
  Scene scene;
  TriangleMesh mesh = readMeshFile(testDataFile("tshirt/000.obj"));
  for (float& x : mesh.vertices) x *= 0.1F;  // to a T-shirt's size
  const BodyId shirt = scene.addBody("shirt", mesh);
  const std::string links = "robots/panda_description/meshes/collision/";
  const BodyId hand = scene.addBody("hand", readMeshFile(testDataFile(links + "hand.stl")));
  const BodyId arm = scene.addBody("arm", readMeshFile(testDataFile(links + "link5.stl")));
  scene.setPairEnabled(shirt, hand, true);
  scene.setPairEnabled(shirt, arm, true);
  std::size_t found = 0;
  for (int step = 0; step < 12; ++step) {
    const double angle = 0.37 * step, c = std::cos(angle), s = std::sin(angle);
    RigidTransform pose;
    const double rotation[9] = {c, -s, 0, s, c, 0, 0, 0, 1};
    std::copy(std::begin(rotation), std::end(rotation), pose.rotation);
    for (int axis = 0; axis < 3; ++axis) {
      pose.translation[axis] = 0.2 * std::sin(step + 2 * axis);
    }
    scene.setPose(hand, pose);
    pose.translation[2] -= 0.1;
    scene.setPose(arm, pose);
    const auto expected = oracleContacts(scene, AdjacentPairs::kBeyondShared);
    EXPECT_TRUE(samePairs(expected, contacts(scene))) << "step " << step;
    found += expected.size();
  }
  EXPECT_GT(found, 100U);
}

INSTANTIATE_TEST_SUITE_P(, RealMeshes, ::testing::ValuesIn(productBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
