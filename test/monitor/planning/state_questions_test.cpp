// Tests questions about states: by which rules pairs are looked at, and what is not known or
// refused. The answers are those of cycles in which TF has the same poses.
#include "monitor/planning/state_questions.h"

#include <deformable_contact_monitor/ContactState.h>
#include <gtest/gtest.h>

#include <cmath>
#include <future>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/cpu_detector.h"
#include "planning/state_questions_support.h"
#include "refusal.h"

namespace deformable_contact_monitor {
namespace {

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
    TransformBuffer transforms;
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

TEST_F(StateQuestionsTest, WithoutNamesStatesAreDecidedAlike) {
  StatesToCheck question;
  question.joint_names = {"turn"};
  for (int i = 0; i <= 20; ++i) question.positions.push_back(-2 + 0.2 * i);
  std::set<std::string> all;
  for (const float margin : {0.0F, 0.05F, 0.25F, 1.0F, -1.0F}) {
    question.margin = margin;
    question.first_only = false;
    const std::string expected = states(questions().answer(question));
    question.first_only = true;
    const StatesChecked answer = questions().answer(question);
    EXPECT_EQ(states(answer), expected) << margin;
    EXPECT_TRUE(answer.distance.empty() && answer.link.empty() && answer.object.empty());
    all.insert(expected);
  }
  EXPECT_EQ(all.size(), 3U) << "the margins make a difference";
}

TEST_F(StateQuestionsTest, RulesPartsAndHoldsAreThoseInForce) {
  EXPECT_EQ(states(ask({kAtCloth})), "C");
  requests_.changeAllowedContacts(
      {false, {}, {allowed("arm", "cloth"), allowed("hand", "cloth:low")}});
  EXPECT_EQ(states(ask({kAtCloth})), "C") << "the hand touches the rest of the sheet";
  requests_.changeAllowedContacts(
      {false, {}, {allowed("hand", "cloth:*"), allowed("hand", "cloth")}});
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
            "? TF from 'arm' to 'base' is late: wanted 101.500000000, newest available "
            "100.750000000");
  EXPECT_EQ(states(ask({kFree, 0}, {"turn", "slide"})), "-") << "this needs no transform";
}

// The tool stands still, and its frame is the only one whose present pose the question needs.
TEST_F(StateQuestionsTest, AnOldTransformOfOneBodyLeavesTheOthersKnown) {
  parameters_.pair_classes = {true, false, false, false, true, true};
  now_ += ros::Duration(0.75);
  give();
  const Names both{"turn", "slide"};
  const StatesChecked answer = ask({kFree, 0, kAtCloth, 0}, both);
  EXPECT_EQ(states(answer),
            "?C tool: TF from 'tool_tip' to 'base' is late: wanted 100.750000000, newest available "
            "100.000000000");
  EXPECT_EQ(answer.stamp, now_);
  EXPECT_EQ(states(ask({kFree, 0, kAtCloth, 0}, both, 0, {"cloth"})), "-C");
  put("tool_tip", "base", -5);
  EXPECT_EQ(states(ask({kFree, 0, kAtCloth, 0}, both)), "-C");
}

// They are of the time before the clock went back.
TEST_F(StateQuestionsTest, MeshesAndTransformsAheadOfTheClockAreUnknown) {
  now_ -= ros::Duration(0.875);
  EXPECT_EQ(states(ask({kFree, kAtCloth})), "-C");
  now_ -= ros::Duration(1.125);
  EXPECT_EQ(states(ask({kFree, 0}, {"turn", "slide"})),
            "? cloth: newest mesh is 2.000 s ahead of the clock");
  give();
  EXPECT_EQ(states(ask({kFree, 0}, {"turn", "slide"})), "-");
  EXPECT_EQ(states(ask({kFree})), "? the newest transforms are 2.000 s ahead of the clock");
}

// The detection loop forgets meshes in its next step only.
TEST_F(StateQuestionsTest, AResetCountsAtOnce) {
  requests_.requestReset();
  EXPECT_EQ(states(ask({kFree, kAtCloth})), "?? cloth: all meshes are about to be forgotten");
  requests_.take();
  EXPECT_EQ(states(ask({kFree, kAtCloth})), "-C");
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
  EXPECT_EQ(states(ask({kFree})).front(), '?') << "the loop has not seen that it was disabled";
  requests_.take();
  EXPECT_EQ(states(ask({kFree})), "-");
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

// Decides nothing, and counts what it is asked.
struct CountingChecker : StateChecker {
  explicit CountingChecker(std::size_t* count) : states(count) {}
  std::string backend() const override { return "counting"; }
  const StateResults& check(const Scene& /*scene*/, const StateBatch& batch,
                            const StateOptions& /*options*/) override {
    *states += batch.count;
    results.states.resize(batch.count);
    return results;
  }
  void reset() override {}

  std::size_t* const states;
  StateResults results;
};

TEST_F(StateQuestionsTest, ARequestToStopEndsIt) {
  requests_.stop();
  const std::vector<double> many(20000, kAtCloth);
  EXPECT_EQ(states(ask(many)).substr(19995), "????? stopped");
  std::size_t checked = 0;
  StateQuestions counting(
      parameters_,
      {requests_, meshes(), transforms_, [this] { return robot_; }, [] { return ros::Time(100); }},
      std::make_unique<CountingChecker>(&checked));
  StatesToCheck question;
  question.joint_names = {"turn"};
  question.positions = many;
  EXPECT_EQ(states(counting.answer(question)).substr(19995), "????? stopped");
  EXPECT_EQ(checked, 0U) << "no state is posed, so there is nothing to check";
}

TEST_F(StateQuestionsTest, TimeMayRunOutBeforeAStateIsPosed) {
  StatesToCheck question;
  question.joint_names = {"turn"};
  question.positions = {kFree, kAtCloth};
  question.max_time = ros::Duration(0, 1);
  EXPECT_EQ(states(questions().answer(question)), "?? no time");
}

TEST_F(StateQuestionsTest, ObjectsMayBeNamedTwice) {
  EXPECT_EQ(states(ask({kFree, kAtCloth}, {"turn"}, 0, {"cloth", "cloth"})), "-C");
}

}  // namespace
}  // namespace deformable_contact_monitor
