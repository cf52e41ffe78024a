// A scene refuses what it cannot hold, by name, and stays as it was.
#include "core/scene.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "refusal.h"

namespace deformable_contact_monitor {
namespace {

TriangleMesh oneTriangle() { return {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2}}; }

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class SceneTest : public testing::Test {
 protected:
  Scene scene_;
  const BodyId cloth_ = scene_.addBody("cloth", oneTriangle());
  const BodyId hand_ = scene_.addBody("hand", oneTriangle());
};

TEST_F(SceneTest, RefusesMalformedMeshesByName) {
  TriangleMesh out_of_range = oneTriangle();
  out_of_range.triangles[2] = 3;
  TriangleMesh cut = oneTriangle();
  cut.vertices.pop_back();
  TriangleMesh uneven = oneTriangle();
  uneven.triangles.push_back(0);
  for (const TriangleMesh& mesh : {out_of_range, cut, uneven}) {
    EXPECT_TRUE(contains(refusal([&] { scene_.setMesh(cloth_, mesh); }), "cloth"));
    EXPECT_TRUE(contains(refusal([&] { scene_.addBody("rope", mesh); }), "rope"));
  }
  EXPECT_TRUE(contains(refusal([&] { scene_.setMesh(cloth_, out_of_range); }), "vertex 3"));
  EXPECT_EQ(scene_.bodyCount(), 2U);
  EXPECT_EQ(scene_.body(cloth_).mesh.triangles, oneTriangle().triangles);
}

TEST_F(SceneTest, RefusesVerticesOfAnotherMesh) {
  const float xyz[12] = {};
  EXPECT_TRUE(contains(refusal([&] { scene_.setVertices(cloth_, xyz, 4); }), "cloth"));
  EXPECT_EQ(refusal([&] { scene_.setVertices(cloth_, xyz, 3); }), "");
}

TEST_F(SceneTest, RefusesPosesAndMarginsThatAreNoNumbers) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    RigidTransform turned, moved;
    turned.rotation[4] = bad;
    moved.translation[2] = bad;
    EXPECT_TRUE(contains(refusal([&] { scene_.setPose(hand_, turned); }), "hand"));
    EXPECT_TRUE(contains(refusal([&] { scene_.setPose(hand_, moved); }), "hand"));
    EXPECT_TRUE(
        contains(refusal([&] { scene_.setMargin(hand_, static_cast<float>(bad)); }), "hand"));
  }
  EXPECT_TRUE(contains(refusal([&] { scene_.setMargin(hand_, -1); }), "hand"));
  EXPECT_TRUE(scene_.body(hand_).pose.isIdentity());
  EXPECT_NE(refusal([&] { scene_.setMargin(7, 0); }), "");
}

TEST_F(SceneTest, PairsAreOffAtFirstAndSymmetric) {
  EXPECT_FALSE(scene_.pairEnabled(cloth_, hand_));
  EXPECT_FALSE(scene_.pairEnabled(cloth_, cloth_));
  scene_.setPairEnabled(hand_, cloth_, true);
  EXPECT_TRUE(scene_.pairEnabled(cloth_, hand_));
  scene_.addBody("table", oneTriangle());
  EXPECT_TRUE(scene_.pairEnabled(hand_, cloth_));
  EXPECT_FALSE(scene_.pairEnabled(2, cloth_));
}

TEST_F(SceneTest, EnabledPairsAreListedOnceInOrder) {
  const BodyId rope = scene_.addBody("rope", oneTriangle());
  EXPECT_TRUE(scene_.enabledPairs().empty());
  scene_.setPairEnabled(rope, cloth_, true);
  scene_.setPairEnabled(hand_, hand_, true);
  scene_.setPairEnabled(cloth_, hand_, true);
  scene_.setPairEnabled(cloth_, hand_, false);
  const std::vector<std::pair<BodyId, BodyId>> expected = {{cloth_, rope}, {hand_, hand_}};
  EXPECT_EQ(scene_.enabledPairs(), expected);
}

TEST_F(SceneTest, RevisionsTellEveryStateApart) {
  Scene other;
  other.addBody("cloth", oneTriangle());
  EXPECT_NE(other.body(0).vertices_revision, scene_.body(cloth_).vertices_revision);
  const auto topology = scene_.body(cloth_).topology_revision;
  const auto vertices = scene_.body(cloth_).vertices_revision;
  scene_.setVertices(cloth_, oneTriangle().vertices.data(), 3);
  EXPECT_EQ(scene_.body(cloth_).topology_revision, topology);
  EXPECT_NE(scene_.body(cloth_).vertices_revision, vertices);
  scene_.setMesh(cloth_, oneTriangle());
  EXPECT_NE(scene_.body(cloth_).topology_revision, topology);
}

}  // namespace
}  // namespace deformable_contact_monitor
