// Tests the search for parts inside closed surfaces: single cases, changes from cycle to cycle, and
// time limits.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <limits>
#include <vector>

#include "containment_fixture.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

TEST_F(Containments, ACubeWithinACubeEitherWay) {
  EXPECT_EQ(inside(pairScene(cube(1, 1), cube(0, 3))), (Parts{{0, 1, 0}}));
  EXPECT_EQ(inside(pairScene(cube(0, 3), cube(1, 1))), (Parts{{1, 0, 0}}));
  EXPECT_EQ(inside(pairScene(cube(5, 1), cube(0, 3))), Parts());
  EXPECT_EQ(inside(pairScene(cube(0, 3), cube(0, 3))), Parts()) << "they touch";
  EXPECT_EQ(inside(pairScene(cube(0, 1), cube(0, 3))), Parts()) << "they touch";
}

TEST_F(Containments, TheCentroidIsTheMeanOfTheCorners) {
  const Scene scene = pairScene(box(1, 2, 3, 1, 1, 1), cube(0, 9));
  const Containment& found = find(scene);
  ASSERT_EQ(found.parts.size(), 1U);
  EXPECT_NEAR(found.parts[0].centroid.x, 1.5, 0.2);
  EXPECT_NEAR(found.parts[0].centroid.y, 2.5, 0.2);
  EXPECT_NEAR(found.parts[0].centroid.z, 3.5, 0.2);
}

TEST_F(Containments, ARayThroughVerticesAndAlongFacesIsDecided) {
  // Apexes above each other, faces and edges in one vertical plane.
  for (const float x : {0.25F, 0.5F, 1.0F}) {
    for (const float y : {0.25F, 0.5F, 1.0F}) {
      const Scene scene = pairScene(tetrahedron(x, y, 0.5F, 0.125F), cube(0, 2));
      EXPECT_EQ(inside(scene), (Parts{{0, 1, 0}})) << x << ", " << y;
    }
  }
}

TEST_F(Containments, AnOpenBoxHoldsNothingAndIsSaid) {
  TriangleMesh open = cube(0, 3);
  open.triangles.resize(open.triangles.size() - 3);
  const Scene scene = pairScene(cube(1, 1), open);
  const Containment& found = find(scene);
  EXPECT_TRUE(found.parts.empty());
  EXPECT_EQ(found.bodies[0].open, 0U);
  EXPECT_EQ(found.bodies[1].open, 1U);
  EXPECT_EQ(found.bodies[1].all, 1U);
  EXPECT_TRUE(found.bodies[1].looked_at);
}

TEST_F(Containments, AClosedComponentHoldsBesideAnOpenOne) {
  const Scene scene = pairScene(cube(1, 1), together(clothGrid(2, 1, 9, 0), cube(0, 3)));
  EXPECT_EQ(inside(scene), (Parts{{0, 1, 0}}));
  EXPECT_EQ(find(scene).bodies[1].open, 1U);
  EXPECT_EQ(find(scene).bodies[1].all, 2U);
}

TEST_F(Containments, EachPartByItself) {
  const TriangleMesh parts = together(together(cube(-5, 1), cube(1, 1)), cube(2.5F, 1));
  const Scene scene = pairScene(parts, cube(0, 3));  // outside, within, through a wall
  EXPECT_EQ(inside(scene), (Parts{{0, 1, 12}}));
}

// Each of two shells is a closed component of its own: what is in both is inside.
TEST_F(Containments, NestedShellsEachCount) {
  const Scene scene = pairScene(cube(3, 1), together(cube(0, 9), cube(2, 3)));
  EXPECT_EQ(inside(scene), (Parts{{0, 1, 0}}));
}

TEST_F(Containments, ClothsAndSoupsAreWithin) {
  EXPECT_EQ(inside(pairScene(clothGrid(4, 1, 1, 0.1F), cube(-1, 5))), (Parts{{0, 1, 0}}));
  Scene scene = pairScene(soupOf(cube(1, 1)), soupOf(cube(0, 3)));
  EXPECT_EQ(inside(scene), (Parts{{0, 1, 0}}));
}

TEST_F(Containments, ARejectedVertexOpensItsComponentAlone) {
  TriangleMesh broken = cube(0, 3);
  broken.vertices[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(inside(pairScene(cube(1, 1), broken)), Parts());
  EXPECT_EQ(inside(pairScene(cube(1, 1), together(broken, cube(-1, 5)))), (Parts{{0, 1, 0}}));
  // One that only hangs on an edge, too: who knows what it closes, or leaves open.
  TriangleMesh fin = cube(0, 3);
  fin.vertices.insert(fin.vertices.end(), 3, std::numeric_limits<float>::quiet_NaN());
  fin.triangles.insert(fin.triangles.end(), {0, 1, 24});
  EXPECT_EQ(inside(pairScene(cube(1, 1), fin)), Parts());
  // A part with a rejected vertex is still reported as inside: its other triangles are.
  TriangleMesh part = cube(1, 1);
  part.vertices[0] = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(inside(pairScene(part, cube(0, 3))).empty());
}

TEST_F(Containments, FarAwayAndTiny) {
  for (const float scale : {1e-44F, 1e-30F, 1e20F, 1e37F}) {
    EXPECT_EQ(inside(pairScene(cube(2 * scale, scale), cube(0, 8 * scale))), (Parts{{0, 1, 0}}))
        << scale;
  }
  EXPECT_EQ(inside(pairScene(cube(1e7F + 2, 1), cube(1e7F, 8))), (Parts{{0, 1, 0}}));
  EXPECT_EQ(inside(pairScene(cube(1, 1), cube(-1e38F, 2e38F))), (Parts{{0, 1, 0}}));
}

TEST_F(Containments, PosesCountAndInfiniteOnesHoldNothing) {
  Scene scene = pairScene(cube(0, 1), cube(0, 3));
  RigidTransform pose;
  pose.translation[0] = pose.translation[1] = pose.translation[2] = 1;
  scene.setPose(0, pose);
  EXPECT_EQ(inside(scene), (Parts{{0, 1, 0}}));
  pose.translation[0] = 10;
  scene.setPose(0, pose);
  EXPECT_EQ(inside(scene), Parts());
  pose.translation[0] = 1e300;
  scene.setPose(0, pose);
  EXPECT_EQ(inside(scene), Parts());
}

TEST_F(Containments, OnlyEnabledPairsAreLookedAt) {
  Scene scene = pairScene(cube(1, 1), cube(0, 3));
  scene.setPairEnabled(0, 1, false);
  EXPECT_EQ(inside(scene), Parts());
  EXPECT_FALSE(find(scene).bodies[0].looked_at);
}

// The mesh changes from cycle to cycle: its vertices, which of them are equal, its triangles.
TEST_F(Containments, FollowsChanges) {
  Scene scene = pairScene(cube(1, 1), cube(0, 3));
  EXPECT_EQ(inside(scene).size(), 1U);
  std::vector<float> moved = cube(5, 1).vertices;
  scene.setVertices(0, moved.data(), moved.size() / 3);
  EXPECT_EQ(inside(scene).size(), 0U);
  moved = cube(0.5F, 1).vertices;
  scene.setVertices(0, moved.data(), moved.size() / 3);
  EXPECT_EQ(inside(scene).size(), 1U);
  std::vector<float> torn = cube(0, 3).vertices;
  torn[0] += 0.125F;  // one corner of one square
  scene.setVertices(1, torn.data(), torn.size() / 3);
  EXPECT_EQ(inside(scene).size(), 0U);
  EXPECT_EQ(find(scene).bodies[1].open, 1U);
  scene.setMesh(1, cube(0, 3));
  EXPECT_EQ(inside(scene).size(), 1U);
}

TEST_F(Containments, ALimitThatIsOverIsSaid) {
  const Scene scene = pairScene(cube(1, 1), cube(0, 3));
  const std::atomic<bool> stop{true};
  Limits limits;
  limits.stop = &stop;
  const DetectionResult& result = detector_->detect(scene, Options());
  EXPECT_EQ(finder_.find(scene, result, CycleLimit(limits)).cut_off_because, "stopped");
  EXPECT_EQ(inside(scene).size(), 1U) << "the next cycle is as any";
  EXPECT_EQ(find(scene).cut_off_because, "");
}

// Many small parts in one large surface of many triangles: a bound for what
// would take minutes, were each part held against each triangle.
TEST_F(Containments, ManyPartsInOneSurface) {
  TriangleMesh parts;
  constexpr int kSide = 46;  // 97 336 of them
  for (int i = 0; i < kSide * kSide * kSide; ++i) {
    append(tetrahedron(static_cast<float>(i % kSide), static_cast<float>(i / kSide % kSide),
                       static_cast<float>(i / kSide / kSide), 0.25F),
           &parts);
  }
  TriangleMesh fine = cube(-10, 70);
  for (int k = 0; k < 4; ++k) fine = splitThreeByThree(fine);  // 78 732 triangles
  Scene scene;
  const BodyId a = scene.addBody("parts", parts), b = scene.addBody("shell", fine);
  scene.setPairEnabled(a, b, true);
  DetectionResult none;
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(finder_.find(scene, none, noLimit()).parts.size(), std::size_t{97336});
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60));
}

}  // namespace
}  // namespace deformable_contact_monitor
