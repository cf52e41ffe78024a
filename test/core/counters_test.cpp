// Counters mean the same on every backend.
#include <gtest/gtest.h>

#include "core/common/scene_queries.h"
#include "detector_suite.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

Triangle moved(Triangle t, float x) {
  for (Vec3f& v : t.v) v.x += x;
  return t;
}

// In the plane z = x + y + 1, but for a shift along x: no filter sees that two of them are
// coplanar.
constexpr Triangle kTilted{{{0, 0, 1}, {3, 1, 5}, {1, 3, 5}}};
constexpr Triangle kTiltedToo{{{1, 1, 3}, {4, 2, 7}, {2, 4, 7}}};
constexpr int kTouching = 5;
constexpr int kCrossing = 7;

// Pairs far from each other along x: coplanar ones that overlap, and ones that cross each other.
Scene coplanarAndCrossingPairs() {
  std::vector<Triangle> a, b;
  for (int i = 0; i < kTouching + kCrossing; ++i) {
    const auto x = static_cast<float>(100 * i);
    const Triangle crossing{{{0, 0, -1}, {2, 2, 9}, {1, 2, 8}}};
    a.push_back(moved(kTilted, x));
    b.push_back(moved(i < kTouching ? kTiltedToo : crossing, x));
  }
  return pairScene(meshOf(a), meshOf(b));
}

class CountersTest : public DetectorSuite {
 protected:
  Counters counters(const Scene& scene, Predicates predicates) {
    Options options;
    options.predicates = predicates;
    return detector_->detect(scene, options).counters;
  }
};

TEST_P(CountersTest, TrianglesAreThoseOfTheSceneRejectedThoseOfBodiesThatTakePart) {
  TriangleMesh broken = clothGrid(6, 1, 0, 0.1F);
  const std::size_t count = broken.triangleCount();
  // One vertex inside the grid belongs to six triangles.
  broken.vertices[3 * (7 * 3 + 3)] = NAN;
  Scene scene = pairScene(broken, clothGrid(6, 1, 0.01F, -0.1F));
  const BodyId off = scene.addBody("off", broken);
  for (int cycle = 0; cycle < 2; ++cycle) {
    const Counters found = counters(scene, Predicates::kExact);
    EXPECT_EQ(3 * count, found.triangles);
    EXPECT_EQ(6U, found.rejected);
  }
  // Far from every partner its triangles are counted nevertheless.
  RigidTransform far;
  far.translation[0] = 1000;
  scene.setPose(off, far);
  scene.setPairEnabled(off, 0, true);
  EXPECT_EQ(12U, counters(scene, Predicates::kExact).rejected);
  const std::vector<RejectedTriangles> rejected = rejectedTriangles(scene);
  EXPECT_EQ(6U, rejected[0].count);
  EXPECT_EQ(0U, rejected[1].count);
  EXPECT_EQ(6U, rejected[off].count);
  EXPECT_FALSE(rejected[0].by_pose || rejected[off].by_pose);
}

TEST_P(CountersTest, APoseThatMakesVerticesInfiniteRejectsTheirTriangles) {
  Scene scene = pairScene(clothGrid(6, 1, 0, 0.1F), clothGrid(6, 1, 0.01F, -0.1F));
  const std::size_t count = scene.body(0).mesh.triangleCount();
  EXPECT_EQ(0U, counters(scene, Predicates::kExact).rejected);
  for (const double x : {1e39, -1e39, 1e300}) {
    RigidTransform pose;
    pose.translation[0] = x;
    scene.setPose(0, pose);
    // Boxes that grow by a margin end at the largest float32.
    for (const float margin_m : {0.F, 0.1F}) {
      scene.setMargin(0, margin_m);
      EXPECT_EQ(count, counters(scene, Predicates::kExact).rejected) << x << " " << margin_m;
    }
    EXPECT_TRUE(contacts(scene).empty());
    const std::vector<RejectedTriangles> rejected = rejectedTriangles(scene);
    EXPECT_EQ(count, rejected[0].count);
    EXPECT_TRUE(rejected[0].by_pose);
    EXPECT_EQ(0U, rejected[1].count);
  }
}

TEST_P(CountersTest, ExactIsPairsThatNoFilterDecides) {
  const Scene scene = coplanarAndCrossingPairs();
  ASSERT_EQ(static_cast<std::size_t>(kTouching + kCrossing), contacts(scene).size());
  const Counters found = counters(scene, Predicates::kExact);
  EXPECT_EQ(static_cast<std::uint64_t>(kTouching + kCrossing), found.candidates);
  EXPECT_EQ(static_cast<std::uint64_t>(kTouching), found.exact);
  EXPECT_EQ(0U, found.undecided);
}

TEST_P(CountersTest, UndecidedIsContactsThatNoFilterDecides) {
  Scene scene = coplanarAndCrossingPairs();
  // Apart, though a vertex of the first lies in the plane of the second and their boxes meet.
  const Triangle below{{{2, 1, 3}, {3, 0, 2}, {2, 0, 0}}};
  const BodyId first = scene.addBody("a vertex in its plane", meshOf({moved(kTilted, -100)}));
  const BodyId second = scene.addBody("below", meshOf({moved(below, -100)}));
  scene.setPairEnabled(first, second, true);
  Options options;
  options.predicates = Predicates::kConservative;
  const DetectionResult& result = detector_->detect(scene, options);
  EXPECT_EQ(static_cast<std::size_t>(kTouching + kCrossing), result.contacts.size());
  EXPECT_EQ(static_cast<std::uint64_t>(kTouching), result.counters.undecided);
  EXPECT_EQ(0U, result.counters.exact);
}

// Each backend decides for itself which pairs reach the predicates, but counts none twice.
TEST_P(CountersTest, ExactAndUndecidedAreAmongCandidatesAndContacts) {
  Scene scene;  // both in a plane that slopes, without a common vertex
  TriangleMesh mesh[2] = {clothGrid(12, 12, 0, 0), clothGrid(8, 12, 0, 0)};
  for (float& x : mesh[1].vertices) x += 0.25F;
  for (TriangleMesh& cloth : mesh) {
    for (std::size_t i = 0; i < cloth.vertices.size(); i += 3) {
      cloth.vertices[i + 2] = cloth.vertices[i] + 2 * cloth.vertices[i + 1];
    }
  }
  const BodyId lower = scene.addBody("lower", mesh[0]);
  const BodyId upper = scene.addBody("upper", mesh[1]);
  scene.setPairEnabled(lower, upper, true);
  const DetectionResult exact = detector_->detect(scene, Options());
  EXPECT_GT(exact.counters.exact, 40U);
  EXPECT_LE(exact.counters.exact, exact.counters.candidates);
  Options options;
  options.predicates = Predicates::kConservative;
  const DetectionResult& conservative = detector_->detect(scene, options);
  EXPECT_GT(conservative.counters.undecided, 40U);
  EXPECT_LE(conservative.counters.undecided, conservative.contacts.size());
}

INSTANTIATE_TEST_SUITE_P(, CountersTest, ::testing::ValuesIn(allBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
