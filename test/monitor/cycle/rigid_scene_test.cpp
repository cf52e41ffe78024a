// Tests rigid objects in the detection loop: their poses, what they cost, who carries them, and how
// they move in swept motion.
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/cpu_detector.h"
#include "monitor/cycle/held_part.h"
#include "monitor/state/contact_state_tracker.h"
#include "steps_fixture.h"

namespace deformable_contact_monitor {
namespace {

// A cloth of one triangle at z = 0; a rigid "table" below it, an upright triangle that crosses the
// cloth where its frame is at the base's origin; and a robot of one such link, "hand".
class RigidSceneTest : public LoopTest {
 protected:
  RigidSceneTest() {
    // Detectors look at the real clock, which must not overtake this one.
    steady_time_ = std::chrono::steady_clock::now() + std::chrono::hours(1);
    parameters_.max_mesh_age_s = 10;
    parameters_.objects.pop_back();
    parameters_.rigids = {
        {"table", "table_frame", std::make_shared<const TriangleMesh>(upright())}};
    parameters_.pair_classes = {false, false, false, false, true, false};
    make_detector_ = [] { return makeCpuDetector(); };
    auto robot = std::make_shared<RobotGeometry>();
    robot->links.push_back({"hand", "", upright(), ""});
    robot->link_names = {"hand"};
    robot_ = robot;
    said_.at_result = [this](const CycleReport& report) {
      if (tracker_ == nullptr) {
        tracker_ = std::make_unique<ContactStateTracker>(stateRules(parameters_));
      }
      tracker_->update(report);
      states_.clear();
      for (const ContactState& s : tracker_->states(report.header.stamp, report.now).states) {
        states_[s.body_a + " " + s.body_b] = std::string("-nCa?P").at(s.state);
        reasons_[s.body_a + " " + s.body_b] = s.reason;
      }
      if (report.result != nullptr) counters_ = report.result->counters;
      poses_.clear();
      for (const Body& body : report.scene->bodies()) poses_[body.name] = body.pose;
      bodies_ = report.bodies;
    };
  }

  static TriangleMesh upright() {
    return {{0.25F, 0.25F, -.125F, 0.25F, 0.25F, .125F, 0.375F, 0.25F, .125F}, {0, 1, 2}};
  }

  void useRobot() {
    robot_source_ = [this] { return robot_; };
  }

  void put(const std::string& frame, double x) {
    geometry_msgs::TransformStamped t;
    t.header.frame_id = "base";
    t.header.stamp = ros_time_;
    t.child_frame_id = frame;
    t.transform.translation.x = x;
    t.transform.rotation.w = 1;
    transforms_.add(t, "test", false, SteadyTime::max());
  }

  // Makes the cloth's cycle an eighth of a second later, with the frames at these places.
  void cycle(const std::map<std::string, double>& frames) {
    ros_time_ += ros::Duration(0.125);
    for (const auto& [frame, x] : frames) put(frame, x);
    give(0, ros_time_.toSec());
    stepAfter(200);
  }

  double xOf(const std::string& body) const { return poses_.at(body).translation[0]; }
  const std::string& stateOf(const std::string& pair) {
    static const std::string none = "none";
    const auto found = states_.find(pair);
    return found == states_.end() ? none : found->second;
  }

  std::shared_ptr<const RobotGeometry> robot_;
  std::unique_ptr<ContactStateTracker> tracker_;
  std::map<std::string, std::string> states_, reasons_;
  std::map<std::string, RigidTransform> poses_;
  std::vector<BodyStatus> bodies_;
  Counters counters_;
};

TEST_F(RigidSceneTest, ItIsPosedAtTheStampOfEachCycle) {
  cycle({{"table_frame", 0}});
  EXPECT_EQ(stateOf("table cloth"), "C");
  cycle({{"table_frame", 5}});
  EXPECT_EQ(stateOf("table cloth"), "-");
  EXPECT_EQ(xOf("table"), 5);
  EXPECT_EQ(bodies_[0].stamp, ros_time_);
  EXPECT_EQ(bodies_[0].kind, BodyKind::kRigid);
  EXPECT_FALSE(bodies_[0].triggered);
  // Between two transforms it is where tf2 interpolates.
  ros_time_ += ros::Duration(1);
  put("table_frame", 6);
  ros_time_ -= ros::Duration(0.625);
  cycle({});
  EXPECT_NEAR(xOf("table"), 5.5, 1e-9);
}

TEST_F(RigidSceneTest, WithoutItsTransformItIsUnknown) {
  cycle({{"hand", 0}});
  EXPECT_EQ(stateOf("table cloth"), "?");
  EXPECT_NE(reasons_["table cloth"].find("table_frame"), std::string::npos)
      << reasons_["table cloth"];
  cycle({{"table_frame", 0}});
  EXPECT_EQ(stateOf("table cloth"), "C");
  cycle({});
  EXPECT_EQ(stateOf("table cloth"), "?") << "the last one is too old for this stamp";
}

TEST_F(RigidSceneTest, TheClothWaitsForItsTransformAsForALinks) {
  cycle({{"table_frame", 0}});
  std::string why_not;
  const auto mesh = meshes()[0].newest(&why_not);
  ASSERT_TRUE(mesh) << why_not;
  MonitorScene scene(parameters_);
  const auto awaited = [&] {
    std::vector<std::string> frames;
    for (const FrameAtStamp& frame : scene.awaitedFrames(0, ros_time_, *mesh)) {
      EXPECT_EQ(frame.stamp, ros_time_);
      frames.push_back(frame.frame);
    }
    return frames;
  };
  EXPECT_EQ(awaited(), Lines{"table_frame"});
  scene.setAttached(
      {{"table", {{"hand"}, nullptr, std::make_shared<const RigidGrip>(RigidGrip{"hand", {}})}}});
  EXPECT_EQ(awaited(), Lines{"hand"});
  scene.setPairClasses({true});
  EXPECT_TRUE(awaited().empty());
}

TEST_F(RigidSceneTest, InTheReferenceFrameItNeedsNoTransform) {
  parameters_.rigids[0].frame = "base";
  cycle({});
  EXPECT_EQ(stateOf("table cloth"), "C");
  EXPECT_TRUE(poses_["table"].isIdentity());
}

// Nothing is looked up or computed of it: a cycle does the same work as without it.
TEST_F(RigidSceneTest, WhileItsClassesAreOffItCostsNothing) {
  useRobot();
  parameters_.pair_classes = PairClasses();
  const std::vector<RigidParameters> rigids = std::exchange(parameters_.rigids, {});
  cycle({{"hand", 0}});
  EXPECT_EQ(stateOf("hand cloth"), "C");
  const Counters without = counters_;

  parameters_.rigids = rigids;
  LiveParameters live = startValues(parameters_);
  MonitorScene scene(parameters_);
  scene.setRobot(*robot_);
  const auto prepared = [&] {
    return scene.prepare(ros_time_, {{0}, false}, meshes(), TransformLookup(transforms_, "base"));
  };
  EXPECT_EQ(prepared().asked, std::vector<std::string>{"hand"});
  EXPECT_TRUE(scene.bodies()[1].stamp.isZero());
  const auto counted = [&] { return makeCpuDetector()->detect(scene.scene(), Options()).counters; };
  EXPECT_EQ(counted().posed, without.posed);
  EXPECT_EQ(counted().candidates, without.candidates);
  live.pair_classes.deformable_rigid = true;
  scene.setPairClasses(live.pair_classes);
  put("table_frame", 0);
  EXPECT_EQ(prepared().asked, (std::vector<std::string>{"hand", "table"}));
  EXPECT_EQ(counted().posed, without.posed + 1);
}

TEST_F(RigidSceneTest, ItHasItsOwnMarginOrTheGeneralOne) {
  parameters_.margin_m = 0.25F;
  parameters_.rigids[0].margin_m = 0.5F;
  parameters_.rigids.push_back(parameters_.rigids[0]);
  parameters_.rigids[1].name = "bed";
  parameters_.rigids[1].shares_margin = true;
  parameters_.rigids[1].radius_m = 0.125F;
  MonitorScene scene(parameters_);
  scene.setMargin(0.75);
  EXPECT_EQ(scene.scene().body(0).margin_m, 0.5F);
  EXPECT_EQ(scene.scene().body(1).margin_m, 0.75F);
  EXPECT_EQ(scene.scene().body(1).radius_m, 0.125F);
  EXPECT_EQ(scene.firstRigid(), 0U);
  EXPECT_EQ(scene.firstObject(), 2U);
}

TEST_F(RigidSceneTest, TheRobotsOwnCyclesHaveItsPairsWithLinks) {
  useRobot();
  parameters_.pair_classes = {false, false, false, false, false, true};
  put("hand", 0);
  put("table_frame", 0.125);
  step();
  ASSERT_EQ(bodies_.size(), 3U) << "no cycle";
  EXPECT_EQ(stateOf("hand table"), "C");
  EXPECT_EQ(stateOf("table cloth"), "none");
  ros_time_ += ros::Duration(0.125);
  put("hand", 0);
  put("table_frame", 5);
  stepAfter(200);
  EXPECT_EQ(stateOf("hand table"), "-");
  EXPECT_TRUE(bodies_[0].triggered);
  EXPECT_FALSE(bodies_[1].triggered);
  ros_time_ += ros::Duration(0.125);
  put("hand", 0);
  stepAfter(200);
  EXPECT_EQ(stateOf("hand table"), "-") << "no newer transform of both";
}

// The table's transforms come from a machine whose clock is ahead.
TEST_F(RigidSceneTest, AClockThatIsAheadDoesNotHideLinksFromOneAnother) {
  useRobot();
  auto robot = std::make_shared<RobotGeometry>(*robot_);
  robot->links.push_back({"arm", "", upright(), ""});
  robot->link_names.insert("arm");
  robot_ = robot;
  parameters_.max_mesh_age_s = 0.5;
  parameters_.pair_classes = {false, false, false, true, false, true};
  put("hand", 0);
  put("arm", 0);
  addTransform(&transforms_, "table_frame", ros_time_.toSec() + 0.75);
  step();
  EXPECT_EQ(stateOf("hand arm"), "C");
  EXPECT_EQ(stateOf("hand table"), "?");
}

TEST_F(RigidSceneTest, ALinkCarriesItUntilItIsReleased) {
  useRobot();
  parameters_.pair_classes = {true, false, false, false, true, true};
  cycle({{"hand", 2}, {"table_frame", 0}});
  EXPECT_EQ(stateOf("table cloth"), "C");
  const AttachedObjects nobody;
  const auto grip = findGrip({parameters_.rigids[0], "hand", nobody, 0, ros_time_}, parameters_,
                             TransformLookup(transforms_, "base"));
  requests_.attach("table", {"hand"}, nullptr, grip);
  cycle({{"hand", 2}, {"table_frame", 7}});
  EXPECT_EQ(xOf("table"), 0) << "it stays where the hand took hold of it";
  EXPECT_EQ(stateOf("table cloth"), "C");
  EXPECT_EQ(stateOf("hand table"), "a");
  cycle({{"hand", 5}});
  EXPECT_EQ(xOf("table"), 3) << "and goes with it, without a transform of its own";
  EXPECT_EQ(stateOf("table cloth"), "-");
  requests_.attach("table", {});
  cycle({{"hand", 5}, {"table_frame", 0}});
  EXPECT_EQ(xOf("table"), 0);
  EXPECT_EQ(stateOf("table cloth"), "C");
}

TEST_F(RigidSceneTest, TheReferenceFrameMayCarryIt) {
  useRobot();
  parameters_.reference_frame = "base";
  auto robot = std::make_shared<RobotGeometry>(*robot_);
  robot->link_names.insert("base");
  robot_ = robot;
  RigidTransform there;
  there.translation[0] = 4;
  requests_.attach("table", {"base"}, nullptr,
                   std::make_shared<const RigidGrip>(RigidGrip{"base", there}));
  cycle({{"hand", 0}});
  EXPECT_EQ(xOf("table"), 4);
  EXPECT_EQ(stateOf("table cloth"), "-");
}

TEST_F(RigidSceneTest, ItHoldsWhatDeforms) {
  cycle({{"table_frame", 0}});
  EXPECT_EQ(stateOf("table cloth"), "C");
  requests_.attach("cloth", {"table"});
  cycle({{"table_frame", 0}});
  EXPECT_EQ(stateOf("table cloth"), "a");
  std::string why_not;
  const auto mesh = meshes()[0].newest(&why_not);
  ASSERT_TRUE(mesh) << why_not;
  const std::vector<std::string> holders = {"table"};
  HoldQuestion question{"cloth", *mesh, holders, 0.01F};
  const TransformLookup lookup(transforms_, "base");
  EXPECT_EQ(framesOfHold(question, parameters_).front().frame, "table_frame");
  EXPECT_EQ(findHeldPart(question, RobotGeometry(), parameters_, lookup)->triangles,
            std::vector<std::uint32_t>{0});
  // A link carries the table away from the cloth.
  RigidTransform there;
  there.translation[0] = 4;
  put("hand", 3);
  question.attached = {
      {"table", {{"hand"}, nullptr, std::make_shared<const RigidGrip>(RigidGrip{"hand", there})}}};
  EXPECT_EQ(framesOfHold(question, parameters_).front().frame, "hand");
  EXPECT_THROW(findHeldPart(question, RobotGeometry(), parameters_, lookup), std::invalid_argument);
}

TEST_F(RigidSceneTest, WhatIsInsideAClosedOneTouchesIt) {
  parameters_.containment = true;
  parameters_.rigids[0].mesh = std::make_shared<const TriangleMesh>(TriangleMesh{
      {-4, -4, -4, 16, -4, -4, -4, 16, -4, -4, -4, 16}, {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}});
  cycle({{"table_frame", 0}});
  EXPECT_EQ(stateOf("table cloth"), "C");
  EXPECT_EQ(said_.inside.size(), 1U);
  cycle({{"table_frame", 40}});
  EXPECT_EQ(stateOf("table cloth"), "-");
}

class RigidStepsTest : public StepsTest {
 protected:
  RigidStepsTest() {
    parameters_.rigids = {
        {"table", "table_frame", std::make_shared<const TriangleMesh>(robotOf(1)->links[0].mesh)}};
    parameters_.pair_classes = {false, false, false, false, true, false};
  }

  const StepBody& table() const { return said_.sweeps.at(0).bodies.at(names_.size() - 3); }
};

// The table's triangle is 1 m below the frame's plane. The cloth falls through it.
TEST_F(RigidStepsTest, WhatPassesThroughItIsFound) {
  for (int i = 0; i <= 4; ++i) addTransform(&transforms_, "table_frame", 50 + i / 32.0, 0.001 * i);
  give(0, 50, "base", -0.5F);
  step();
  give(0, 50.125, "base", -1.5F);
  step();
  EXPECT_EQ(steps(), Lines{"50 of cloth: table/cloth"});
  EXPECT_EQ(found_, Lines{"table/cloth"});
  EXPECT_FALSE(stamp_touches_);
  EXPECT_FALSE(table().path.empty()) << "its frame rotates";
}

TEST_F(RigidStepsTest, ItsPathIsThatOfTheLinkThatCarriesIt) {
  useRobot(1);
  for (int i = 0; i <= 4; ++i) addTransform(&transforms_, "link0", 50 + i / 32.0, 0.1 * i * i);
  RigidTransform there;
  there.translation[1] = 0.5;
  requests_.attach("table", {"link0"}, nullptr,
                   std::make_shared<const RigidGrip>(RigidGrip{"link0", there}));
  give(0, 50, "base", -3);
  step();
  give(0, 50.125, "base", -4);
  step();
  EXPECT_EQ(steps(), Lines{"50 of cloth: table/cloth"});
  const TransformLookup lookup(transforms_, "base");
  ASSERT_GT(table().path.size(), 5U);
  for (const PoseSample& sample : table().path) {
    ros::Time stamp;
    stamp.fromNSec(50000000000ULL + static_cast<std::uint64_t>(std::llround(0.125e9 * sample.at)));
    EXPECT_EQ(sample.pose, compose(lookup.lookup({{"link0", stamp}})[0].pose, there)) << sample.at;
  }
  // It is released, so nobody knows how it came to where its own frame is.
  requests_.attach("table", {});
  addTransform(&transforms_, "table_frame", 50.125);
  addTransform(&transforms_, "table_frame", 50.25);
  addTransform(&transforms_, "link0", 50.25);
  give(0, 50.25, "base", -5);
  step();
  EXPECT_EQ(steps(), Lines{"50.125 of cloth: table/cloth (table: another frame than in the "
                           "previous cycle)"});
}

TEST_F(RigidStepsTest, TheRobotsOwnCyclesAreTriggeredByLinksAlone) {
  useRobot(1);
  parameters_.pair_classes = {false, false, false, false, false, true};
  for (const char* const frame : {"link0", "table_frame"}) addTransform(&transforms_, frame, 50);
  step();
  for (const char* const frame : {"link0", "table_frame"})
    addTransform(&transforms_, frame, 50.125);
  stepAfter(200);
  EXPECT_EQ(steps(), Lines{"50 of link0: link0/table"});
}

}  // namespace
}  // namespace deformable_contact_monitor
