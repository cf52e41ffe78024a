// Tests of the scene of a cycle: which bodies take part, their poses, and which pairs are on.
#include "monitor/cycle/monitor_scene.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <string>
#include <utility>
#include <vector>

namespace deformable_contact_monitor {
namespace {

constexpr BodyId kArm = 0, kHand = 1, kCloth = 2, kCable = 3;
constexpr std::size_t kClothObject = 0, kCableObject = 1;

MonitorParameters parameters() {
  MonitorParameters p;
  p.reference_frame = "base";
  p.objects = {{"cloth", "", 0.5F, true}, {"cable", "", 0, true}};
  p.objects[kCableObject].radius_m = 0.0625F;
  p.margin_m = 0.25F;
  p.link_margin_m = {{"hand", 0.125}};
  return p;
}

RobotGeometry robot() {
  RobotGeometry robot;
  for (const char* link : {"arm", "hand"}) {
    robot.links.push_back({link, "test", {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2}}, ""});
  }
  return robot;
}

class MonitorSceneTest : public ::testing::Test {
 protected:
  MonitorSceneTest() { scene_.setRobot(robot()); }

  void give(std::size_t object, double stamp_s, const std::string& frame = "base", float x = 0) {
    auto message = boost::make_shared<DeformableMesh>();
    message->header.stamp = ros::Time(stamp_s);
    message->header.frame_id = frame;
    message->topology_id = 3;
    message->vertices = {x, 0, 0, 1, 0, 0, 0, 1, 0};
    message->triangles = {0, 1, 2};
    IncomingMesh mesh{message};
    inputs_[object].store(mesh);
    inputs_[object].take(ros::Time(), &mesh);
  }

  void pose(const std::string& frame, double stamp_s, double x) {
    geometry_msgs::TransformStamped t;
    t.header.frame_id = "base";
    t.header.stamp = ros::Time(stamp_s);
    t.child_frame_id = frame;
    t.transform.translation.x = x;
    t.transform.rotation.w = 1;
    buffer_.setTransform(t, "test");
  }

  TransformReport prepare(double t_s, const CycleTrigger& trigger = {{kClothObject}, false}) {
    return scene_.prepare(ros::Time(t_s), trigger, inputs_, TransformLookup(buffer_, "base"));
  }

  std::string unknown(BodyId id) const { return scene_.bodies()[id].unknown_because; }
  bool on(BodyId a, BodyId b) const { return scene_.scene().pairEnabled(a, b); }

  MonitorParameters parameters_ = parameters();
  MeshInputs inputs_ = makeMeshInputs(parameters_);
  TransformBuffer buffer_;
  MonitorScene scene_{parameters_};
};

TEST_F(MonitorSceneTest, BodiesAreLinksThenObjectsWithTheirMargins) {
  ASSERT_EQ(scene_.bodies().size(), 4U);
  EXPECT_EQ(scene_.bodies()[kHand].name, "hand");
  EXPECT_EQ(scene_.bodies()[kCloth].kind, BodyKind::kDeformable);
  EXPECT_EQ(scene_.scene().body(kArm).margin_m, 0.25F);
  EXPECT_EQ(scene_.scene().body(kHand).margin_m, 0.125F);
  EXPECT_EQ(scene_.scene().body(kCloth).margin_m, 0.5F);
  EXPECT_EQ(scene_.scene().body(kCable).margin_m, 0.0F);
  EXPECT_EQ(scene_.scene().body(kCloth).radius_m, 0.0F);
  EXPECT_EQ(scene_.scene().body(kCable).radius_m, 0.0625F);
}

TEST_F(MonitorSceneTest, LinksAtTheStampObjectsAtTheirOwn) {
  for (const char* frame : {"arm", "hand", "camera"}) {
    pose(frame, 10, 0);
    pose(frame, 11, 10);
  }
  give(1, 10.1, "camera");
  give(0, 10.4, "camera");
  EXPECT_TRUE(prepare(10.4, {{kClothObject, kCableObject}, false}).misses.empty());
  const Scene& scene = scene_.scene();
  EXPECT_NEAR(scene.body(kArm).pose.translation[0], 4, 1e-9);
  EXPECT_NEAR(scene.body(kCloth).pose.translation[0], 4, 1e-9);
  EXPECT_NEAR(scene.body(kCable).pose.translation[0], 1, 1e-9);
  EXPECT_EQ(scene_.bodies()[kCable].stamp, ros::Time(10.1));
  EXPECT_EQ(scene_.bodies()[kArm].stamp, ros::Time(10.4));
  EXPECT_EQ(scene_.bodies()[kCloth].topology_id, 3U);
  EXPECT_TRUE(on(kArm, kCloth) && on(kHand, kCable));
  EXPECT_FALSE(on(kArm, kHand) || on(kCloth, kCable) || on(kCloth, kCloth));
}

TEST_F(MonitorSceneTest, AMeshInTheReferenceFrameIsUntouched) {
  pose("camera", 10, 5);
  pose("camera", 11, 5);
  give(0, 10, "camera");
  prepare(10);
  EXPECT_FALSE(scene_.scene().body(kCloth).pose.isIdentity());
  give(0, 10.1, "base", 0.1F);
  prepare(10.1);
  EXPECT_TRUE(scene_.scene().body(kCloth).pose.isIdentity());
  EXPECT_EQ(scene_.scene().body(kCloth).mesh.vertices[0], 0.1F);
}

TEST_F(MonitorSceneTest, AMissingTransformCostsThatLinkAlone) {
  pose("arm", 10, 0);
  give(0, 10);
  const TransformReport report = prepare(10);
  ASSERT_EQ(report.misses.size(), 1U);
  EXPECT_EQ(report.misses[0].body, "hand");
  EXPECT_EQ(unknown(kArm), "");
  EXPECT_NE(unknown(kHand), "");
  EXPECT_TRUE(scene_.bodies()[kHand].stamp.isZero());
  EXPECT_TRUE(on(kArm, kCloth));
  EXPECT_FALSE(on(kHand, kCloth));
  pose("hand", 10, 0);
  prepare(10);
  EXPECT_TRUE(on(kHand, kCloth));
}

TEST_F(MonitorSceneTest, ACycleIsOfThePairsOfItsObjects) {
  for (const char* link : {"arm", "hand"}) pose(link, 10, 0);
  give(0, 10);
  give(1, 10);
  prepare(10);
  EXPECT_TRUE(on(kArm, kCloth) && on(kHand, kCloth));
  EXPECT_FALSE(on(kArm, kCable));
  EXPECT_TRUE(scene_.bodies()[kCable].stamp.isZero()) << "it takes no part";
  EXPECT_TRUE(scene_.bodies()[kCloth].triggered && !scene_.bodies()[kCable].triggered);
  prepare(10, {{kCableObject}, false});
  EXPECT_TRUE(on(kArm, kCable) && !on(kArm, kCloth));
  prepare(10, {{kClothObject, kCableObject}, false});
  EXPECT_TRUE(on(kArm, kCable) && on(kArm, kCloth));
}

TEST_F(MonitorSceneTest, APartnerThatIsTooOldIsUnknownAndOff) {
  parameters_.pair_classes.deformable_deformable = true;
  scene_.setRobot(robot());
  give(0, 10);
  give(1, 10);
  prepare(10);
  EXPECT_TRUE(on(kCloth, kCable));
  give(0, 11);
  prepare(11);
  EXPECT_FALSE(on(kCloth, kCable));
  EXPECT_NE(unknown(kCable), "");
}

// Its newest mesh has a cycle of its own when its transform has come.
TEST_F(MonitorSceneTest, APartnerWhoseTransformIsLateIsWhereItWasBefore) {
  parameters_.pair_classes.deformable_deformable = true;
  scene_.setRobot(robot());
  for (const char* link : {"arm", "hand"}) pose(link, 10, 0);
  give(0, 10);
  give(1, 9.8, "camera");
  give(1, 9.9, "camera");
  pose("camera", 9.8, 3);
  EXPECT_TRUE(prepare(10).misses.empty());
  EXPECT_TRUE(on(kCloth, kCable));
  EXPECT_EQ(unknown(kCable), "");
  EXPECT_EQ(scene_.bodies()[kCable].stamp, ros::Time(9.8));
  EXPECT_EQ(scene_.scene().body(kCable).pose.translation[0], 3);
  EXPECT_EQ(prepare(10, {{kCableObject}, false}).misses.size(), 1U) << "in a cycle of its own";
  EXPECT_FALSE(on(kCloth, kCable));
  pose("camera", 9.9, 4);
  prepare(10);
  EXPECT_EQ(scene_.bodies()[kCable].stamp, ros::Time(9.9));
}

TEST_F(MonitorSceneTest, APartnerWhoseTransformWillNeverComeIsUnknown) {
  parameters_.pair_classes.deformable_deformable = true;
  scene_.setRobot(robot());
  for (const char* link : {"arm", "hand"}) pose(link, 10, 0);
  give(0, 10);
  give(1, 9.8, "camera");
  give(1, 9.9, "nowhere");
  pose("camera", 9.8, 3);
  prepare(10);
  EXPECT_FALSE(on(kCloth, kCable));
  EXPECT_NE(unknown(kCable).find("nowhere"), std::string::npos) << unknown(kCable);
}

TEST_F(MonitorSceneTest, TheRobotsOwnCycleIsOfItsLinks) {
  parameters_.pair_classes.robot_self = true;
  scene_.setRobot(robot());
  EXPECT_EQ(scene_.framesOfRobotCycle(), (std::vector<std::string>{"arm", "hand"}));
  for (const char* link : {"arm", "hand"}) pose(link, 10, 0);
  give(0, 10);
  prepare(10);
  EXPECT_FALSE(on(kArm, kHand)) << "it is the cloth's";
  prepare(10, {{}, true});
  EXPECT_TRUE(on(kArm, kHand));
  EXPECT_FALSE(on(kArm, kCloth));
  EXPECT_TRUE(scene_.bodies()[kArm].triggered && !scene_.bodies()[kCloth].triggered);
}

TEST_F(MonitorSceneTest, AnObjectWaitsForItsOwnFrameAndForLinksThatItMayTouch) {
  const auto awaited = [this](std::size_t object, double t_s) {
    std::vector<std::string> frames;
    std::string why_not;
    const IncomingMesh* const mesh = inputs_[object].newestAt(ros::Time(t_s), &why_not);
    for (const FrameAtStamp& f : scene_.awaitedFrames(object, ros::Time(t_s), *mesh)) {
      frames.push_back(f.frame + "@" + std::to_string(f.stamp.toSec()).substr(0, 4));
    }
    return frames;
  };
  using Frames = std::vector<std::string>;
  parameters_.pair_classes.deformable_deformable = true;
  scene_.setRobot(robot());
  give(0, 10, "camera");
  give(1, 10.4, "table");
  EXPECT_EQ(awaited(0, 10.4), (Frames{"camera@10.0", "arm@10.4", "hand@10.4"}));
  give(0, 10.4, "base");
  AllowedContact rule;
  rule.body_a = "arm";
  rule.body_b = "*";
  rule.allowed = true;
  AllowedContacts allowed;
  allowed.add(rule);
  scene_.setAllowedContacts(allowed);
  EXPECT_EQ(awaited(0, 10.4), Frames{"hand@10.4"});
  IncomingMesh rejected{boost::make_shared<DeformableMesh>(), "damaged"};
  EXPECT_TRUE(scene_.awaitedFrames(0, ros::Time(10.4), rejected).empty());
}

TEST_F(MonitorSceneTest, FramesOfLinksHaveThePrefix) {
  parameters_.frame_prefix = "left/";
  pose("left/arm", 10, 3);
  pose("hand", 10, 5);
  give(0, 10, "camera");
  pose("camera", 10, 0);
  prepare(10);
  EXPECT_EQ(scene_.scene().body(kArm).pose.translation[0], 3);
  EXPECT_EQ(unknown(kArm), "");
  EXPECT_EQ(unknown(kCloth), "") << "an object's frame gets no prefix";
  EXPECT_NE(unknown(kHand).find("TF frame 'left/hand' never seen"), std::string::npos);
  parameters_.pair_classes.robot_self = true;
  scene_.setRobot(robot());
  EXPECT_EQ(scene_.framesOfRobotCycle(), (std::vector<std::string>{"left/arm", "left/hand"}));
}

TEST_F(MonitorSceneTest, WithoutAKnownPartnerNoLinkIsPosed) {
  const TransformReport report = prepare(10);
  EXPECT_TRUE(report.misses.empty()) << "nobody asked for " << report.misses[0].body;
  EXPECT_EQ(unknown(kArm), "");
  EXPECT_NE(unknown(kCloth), "");
}

TEST_F(MonitorSceneTest, AllowedPairsAreOffAndTheirLinksNotPosed) {
  AllowedContact rule;
  rule.body_a = "arm";
  rule.body_b = "*";
  rule.allowed = true;
  AllowedContacts allowed;
  allowed.add(rule);
  scene_.setAllowedContacts(allowed);
  pose("hand", 10, 0);
  give(0, 10);
  EXPECT_TRUE(prepare(10).misses.empty());
  EXPECT_FALSE(on(kArm, kCloth));
  EXPECT_TRUE(on(kHand, kCloth));
}

TEST_F(MonitorSceneTest, LinksThatTheSrdfAllowsAreOffInTheRobotsOwnCycles) {
  parameters_.pair_classes.robot_self = true;
  RobotGeometry with_rules = robot();
  with_rules.links.push_back({"wrist", "test", with_rules.links[0].mesh, ""});
  with_rules.robots.resize(1);
  with_rules.robots[0].links = {"arm", "hand", "wrist"};
  with_rules.robots[0].srdf.disabled = {{"hand", "arm", "Adjacent"},
                                        {"hand", "cloth", "is no link"}};
  MonitorScene scene(parameters_);
  scene.setRobot(with_rules);
  EXPECT_EQ(scene.framesOfRobotCycle(), (std::vector<std::string>{"arm", "hand", "wrist"}));
  for (const char* link : {"arm", "hand", "wrist"}) pose(link, 10, 0);
  scene.prepare(ros::Time(10), {{}, true}, inputs_, TransformLookup(buffer_, "base"));
  EXPECT_EQ(scene.scene().enabledPairs(), (std::vector<std::pair<BodyId, BodyId>>{{0, 2}, {1, 2}}));
  scene.setRobot(robot());
  scene.prepare(ros::Time(10), {{}, true}, inputs_, TransformLookup(buffer_, "base"));
  EXPECT_TRUE(scene.scene().pairEnabled(0, 1)) << "a robot without an SRDF has no such rules";
}

TEST_F(MonitorSceneTest, ALinkMayTouchWhatItHolds) {
  for (const char* link : {"arm", "hand"}) pose(link, 10, 0);
  give(0, 10);
  scene_.setAttached({{"cloth", {{"hand"}}}});
  prepare(10);
  EXPECT_TRUE(on(kArm, kCloth));
  EXPECT_FALSE(on(kHand, kCloth));
  EXPECT_EQ(scene_.makeReport(ros::Time(10), 1).attached, scene_.rules().attached);
  scene_.setRobot(robot());
  prepare(10);
  EXPECT_FALSE(on(kHand, kCloth)) << "also of another robot with that link";
  scene_.setAttached({});
  prepare(10);
  EXPECT_TRUE(on(kHand, kCloth));
}

TEST_F(MonitorSceneTest, ANewMarginIsOfThoseWithoutOneOfTheirOwn) {
  parameters_.objects[kCableObject].shares_margin = true;
  const auto margins = [this] {
    std::vector<float> margins;
    for (const Body& body : scene_.scene().bodies()) margins.push_back(body.margin_m);
    return margins;
  };
  scene_.setMargin(2);
  EXPECT_EQ(margins(), (std::vector<float>{2, 0.125F, 0.5F, 2}));
  scene_.setRobot(robot());
  EXPECT_EQ(margins(), (std::vector<float>{2, 0.125F, 0.5F, 2})) << "also of another robot";
  scene_.setMargin(0);
  EXPECT_EQ(margins(), (std::vector<float>{0, 0.125F, 0.5F, 0}));
}

TEST_F(MonitorSceneTest, PairsOfAClassThatIsSwitchedOffAreOff) {
  for (const char* link : {"arm", "hand"}) pose(link, 10, 0);
  give(0, 10);
  give(1, 10);
  prepare(10);
  EXPECT_TRUE(on(kArm, kCloth));
  scene_.setPairClasses({false, true, false, false});
  prepare(10);
  EXPECT_EQ(scene_.scene().enabledPairs(),
            (std::vector<std::pair<BodyId, BodyId>>{{kCloth, kCable}}));
  EXPECT_EQ(scene_.bodies().size(), 4U) << "bodies keep their numbers";
  scene_.setPairClasses({true, false, false, false});
  prepare(10);
  EXPECT_EQ(scene_.scene().enabledPairs(),
            (std::vector<std::pair<BodyId, BodyId>>{{kArm, kCloth}, {kHand, kCloth}}));
}

TEST_F(MonitorSceneTest, ALinkWithoutGeometryIsUnknown) {
  RobotGeometry broken = robot();
  broken.links[0] = {"arm", "", {}, "file missing"};
  scene_.setRobot(broken);
  pose("arm", 10, 0);
  pose("hand", 10, 0);
  give(0, 10);
  prepare(10);
  EXPECT_EQ(unknown(kArm), "file missing");
  EXPECT_FALSE(on(kArm, kCloth));
  EXPECT_TRUE(on(kHand, kCloth));
}

TEST_F(MonitorSceneTest, WithoutARobotAStandInIsUnknown) {
  MonitorScene waiting(parameters_);  // no robot yet
  scene_.setRobot(RobotGeometry());   // a robot without geometry
  give(0, 10);
  for (MonitorScene* scene : {&waiting, &scene_}) {
    ASSERT_EQ(scene->bodies().size(), 3U);
    scene->prepare(ros::Time(10), {{kClothObject}, false}, inputs_,
                   TransformLookup(buffer_, "base"));
    EXPECT_EQ(scene->bodies()[0].name, "robot");
    EXPECT_NE(scene->bodies()[0].unknown_because, "");
    EXPECT_EQ(scene->pairs().size(), 2U);
    EXPECT_FALSE(scene->scene().pairEnabled(0, 1));
  }
}

TEST_F(MonitorSceneTest, RevisionsSayWhatChanged) {
  give(0, 10);
  prepare(10);
  const Body first = scene_.scene().body(kCloth);
  prepare(10);
  EXPECT_EQ(scene_.scene().body(kCloth).vertices_revision, first.vertices_revision);
  give(0, 10.1, "base", 0.5F);
  prepare(10.1);
  EXPECT_GT(scene_.scene().body(kCloth).vertices_revision, first.vertices_revision);
  EXPECT_EQ(scene_.scene().body(kCloth).topology_revision, first.topology_revision);
}

TEST_F(MonitorSceneTest, MarkUnknownGivesEachObjectItsReason) {
  scene_.markUnknown({"one", "two"});
  EXPECT_EQ(unknown(kArm), "");
  EXPECT_EQ(unknown(kCloth), "one");
  EXPECT_EQ(unknown(kCable), "two");
}

}  // namespace
}  // namespace deformable_contact_monitor
