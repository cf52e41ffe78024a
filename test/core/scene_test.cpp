// A scene refuses what it cannot hold, by name, and stays as it was.
#include "core/scene.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory_resource>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

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

TEST_F(SceneTest, TakesPartsOfAllTrianglesOnly) {
  scene_.setParts(cloth_, {7});
  EXPECT_EQ((std::vector<PartId>{7}), scene_.body(cloth_).listed_parts);
  const std::string why = refusal([&] { scene_.setParts(cloth_, {1, 2}); });
  EXPECT_TRUE(contains(why, "cloth: parts are given for 2 triangles, but its mesh has 1")) << why;
  EXPECT_EQ((std::vector<PartId>{7}), scene_.body(cloth_).parts);
  EXPECT_TRUE(contains(refusal([&] { scene_.setParts(9, {}); }), "body 9"));
  scene_.setMesh(cloth_, oneTriangle());
  EXPECT_TRUE(scene_.body(cloth_).parts.empty());
  EXPECT_EQ((std::vector<PartId>{0}), scene_.body(cloth_).listed_parts);
}

TEST_F(SceneTest, EnablesPartsAsTheirBodiesAreUnlessTheyAreDisabled) {
  scene_.setParts(cloth_, {7});
  EXPECT_FALSE(scene_.partPairEnabled(cloth_, 7, hand_, 0));
  scene_.setPairEnabled(cloth_, hand_, true);
  EXPECT_TRUE(scene_.partPairEnabled(cloth_, 7, hand_, 0));
  EXPECT_TRUE(scene_.partPairEnabled(cloth_, 8, hand_, 0));
  EXPECT_FALSE(scene_.partsMatter());
  const std::uint64_t before = scene_.pairsRevision();
  scene_.setPartPairEnabled(hand_, 0, cloth_, 8, false);
  EXPECT_NE(before, scene_.pairsRevision());
  EXPECT_FALSE(scene_.partPairEnabled(cloth_, 8, hand_, 0));
  EXPECT_FALSE(scene_.partsMatter()) << "no triangle has this part";
  scene_.setPartPairEnabled(hand_, 0, cloth_, 7, false);
  EXPECT_FALSE(scene_.partPairEnabled(cloth_, 7, hand_, 0));
  EXPECT_TRUE(scene_.partsMatter());
  EXPECT_EQ(2U, scene_.disabledParts().size());
  scene_.setPartPairEnabled(cloth_, 7, hand_, 0, true);
  EXPECT_TRUE(scene_.partPairEnabled(hand_, 0, cloth_, 7));
  EXPECT_FALSE(scene_.partsMatter());
  scene_.enableAllParts();
  EXPECT_TRUE(scene_.partPairEnabled(hand_, 0, cloth_, 8));
  const std::string why = refusal([&] { scene_.setPartPairEnabled(cloth_, 1, 9, 1, false); });
  EXPECT_TRUE(contains(why, "body 9")) << why;
}

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

TEST_F(SceneTest, RefusesEarlierStatesThatDoNotFit) {
  const std::vector<float> fitting = {0, 0, 1, 1, 0, 1, 0, 1, 1};
  const auto refused = [&](const RigidTransform& pose, std::vector<float> vertices) {
    std::string text = refusal([&] { scene_.setEarlier(cloth_, pose, vertices); });
    EXPECT_TRUE(contains(text, "cloth: ")) << text;
    EXPECT_FALSE(scene_.body(cloth_).earlier);
    return text;
  };
  EXPECT_TRUE(contains(refused({}, std::vector<float>(12)), "4 vertices"));
  EXPECT_TRUE(contains(refused({}, std::vector<float>(6)), "mesh with 3"));
  EXPECT_TRUE(contains(refused({}, std::vector<float>(10)), "10 earlier coordinates"));
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    RigidTransform turned, moved;
    turned.rotation[8] = bad;
    moved.translation[0] = bad;
    EXPECT_TRUE(contains(refused(turned, fitting), "non-finite"));
    EXPECT_TRUE(contains(refused(moved, {}), "non-finite"));
  }
  EXPECT_NE(refusal([&] { scene_.setEarlier(7, {}); }), "");
  EXPECT_NE(refusal([&] { scene_.clearEarlier(7); }), "");
  // A rejected state leaves the earlier one in place.
  EXPECT_EQ(refusal([&] { scene_.setEarlier(cloth_, {}, fitting); }), "");
  EXPECT_NE(refusal([&] { scene_.setEarlier(cloth_, {}, std::vector<float>(12)); }), "");
  ASSERT_TRUE(scene_.body(cloth_).earlier);
  EXPECT_EQ(scene_.body(cloth_).earlier->vertices, fitting);
  // Places that are no numbers are data, as those of vertices are.
  const std::vector<float> none(9, std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(refusal([&] { scene_.setEarlier(cloth_, {}, none); }), "");
}

TEST_F(SceneTest, AnEarlierStateStaysUntilItIsClearedOrTrianglesChange) {
  EXPECT_FALSE(scene_.body(cloth_).earlier);
  RigidTransform pose;
  pose.translation[1] = 2;
  scene_.setEarlier(cloth_, pose);
  ASSERT_TRUE(scene_.body(cloth_).earlier);
  EXPECT_EQ(scene_.body(cloth_).earlier->pose.translation[1], 2);
  EXPECT_TRUE(scene_.body(cloth_).earlier->vertices.empty());
  EXPECT_FALSE(scene_.body(hand_).earlier);
  scene_.setPose(cloth_, RigidTransform());
  scene_.setVertices(cloth_, oneTriangle().vertices.data(), 3);
  scene_.setPairEnabled(cloth_, hand_, true);
  EXPECT_TRUE(scene_.body(cloth_).earlier);
  scene_.clearEarlier(cloth_);
  EXPECT_FALSE(scene_.body(cloth_).earlier);
  EXPECT_EQ(refusal([&] { scene_.clearEarlier(cloth_); }), "");
  scene_.setEarlier(cloth_, pose);
  scene_.setMesh(cloth_, oneTriangle());
  EXPECT_FALSE(scene_.body(cloth_).earlier);
}

TEST_F(SceneTest, RevisionsTellEarlierVerticesApart) {
  scene_.setEarlier(cloth_, RigidTransform(), oneTriangle().vertices);
  scene_.setEarlier(hand_, RigidTransform(), oneTriangle().vertices);
  const auto first = scene_.body(cloth_).earlier_revision;
  const auto vertices = scene_.body(cloth_).vertices_revision;
  EXPECT_NE(first, scene_.body(hand_).earlier_revision);
  scene_.setEarlier(cloth_, RigidTransform(), oneTriangle().vertices);
  EXPECT_GT(scene_.body(cloth_).earlier_revision, first);
  EXPECT_EQ(scene_.body(cloth_).vertices_revision, vertices);
}

TEST_F(SceneTest, PadsAreFiniteAndCountForBodiesThatTakePart) {
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float bad : {-1.0F, infinity, std::numeric_limits<float>::quiet_NaN()}) {
    EXPECT_TRUE(contains(refusal([&] { scene_.setPad(hand_, bad); }), "hand: pad"));
  }
  EXPECT_EQ(scene_.body(hand_).pad_m, 0);
  EXPECT_NE(refusal([&] { scene_.setPad(7, 0); }), "");
  scene_.setPad(hand_, 0.5F);
  EXPECT_EQ(scene_.body(hand_).pad_m, 0.5F);
  EXPECT_FALSE(scene_.anyPad());
  scene_.setPairEnabled(cloth_, hand_, true);
  EXPECT_TRUE(scene_.anyPad());
  EXPECT_FALSE(scene_.anyMargin());
  scene_.setPad(hand_, 0);
  EXPECT_FALSE(scene_.anyPad());
}

// Counts what is in use.
class CountedMemory : public std::pmr::memory_resource {
 public:
  std::size_t bytes = 0, most = std::numeric_limits<std::size_t>::max();

 private:
  void* do_allocate(std::size_t size, std::size_t alignment) override {
    if (size > most - bytes) throw std::bad_alloc();
    bytes += size;
    return std::pmr::new_delete_resource()->allocate(size, alignment);
  }
  void do_deallocate(void* memory, std::size_t size, std::size_t alignment) override {
    bytes -= size;
    std::pmr::new_delete_resource()->deallocate(memory, size, alignment);
  }
  bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override {
    return this == &other;
  }
};

TEST(SceneMemory, MeshesLieWhereTheyAreWantedAndCopiesDoNot) {
  constexpr std::size_t kMesh = 9 * sizeof(float) + 3 * sizeof(std::uint32_t);
  CountedMemory memory;
  Scene scene;
  scene.addBody("before", oneTriangle());
  scene.useMemory(memory);
  EXPECT_EQ(kMesh, memory.bytes);
  const BodyId after = scene.addBody("after", oneTriangle());
  EXPECT_EQ(2 * kMesh, memory.bytes);
  const float* const place = scene.body(after).mesh.vertices.data();
  const std::vector<float> moved(9, 2.0F);
  scene.setVertices(after, moved.data(), 3);
  EXPECT_EQ(place, scene.body(after).mesh.vertices.data());
  {
    Scene copy = scene;
    copy.addBody("of the copy", oneTriangle());
    EXPECT_EQ(2 * kMesh, memory.bytes);
    Scene assigned;
    assigned = scene;
    assigned.addBody("of the copy", oneTriangle());
    EXPECT_EQ(2 * kMesh, memory.bytes);
    EXPECT_TRUE(copy.body(after).mesh.vertices == moved);
    scene.setMesh(after, TriangleMesh());
    EXPECT_TRUE(copy.body(after).mesh.vertices == moved);
  }
  scene.setMesh(after, oneTriangle());
  for (int i = 0; i < 9; ++i) scene.addBody("more", oneTriangle());
  EXPECT_EQ(11 * kMesh, memory.bytes);
  scene = Scene();
  EXPECT_EQ(0U, memory.bytes);
}

// A mesh of so many triangles, none of which has a vertex of another.
TriangleMesh apart(std::uint32_t triangles) {
  TriangleMesh mesh;
  mesh.vertices.resize(9 * std::size_t{triangles});
  for (std::uint32_t i = 0; i < 3 * triangles; ++i) mesh.triangles.push_back(i);
  return mesh;
}

TEST(SceneMemory, AMeshThatGrowsSeldomTakesMore) {
  CountedMemory memory;
  Scene scene;
  scene.useMemory(memory);
  const BodyId body = scene.addBody("grows", apart(1000));
  int times = 0;
  for (std::uint32_t triangles = 1001; triangles <= 2000; ++triangles) {
    const std::size_t before = memory.bytes;
    scene.setMesh(body, apart(triangles));
    ASSERT_EQ(triangles, scene.body(body).mesh.triangleCount());
    ASSERT_TRUE(scene.body(body).mesh.triangles == apart(triangles).triangles);
    times += memory.bytes != before ? 1 : 0;
  }
  EXPECT_GE(times, 1);
  EXPECT_LE(times, 4);
}

TEST(SceneMemory, WithoutMemoryForAMeshTheOldOneStays) {
  for (const std::size_t more : {0, 1000, 9000}) {  // the last has room for the vertices
    CountedMemory memory;
    Scene scene;
    scene.useMemory(memory);
    const BodyId body = scene.addBody("grows", apart(10));
    const std::uint64_t before = scene.body(body).topology_revision;
    memory.most = memory.bytes + more;
    EXPECT_THROW(scene.setMesh(body, apart(200)), std::bad_alloc);
    EXPECT_TRUE(scene.body(body).mesh.vertices == apart(10).vertices);
    EXPECT_TRUE(scene.body(body).mesh.triangles == apart(10).triangles);
    EXPECT_EQ(before, scene.body(body).topology_revision);
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
