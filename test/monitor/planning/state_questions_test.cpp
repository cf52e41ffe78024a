// Tests questions about states: what moves with the joints, by which rules pairs are looked at, and
// what is not known or refused. The answers are those of cycles in which TF has the same poses.
#include "monitor/planning/state_questions.h"

#include <deformable_contact_monitor/ContactState.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cmath>
#include <future>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/cpu_detector.h"
#include "refusal.h"

namespace deformable_contact_monitor {
namespace {

using Names = std::vector<std::string>;

// An arm of 1 m that turns about z, and a hand at its end that slides outwards.
constexpr const char* kRobot = R"(<robot name="test">
  <link name="base"/>
  <link name="arm"><collision><origin xyz="0.5 0 0"/><geometry><box size="1 0.1 0.1"/></geometry>
    </collision></link>
  <link name="hand"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <joint name="slide" type="prismatic"><parent link="arm"/><child link="hand"/>
    <origin xyz="1 0 0"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="1" effort="1" velocity="1"/></joint>
</robot>)";
constexpr double kFree = 0, kAtCloth = M_PI / 2;  // positions of `turn`

std::string noFile(const std::string& uri) { throw std::runtime_error(uri); }

MonitorParameters parameters() {
  MonitorParameters p;
  p.reference_frame = "base";
  p.objects = {{"cloth", "", 0.25F, true}};
  p.objects[0].parts = {{"low", {{0, 0}}}};
  p.pair_classes = {true, false, false, false, true, false};
  p.margin_m = 0.25F;
  p.max_mesh_age_s = 0.5;
  p.tf_timeout_s = 0;
  const TriangleMesh rod{{0, -.0625F, 0, 0.25F, .0625F, 0, 0, 0, .0625F}, {0, 1, 2}};
  p.rigids.push_back({"tool", "tool_tip", std::make_shared<const TriangleMesh>(rod)});
  return p;
}

class StateQuestionsTest : public ::testing::Test {
 protected:
  StateQuestionsTest() {
    robot_ = load({{kRobot, "", "", {}}});
    give();
    put("arm", "base", 0);
    put("hand", "arm", 1);
    put("tool_tip", "base", -5);
  }

  static std::shared_ptr<const RobotGeometry> load(const std::vector<RobotDescription>& robots) {
    return std::make_shared<const RobotGeometry>(loadRobots(robots, {}, noFile));
  }

  // A sheet in the plane x = 0 at y of 0.8 to 1.2, of two triangles.
  void give(float x = 0, const std::string& frame = "base") {
    auto message = boost::make_shared<DeformableMesh>();
    message->header.stamp = now_;
    message->header.frame_id = frame;
    message->topology_id = 3;
    message->vertices = {x, 0.8F, -.5F, x, 1.2F, -.5F, x, 1.2F, .5F, x, 0.8F, .5F};
    message->triangles = {0, 1, 2, 0, 2, 3};
    IncomingMesh mesh{message};
    meshes()[0].store(mesh);
    meshes()[0].take(now_, &mesh);
    EXPECT_EQ(mesh.problem, "");
  }

  MeshInputs& meshes() {
    if (meshes_.empty()) meshes_ = makeMeshInputs(parameters_);
    return meshes_;
  }

  void put(const std::string& frame, const std::string& parent, double x, double angle = 0) {
    putInto(&transforms_, frame, parent, x, angle);
  }
  void putInto(tf2::BufferCore* buffer, const std::string& frame, const std::string& parent,
               double x, double angle) {
    geometry_msgs::TransformStamped t;
    t.header.frame_id = parent;
    t.header.stamp = now_;
    t.child_frame_id = frame;
    t.transform.translation.x = x;
    t.transform.rotation.z = std::sin(angle / 2);
    t.transform.rotation.w = std::cos(angle / 2);
    buffer->setTransform(t, "test");
  }

  StateQuestions& questions() {
    if (!questions_) {
      questions_ = std::make_unique<StateQuestions>(
          parameters_,
          QuestionSources{requests_, meshes(), transforms_, [this] { return robot_; },
                          [this] { return now_; }},
          makeCpuStateChecker());
    }
    return *questions_;
  }

  StatesChecked ask(const std::vector<double>& positions, const Names& joints = {"turn"},
                    float margin = 0, const Names& objects = {}) {
    StatesToCheck question;
    question.positions = positions;
    question.joint_names = joints;
    question.margin = margin;
    question.objects = objects;
    return questions().answer(question);
  }

  // Returns a letter for each state, and the reason unless it is empty.
  std::string states(const StatesChecked& answer) {
    std::string text;
    for (const std::uint8_t state : answer.state) text += std::string("-nCa?P").at(state);
    return text + (answer.reason.empty() ? "" : " " + answer.reason);
  }

  MonitorParameters parameters_ = parameters();
  ros::Time now_{100};
  LoopRequests requests_{AllowedContacts()};
  MeshInputs meshes_;
  tf2::BufferCore transforms_;
  std::shared_ptr<const RobotGeometry> robot_;
  std::unique_ptr<StateQuestions> questions_;
};

// A cycle whose transforms have the links where the joints put them finds the same.
TEST_F(StateQuestionsTest, StatesAreThoseOfCycles) {
  std::mt19937 random(46);
  std::uniform_real_distribution<double> turn(0.8, 2.2), slide(0, 0.4);
  MonitorScene scene(parameters_);
  scene.setRobot(*robot_);
  const std::unique_ptr<Detector> detector = makeCpuDetector();
  Options options;
  options.nearest = true;
  std::vector<double> positions;
  std::vector<NearestPair> least;
  for (int i = 0; i < 60; ++i) {
    positions.insert(positions.end(), {slide(random), turn(random)});
    tf2::BufferCore transforms;
    putInto(&transforms, "arm", "base", 0, positions.back());
    putInto(&transforms, "hand", "arm", 1 + positions[positions.size() - 2], 0);
    putInto(&transforms, "tool_tip", "base", -5, 0);
    scene.prepare(now_, {{0}, false}, meshes(), TransformLookup(transforms, "base"));
    const std::vector<NearestPair> nearest = detector->detect(scene.scene(), options).nearest;
    least.push_back({});
    least.back().distance_m = std::numeric_limits<float>::infinity();
    for (const NearestPair& pair : nearest) {
      if (pair.distance_m < least.back().distance_m) least.back() = pair;
    }
  }
  const StatesChecked answer = ask(positions, {"slide", "turn"}, -1);
  ASSERT_EQ(answer.state.size(), 60U) << answer.reason;
  std::map<int, int> counts;
  for (std::size_t i = 0; i < least.size(); ++i) {
    const float wanted = least[i].distance_m;
    const int state = wanted == 0          ? ContactState::CONTACT
                      : std::isinf(wanted) ? ContactState::NONE
                                           : ContactState::NEAR;
    ++counts[state];
    EXPECT_EQ(answer.state[i], state) << i;
    if (state == ContactState::NONE) {
      EXPECT_EQ(answer.distance[i], wanted);
      continue;
    }
    EXPECT_NEAR(answer.distance[i], wanted, 1e-6);
    EXPECT_EQ(answer.link[i], scene.bodies()[least[i].pair.body_a].name);
    EXPECT_EQ(answer.object[i], "cloth");
  }
  EXPECT_EQ(counts.size(), 3U);
}

TEST_F(StateQuestionsTest, JointsThatAreNotNamedStayWhereTfHasThem) {
  now_ += ros::Duration(0.125);
  put("arm", "base", 0, 1);
  put("hand", "arm", 2);  // a slide of 1, from where the hand does not reach back to the sheet
  const StatesChecked answer = ask({kFree, kAtCloth}, {"turn"}, 1);
  EXPECT_EQ(answer.stamp, now_);
  EXPECT_EQ(states(answer), "nC");
  EXPECT_EQ(answer.link[1], "arm");
  EXPECT_EQ(states(ask({kAtCloth, 0.1, kAtCloth, 0.9}, {"turn", "slide"})), "CC");
  // Only the hand moves, so the arm does not count.
  now_ += ros::Duration(0.125);
  give();
  put("hand", "arm", 1);
  put("tool_tip", "base", -5);
  put("arm", "base", 0, kAtCloth);
  EXPECT_EQ(states(ask({0.1, 0.9}, {"slide"})), "C-");
}

TEST_F(StateQuestionsTest, ARigidObjectGoesWithTheLinkAboveItInTf) {
  parameters_.pair_classes = {false, false, false, false, true, true};
  const Names turn{"turn"}, cloth{"cloth"};
  EXPECT_EQ(states(ask({kAtCloth}, turn, 0, cloth)),
            " object 'cloth' has no monitored pair with anything that these joints move "
            "(~pair_classes, ~links)");
  now_ += ros::Duration(0.0625);
  put("mount", "hand", -0.125);
  put("tool_tip", "mount", 0.0625);
  put("arm", "base", 0, 0.5);
  put("hand", "arm", 1);
  EXPECT_EQ(states(ask({kFree, kAtCloth}, turn, 0, cloth)), "-C");
  EXPECT_EQ(ask({kAtCloth}, turn, 0, cloth).link, Names{"tool"});
  EXPECT_TRUE(ask({kAtCloth}, turn, 0, {"tool"}).object_stamps[0].isZero());
}

TEST_F(StateQuestionsTest, AnAttachedRigidObjectGoesWithItsLink) {
  parameters_.pair_classes = {false, false, false, false, true, true};
  const Names turn{"turn"}, cloth{"cloth"};
  RigidGrip grip{"hand", {}};
  grip.link_from_object.translation[0] = -0.125;
  requests_.attach("tool", {"hand"}, nullptr, std::make_shared<const RigidGrip>(grip));
  const StatesChecked answer = ask({kFree, kAtCloth}, turn, 0, cloth);
  EXPECT_EQ(states(answer), "-C");
  EXPECT_EQ(answer.link[1], "tool");
  requests_.attach("tool", {});
  EXPECT_FALSE(ask({kFree}, turn, 0, cloth).success);
}

TEST_F(StateQuestionsTest, AMeshStaysAlsoIfALinkSawIt) {
  now_ += ros::Duration(0.125);
  put("arm", "base", 0, 0);
  put("hand", "arm", 0);
  put("tool_tip", "base", -5);
  give(0, "hand");
  EXPECT_EQ(states(ask({kFree, kAtCloth})), "-C");
}

TEST_F(StateQuestionsTest, LinksOfARobotThatStandsOnAnotherGoWithIt) {
  robot_ = load({{kRobot, "", "", {}}, {kRobot, "", "top/", {}}});
  requests_.changeAllowedContacts({false, {}, {[] {
                                     AllowedContact rule;
                                     rule.body_a = "arm";
                                     rule.body_b = "cloth";
                                     rule.allowed = true;
                                     return rule;
                                   }()}});
  put("top/base", "arm", 0.5);
  put("top/arm", "top/base", 0);
  put("top/hand", "top/arm", 1);
  const StatesChecked answer = ask({kFree, kAtCloth});
  EXPECT_EQ(states(answer), "-C");
  EXPECT_EQ(ask({0.5}, {"top/turn"}).state.size(), 1U);
}

TEST_F(StateQuestionsTest, RulesPartsAndHoldsAreThoseInForce) {
  const auto rule = [](const std::string& body_a, const std::string& body_b) {
    AllowedContact allowed;
    allowed.body_a = body_a;
    allowed.body_b = body_b;
    allowed.allowed = true;
    return allowed;
  };
  EXPECT_EQ(states(ask({kAtCloth})), "C");
  requests_.changeAllowedContacts({false, {}, {rule("arm", "cloth"), rule("hand", "cloth:low")}});
  EXPECT_EQ(states(ask({kAtCloth})), "C") << "the hand touches the rest of the sheet";
  requests_.changeAllowedContacts({false, {}, {rule("hand", "cloth:*"), rule("hand", "cloth")}});
  EXPECT_EQ(states(ask({kAtCloth})), "-");
  requests_.changeAllowedContacts({true, {}, {}});
  EXPECT_EQ(states(ask({kAtCloth})), "C");

  auto part = std::make_shared<HeldPart>();
  std::string why_not;
  part->topology = meshes()[0].newest(&why_not)->topology;
  part->stamp = now_;
  part->triangles = {0, 1};
  requests_.attach("cloth", {"arm", "hand"}, part);
  EXPECT_EQ(states(ask({kAtCloth})), "-");
  part = std::make_shared<HeldPart>(*part);
  part->triangles = {0};
  requests_.attach("cloth", {"arm", "hand"}, part);
  EXPECT_EQ(states(ask({kAtCloth})), "C");
  requests_.attach("cloth", {"arm", "hand"});
  EXPECT_EQ(states(ask({kAtCloth})), "-");
}

TEST_F(StateQuestionsTest, AMarginOfTheQuestionDoesNotStay) {
  parameters_.objects[0].parts[0].margin_m = 0.5F;
  // So far away only the margin of the part has the sheet.
  const double away = 1.05;
  const StatesChecked before = ask({away}, {"turn"}, -1);
  EXPECT_EQ(states(before), "n");
  EXPECT_EQ(states(ask({away}, {"turn"}, 0.01F)), "-");
  EXPECT_EQ(states(ask({away}, {"turn"}, 0)), "-");
  const StatesChecked wide = ask({kFree}, {"turn"}, 10);
  EXPECT_EQ(states(wide), "n");
  EXPECT_GT(wide.distance[0], 0.5F);
  const StatesChecked after = ask({away}, {"turn"}, -1);
  EXPECT_EQ(states(after), "n");
  EXPECT_EQ(after.distance, before.distance);
  EXPECT_EQ(states(ask({kFree}, {"turn"}, -1)), "-");
  LiveParameters live = startValues(parameters_);
  live.pair_classes = {true};
  requests_.change(live);
  EXPECT_EQ(states(ask({away}, {"turn"}, -1)), "n");
  live.pair_classes = {false, true};
  requests_.change(live);
  expectIn("no monitored pair", ask({away}).reason);
}

TEST_F(StateQuestionsTest, TrianglesThatAreNotFiniteLeaveItOpen) {
  parameters_.objects[0].parts.clear();
  now_ += ros::Duration(0.125);
  give(std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(states(ask({kFree})),
            "? cloth: 2 of 2 triangles have a vertex that is not finite (tolerated_rejects)");
  parameters_.tolerated_rejects = 1;
  EXPECT_EQ(states(ask({kFree})), "-");
}

TEST_F(StateQuestionsTest, OldMeshesAndTransformsAreUnknown) {
  now_ += ros::Duration(0.75);
  put("arm", "base", 0);
  put("hand", "arm", 1);
  StatesChecked answer = ask({kFree, kAtCloth}, {"turn"}, 0, {"cloth"});
  EXPECT_EQ(states(answer), "?? cloth: newest mesh is 0.750 s old");
  EXPECT_EQ(answer.object_stamps, std::vector<ros::Time>{ros::Time(100)});
  EXPECT_TRUE(std::isnan(answer.distance[0]));
  give();
  EXPECT_EQ(states(ask({kFree, kAtCloth})), "-C");
  now_ += ros::Duration(0.75);
  give();
  EXPECT_EQ(states(ask({kFree})),
            "? the newest transforms are 0.750000 s old, and max_mesh_age_s less");
  EXPECT_EQ(states(ask({kFree, 0}, {"turn", "slide"})), "-") << "this needs no transform";
}

TEST_F(StateQuestionsTest, WithoutTheTransformOfAStillJointAllIsUnknown) {
  transforms_.clear();
  EXPECT_EQ(states(ask({kFree})), "? TF from 'arm' to 'base' never seen");
  EXPECT_EQ(states(ask({kFree, 0}, {"turn", "slide"})), "-");
}

TEST_F(StateQuestionsTest, WhatCannotBeAnsweredIsRefused) {
  const auto why = [&] {
    const StatesChecked answer = ask({kFree});
    EXPECT_FALSE(answer.success);
    EXPECT_TRUE(answer.state.empty() && answer.objects.empty() && answer.beyond_limits.empty());
    return answer.reason;
  };
  const ros::Time then = std::exchange(now_, ros::Time());
  EXPECT_EQ(why(), "no clock: use_sim_time is set, and nothing came on /clock");
  now_ = then;
  const auto robot = std::exchange(robot_, nullptr);
  EXPECT_EQ(why(), "no robot received yet");
  RobotGeometry of_topic = *robot;
  of_topic.joints.clear();
  robot_ = std::make_shared<const RobotGeometry>(of_topic);
  expectIn("it has no URDF", why());
  robot_ = robot;
  requests_.setEnabled(false);
  EXPECT_EQ(why(), "the monitor is disabled (~set_enabled)");
  requests_.setEnabled(true);
  EXPECT_TRUE(ask({kFree}).success);
}

// Begins a check and ends it when it is told to.
struct SlowChecker : StateChecker {
  std::string backend() const override { return "slow"; }
  const StateResults& check(const Scene& /*scene*/, const StateBatch& batch,
                            const StateOptions& /*options*/) override {
    begun.set_value();
    go_on.get_future().wait();
    results.states.resize(batch.count);
    return results;
  }
  void reset() override {}

  std::promise<void> begun, go_on;
  StateResults results;
};

// What a cycle does with the shared objects, and what services do, waits for no question. If it
// did, this test would not end.
TEST_F(StateQuestionsTest, NobodyWaitsForAQuestion) {
  auto owned = std::make_unique<SlowChecker>();
  SlowChecker& checker = *owned;
  StateQuestions slow(
      parameters_,
      {requests_, meshes(), transforms_, [this] { return robot_; }, [] { return ros::Time(100); }},
      std::move(owned));
  StatesToCheck question;
  question.joint_names = {"turn"};
  question.positions = {kFree};
  auto answer = std::async(std::launch::async, [&] { return slow.answer(question); });
  checker.begun.get_future().wait();
  now_ += ros::Duration(0.125);
  give();
  put("arm", "base", 1);
  requests_.attach("cloth", {"hand"});
  requests_.changeAllowedContacts({true, {}, {}});
  requests_.change(startValues(parameters_));
  requests_.setEnabled(true);
  EXPECT_TRUE(requests_.take().attached);
  EXPECT_TRUE(meshes()[0].has(now_));
  checker.go_on.set_value();
  EXPECT_TRUE(answer.get().success);
}

TEST_F(StateQuestionsTest, ARequestToStopEndsIt) {
  requests_.stop();
  EXPECT_EQ(states(ask(std::vector<double>(20000, kAtCloth))).substr(19995), "????? stopped");
}

}  // namespace
}  // namespace deformable_contact_monitor
