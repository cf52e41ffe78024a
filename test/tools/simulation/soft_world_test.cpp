// Tests of soft objects that Bullet simulates.
#include "tools/simulation/soft_world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/cpu_detector.h"
#include "core/scene.h"

namespace deformable_contact_monitor {
namespace {

constexpr double kFrame = 1 / 30.;  // [s]
constexpr double kBall = 0.15;      // radius of the link [m]

SoftShapeOptions options(const std::string& object = "cloth") {
  SoftShapeOptions o;
  o.object = object;
  o.vertices = object == "rope" ? 40 : 441;  // 20 cells along each edge
  o.offset = {0.5, 0, 1};
  return o;
}

// A ball whose vertices lie on the sphere.
TriangleMesh ball() {
  SoftShapeOptions o = options("volume");
  o.vertices = 200;
  o.size_m = 2 * kBall;
  o.offset = Eigen::Vector3d::Zero();
  const SoftShape shape = softShape(o);
  TriangleMesh mesh;
  for (const Eigen::Vector3d& node : shape.nodes) {
    const Eigen::Vector3d p = kBall * node.normalized();
    for (int i = 0; i < 3; ++i) mesh.vertices.push_back(static_cast<float>(p[i]));
  }
  mesh.triangles.assign(shape.triangles.begin(), shape.triangles.end());
  return mesh;
}

std::vector<Eigen::Vector3d> vertices(const SoftWorld& world) {
  const TriangleMesh mesh = world.mesh();
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
    points.emplace_back(mesh.vertices[i], mesh.vertices[i + 1], mesh.vertices[i + 2]);
  }
  return points;
}

// Returns poses that put every link there.
LinkPose allAt(const Eigen::Vector3d& place) {
  return [place](const std::string& /*link*/) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translate(place);
    return std::optional(pose);
  };
}

LinkPose nowhere() {
  return [](const std::string& /*link*/) { return std::nullopt; };
}

// Where the ball is below the sheet; it moves up and down.
Eigen::Vector3d below(double time_s) { return {0, 0, 0.7 + 0.15 * std::sin(2 * time_s)}; }

std::unique_ptr<SoftWorld> world(const SoftShapeOptions& o, SoftWorldOptions how = {}) {
  auto made = std::make_unique<SoftWorld>(softShape(o), how);
  made->addLink("ball", ball());
  return made;
}

TEST(SoftWorldTest, theSeedDecidesEverything) {
  SoftShapeOptions differently = options();
  differently.seed = 2;
  const auto one = world(options()), same = world(options()), other = world(differently);
  for (int frame = 0; frame < 60; ++frame) {
    for (const auto& each : {&one, &same, &other}) {
      EXPECT_EQ((*each)->advance(kFrame, allAt(below(frame * kFrame))).problem, "");
    }
    ASSERT_EQ(one->mesh().vertices, same->mesh().vertices) << frame;
  }
  EXPECT_NE(one->mesh().vertices, other->mesh().vertices);
}

TEST(SoftWorldTest, fallsButHangsOnByWhatIsPinned) {
  for (const char* object : {"cloth", "rope"}) {
    for (const char* pinned : {"edge", "corners"}) {
      SoftShapeOptions o = options(object);
      o.pinned = pinned;
      const auto hanging = world(o);
      const auto start = vertices(*hanging);
      for (int frame = 0; frame < 120; ++frame) {
        ASSERT_EQ(hanging->advance(kFrame, nowhere()).problem, "");
      }
      const auto end = vertices(*hanging);
      EXPECT_GE(hanging->shape().pinned.size(), 1U);
      for (const std::uint32_t node : hanging->shape().pinned) EXPECT_EQ(end[node], start[node]);
      EXPECT_LT(hanging->stretch(), 1.2) << object << pinned;
      double lowest = 1;
      for (const Eigen::Vector3d& p : end) lowest = std::min(lowest, p.z());
      EXPECT_LT(lowest, 0.95) << object << pinned;
      EXPECT_GT(lowest, -0.3) << object << pinned;
    }
  }
}

// The exact distance of the ball's surface from the sheet would be 0 both where they touch and
// where they cross, so the depth of the vertices is what is measured.
TEST(SoftWorldTest, aLinkPushesTheCloth) {
  const auto pushed = world(options()), free = world(options());
  std::size_t contacts = 0;
  for (int frame = 0; frame < 150; ++frame) {
    const Eigen::Vector3d middle = below(frame * kFrame);
    ASSERT_EQ(pushed->advance(kFrame, allAt(middle)).problem, "");
    ASSERT_EQ(free->advance(kFrame, nowhere()).problem, "");
    for (const Eigen::Vector3d& p : vertices(*pushed)) {
      ASSERT_GT((p - middle).norm(), kBall - 0.01) << "frame " << frame;
    }
    contacts += pushed->contacts().size();
    for (const SoftContact& contact : pushed->contacts()) ASSERT_EQ(contact.link, "ball");
    ASSERT_TRUE(free->contacts().empty());
  }
  EXPECT_GT(contacts, 150U);
  EXPECT_NE(pushed->mesh().vertices, free->mesh().vertices);
}

TEST(SoftWorldTest, theExactDetectorFindsTheTouch) {
  const auto pushed = world(options());
  Eigen::Vector3d middle;
  for (int frame = 0; frame < 60; ++frame) {
    middle = below(frame * kFrame);
    pushed->advance(kFrame, allAt(middle));
  }
  TriangleMesh link = ball();
  for (std::size_t i = 0; i < link.vertices.size(); ++i) {
    link.vertices[i] += static_cast<float>(middle[static_cast<Eigen::Index>(i % 3)]);
  }
  Scene scene;
  scene.addBody("ball", link);
  scene.addBody("cloth", pushed->mesh());
  scene.setPairEnabled(0, 1, true);
  EXPECT_GT(makeCpuDetector()->detect(scene).contacts.size(), 10U);
}

TEST(SoftWorldTest, anExplosionIsUndone) {
  const auto struck = world(options());
  for (int frame = 0; frame < 30; ++frame) struck->advance(kFrame, allAt({0, 0, 5}));
  const std::vector<Eigen::Vector3d> start = vertices(*struck);
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : start) middle += p / static_cast<double>(start.size());
  // The ball arrives in the middle of the sheet at 1 km/s.
  struck->advance(kFrame, allAt(middle + Eigen::Vector3d(33, 0, 0)));
  const auto before = struck->mesh().vertices;
  const Advance advance = struck->advance(kFrame, allAt(middle));
  EXPECT_NE(advance.problem.find("would move at"), std::string::npos) << advance.problem;
  EXPECT_FALSE(advance.restarted);
  EXPECT_EQ(struck->mesh().vertices, before);
  // It goes on from there.
  for (int frame = 0; frame < 60; ++frame) {
    ASSERT_EQ(struck->advance(kFrame, allAt(middle + Eigen::Vector3d(0, 0, 3))).problem, "");
  }
  EXPECT_NE(struck->mesh().vertices, before);
  EXPECT_LT(struck->stretch(), 1.2);
}

TEST(SoftWorldTest, startsAnewAfterTenExplosionsInARow) {
  const auto struck = world(options());
  const auto start = struck->mesh().vertices;
  const Eigen::Vector3d hem(-0.5, 0, 1.1);
  struck->advance(kFrame / 100, allAt(hem));
  ASSERT_GT(struck->hold({"ball"}, 0.08), 0U);
  // What holds the sheet by its hem flies up and down.
  int undone = 0;
  for (int frame = 0; frame < 100; ++frame) {
    const Eigen::Vector3d up(0, 0, frame % 2 == 0 ? 8 : 0);
    const Advance advance = struck->advance(kFrame, allAt(hem + up));
    undone = advance.problem.empty() ? 0 : undone + 1;
    ASSERT_EQ(advance.restarted, undone == 10);
    for (const Eigen::Vector3d& p : vertices(*struck)) ASSERT_LT(p.norm(), 20);
    if (!advance.restarted) continue;
    EXPECT_EQ(struck->mesh().vertices, start);
    EXPECT_EQ(struck->heldTriangles(), 0U);
    return;
  }
  ADD_FAILURE() << "no ten explosions in a row";
}

TEST(SoftWorldTest, startsAnewWhenItHasFallenFarAway) {
  SoftShapeOptions o = options();
  o.pinned = "none";
  const auto falling = world(o);
  const auto start = falling->mesh().vertices;
  for (int frame = 0; frame < 300; ++frame) {
    const Advance advance = falling->advance(kFrame, nowhere());
    ASSERT_EQ(advance.restarted, !advance.problem.empty());
    if (!advance.restarted) continue;
    EXPECT_NE(advance.problem.find("m away"), std::string::npos) << advance.problem;
    EXPECT_EQ(falling->mesh().vertices, start);
    return;
  }
  ADD_FAILURE() << "it did not start anew";
}

TEST(SoftWorldTest, aPoseThatIsNotFiniteLeavesTheLinkWhereItWas) {
  const auto calm = world(options());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int frame = 0; frame < 60; ++frame) {
    const bool is_bad = frame % 3 == 1;
    EXPECT_EQ(calm->advance(kFrame, allAt({is_bad ? nan : 0, 0, 0.7})).problem, "");
    ASSERT_TRUE(frame < 30 || !calm->contacts().empty()) << frame;
  }
}

TEST(SoftWorldTest, whatALinkHoldsFollowsIt) {
  const auto held = world(options());
  const Eigen::Vector3d hem(-0.5, 0, 1);                           // the edge that is not pinned
  EXPECT_THROW(held->hold({"ball"}, 0.1), std::invalid_argument);  // its pose is not known
  held->advance(kFrame / 100, allAt(hem + Eigen::Vector3d(0, 0, 0.2)));
  EXPECT_THROW(held->hold({"hand"}, 0.1), std::invalid_argument);
  EXPECT_EQ(held->hold({"ball"}, 0.001), 0U);
  const std::size_t count = held->hold({"ball"}, 0.08);
  EXPECT_GT(count, 2U);
  EXPECT_GT(held->heldTriangles(), 2U);
  const std::size_t corner = 20 * 21 + 10;  // the middle of the hem
  const Eigen::Vector3d from = vertices(*held)[corner];
  for (int frame = 0; frame <= 90; ++frame) {
    const Eigen::Vector3d way(0.004 * frame, 0, 0);
    held->advance(kFrame, allAt(hem + Eigen::Vector3d(0, 0, 0.2) + way));
    ASSERT_NEAR((vertices(*held)[corner] - from - way).norm(), 0, 1e-5) << frame;
  }
  held->release();
  EXPECT_EQ(held->heldTriangles(), 0U);
  for (int frame = 0; frame < 30; ++frame) held->advance(kFrame, allAt({0, 0, 5}));
  EXPECT_LT(vertices(*held)[corner].z(), from.z() - 0.1);
}

TEST(SoftWorldTest, aVolumeRestsOnTheFloorAndKeepsItsShape) {
  SoftShapeOptions o = options("volume");
  o.pinned = "none";
  o.size_m = 0.4;
  const auto resting = world(o);
  resting->addFloor(0.5);
  for (int frame = 0; frame < 120; ++frame) {
    ASSERT_EQ(resting->advance(kFrame, nowhere()).problem, "");
  }
  double low = 9, high = -9;
  for (const Eigen::Vector3d& p : vertices(*resting)) {
    low = std::min(low, p.z());
    high = std::max(high, p.z());
  }
  EXPECT_NEAR(low, 0.5, 0.01);
  EXPECT_GT(high - low, 0.2);
  EXPECT_LT(high - low, 0.45);
}

TEST(SoftShapeTest, readsFilesAndTellsClosedSurfaces) {
  const std::string path = ::testing::TempDir() + "dcm_soft_shape.obj";
  std::ofstream(path) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 0 0\nf 1 3 2\nf 5 2 4\n";
  SoftShapeOptions o = options(path);
  o.size_m = 2;
  const SoftShape open = softShape(o);
  EXPECT_FALSE(open.is_volume);
  ASSERT_EQ(open.nodes.size(), 4U);  // two vertices are at one place
  EXPECT_EQ(open.node_of_vertex.size(), 5U);
  EXPECT_EQ(open.nodes[1], Eigen::Vector3d(2.5, 0, 1));
  EXPECT_EQ(open.pinned, (std::vector<std::uint32_t>{3}));  // the highest
  std::ofstream(path) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                         "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
  EXPECT_TRUE(softShape(o).is_volume);
  EXPECT_TRUE(softShape(options("volume")).is_volume);
  EXPECT_FALSE(softShape(options("cloth")).is_volume);
}

TEST(SoftShapeTest, refusesWhatMakesNoObject) {
  for (const double size : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(),
                            std::numeric_limits<double>::infinity()}) {
    SoftShapeOptions o = options();
    o.size_m = size;
    EXPECT_THROW(softShape(o), std::invalid_argument) << size;
    SoftWorldOptions how;
    how.step_s = size;
    EXPECT_THROW(SoftWorld(softShape(options()), how), std::invalid_argument) << size;
  }
  SoftShapeOptions o = options("volume");
  o.pinned = "corners";
  EXPECT_THROW(softShape(o), std::invalid_argument);
  o.pinned = "all";
  EXPECT_THROW(softShape(o), std::invalid_argument);
  EXPECT_THROW(softShape(options("no_such_file.obj")), std::runtime_error);
}

}  // namespace
}  // namespace deformable_contact_monitor
