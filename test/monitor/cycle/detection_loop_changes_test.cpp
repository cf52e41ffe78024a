// Tests of requests to the detection loop, of time jumps, and of a robot that changes.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "loop_fixture.h"

namespace deformable_contact_monitor {
namespace {

using ChangesTest = LoopTest;

AllowedContact allowed(const std::string& a, const std::string& b) {
  AllowedContact rule;
  rule.body_a = a;
  rule.body_b = b;
  rule.allowed = true;
  return rule;
}

std::shared_ptr<const RobotGeometry> robot(std::size_t links) {
  const auto robot = std::make_shared<RobotGeometry>();
  for (std::size_t i = 0; i < links; ++i) {
    robot->links.push_back({"link" + std::to_string(i), "test", TriangleMesh(), ""});
  }
  return robot;
}

TEST_F(ChangesTest, AResetForgetsAllButTheMeshThatWaits) {
  give(0, 50);
  give(1, 50);
  step();
  addTransform(&transforms_, "camera", 50);
  ASSERT_TRUE(transforms_.canTransform("base", "camera", ros::Time(50)));
  give(0, 50.0625);
  requests_.requestReset();
  EXPECT_EQ(step(), (Lines{"forget all: reset", "reset: reset",
                           "cycle 50.0625: *cloth@50.0625 cable(no mesh yet)"}));
  EXPECT_EQ(detector_.resets, 1);
  EXPECT_FALSE(transforms_.canTransform("base", "camera", ros::Time(50)));
  EXPECT_EQ(step(), Lines()) << "once";
}

TEST_F(ChangesTest, DisabledDropsMeshesAndSaysWhy) {
  give(0, 50);
  step();
  give(0, 50.25);
  requests_.setEnabled(false);
  EXPECT_EQ(step(), (Lines{"disabled", "forget all: disabled", "forget all: no new mesh",
                           "heartbeat 50: cloth(disabled) cable(disabled)"}));
  EXPECT_EQ(meshes()[0].counters().dropped, 1U);
  give(0, 50.5);
  EXPECT_EQ(stepAfter(500), Lines());
  EXPECT_EQ(stepAfter(500),
            (Lines{"forget all: no new mesh", "heartbeat 50: cloth(disabled) cable(disabled)"}));
  requests_.setEnabled(true);
  give(0, 50.75);
  EXPECT_EQ(step(), (Lines{"enabled", "cycle 50.75: *cloth@50.75 cable(no mesh yet)"}));
}

TEST_F(ChangesTest, AMeshThatComesInAStepOfADisabledMonitorHasNoCycle) {
  give(0, 50);
  step();
  requests_.setEnabled(false);
  said_.at_heartbeat = [this] { give(0, 50.25); };
  EXPECT_EQ(step().back(), "heartbeat 50: cloth(disabled) cable(disabled)");
  EXPECT_EQ(step(), Lines());
  EXPECT_EQ(meshes()[0].counters().dropped, 1U);
}

TEST_F(ChangesTest, WhatWasDisabledForAMomentForgetsAllTheSame) {
  give(0, 50);
  step();
  requests_.setEnabled(false);
  requests_.setEnabled(true);
  give(0, 50.25);
  EXPECT_EQ(step(), Lines{"forget all: disabled"});
  EXPECT_EQ(meshes()[0].counters().dropped, 1U);
  give(0, 50.375);
  EXPECT_EQ(step(), Lines{"cycle 50.375: *cloth@50.375 cable(no mesh yet)"});
}

TEST_F(ChangesTest, ReportsTellTheEpochInWhichTheirCycleBegan) {
  std::vector<std::uint64_t> epochs;
  said_.at_result = [&](const CycleReport& report) { epochs.push_back(report.epoch); };
  give(0, 50);
  at_cycle_ = [this] { requests_.requestReset(); };
  step();
  give(0, 50.0625);
  step();
  EXPECT_EQ(epochs, (std::vector<std::uint64_t>{0, 1}));
}

TEST_F(ChangesTest, AllowedContactsHoldAtOnce) {
  step();
  ASSERT_EQ(said_.pairs.size(), 1U);
  EXPECT_FALSE(said_.pairs[0].allowed);
  requests_.changeAllowedContacts({false, {}, {allowed("cloth", "cable")}});
  give(0, 50.25);
  step();
  EXPECT_TRUE(said_.pairs[0].allowed);
}

TEST_F(ChangesTest, WhatIsHeldMayTouchAtOnceAndAfterAReset) {
  parameters_.pair_classes = {true, false, false, false};
  const auto one = robot(2);
  robot_source_ = [&] { return one; };
  const auto allowed_pairs = [this] {
    std::vector<std::pair<BodyId, BodyId>> pairs;
    for (const MonitoredPair& pair : said_.pairs) {
      if (pair.allowed) pairs.emplace_back(pair.a, pair.b);
    }
    return pairs;
  };
  using Pairs = std::vector<std::pair<BodyId, BodyId>>;
  step();
  EXPECT_EQ(allowed_pairs(), Pairs());
  requests_.attach("cloth", {"link1"});
  step();
  EXPECT_EQ(allowed_pairs(), (Pairs{{1, 2}}));
  EXPECT_EQ(said_.rules.attached, std::vector<std::string>{"cloth by link1"});
  requests_.requestReset();
  step();
  give(0, 50.25);
  step();
  EXPECT_EQ(allowed_pairs(), (Pairs{{1, 2}})) << "it is a rule, not data";
  requests_.attach("cloth", {});
  step();
  EXPECT_EQ(allowed_pairs(), Pairs());
  EXPECT_TRUE(said_.rules.attached.empty());
}

TEST_F(ChangesTest, ANewMarginAndKnobsHoldFromTheNextCycleOn) {
  parameters_.objects[1].shares_margin = true;
  give(0, 50);
  give(1, 50);
  step();
  EXPECT_EQ(detector_.margins_m, (std::vector<float>{0, 0}));
  LiveParameters live = startValues(parameters_);
  live.margin_m = 0.5;
  live.near_pairs = true;
  live.marker_rate_hz = 3;
  live.predicates = Predicates::kConservative;
  live.overlap = 0.25;
  live.clusters = 7;
  live.iterations = 2;
  live.refresh_period = 9;
  give(0, 50.25);
  at_cycle_ = [&] { requests_.change(live); };
  EXPECT_EQ(step(), Lines{"cycle 50.25: *cloth@50.25 cable@50"});
  EXPECT_EQ(detector_.margins_m, (std::vector<float>{0, 0})) << "a cycle in flight stays as it is";
  EXPECT_EQ(detector_.options.predicates, Predicates::kExact);
  EXPECT_FALSE(detector_.options.near_pairs);
  give(0, 50.375);
  EXPECT_EQ(step(), (Lines{"markers at 3", "cycle 50.375: *cloth@50.375 cable@50"}));
  EXPECT_EQ(detector_.margins_m, (std::vector<float>{0, 0.5F})) << "the cloth has its own";
  EXPECT_EQ(detector_.options.predicates, Predicates::kConservative);
  EXPECT_TRUE(detector_.options.near_pairs);
  EXPECT_EQ(detector_.options.overlap, 0.25F);
  EXPECT_EQ(detector_.options.clusters, 7);
  EXPECT_EQ(detector_.options.iterations, 2);
  EXPECT_EQ(detector_.options.refresh_period, 9);
}

TEST_F(ChangesTest, ANewRateHoldsFromTheLastCycleOn) {
  parameters_.max_rate_hz = 1;
  give(0, 50);
  step();
  give(0, 50.125);
  EXPECT_EQ(stepAfter(250), Lines());
  LiveParameters live = startValues(parameters_);
  live.max_rate_hz = 2;
  requests_.change(live);
  EXPECT_EQ(stepAfter(125), Lines{"markers at 10"});
  EXPECT_EQ(sleepMs(), 125);
  EXPECT_EQ(stepAfter(125), Lines{"cycle 50.125: *cloth@50.125 cable(no mesh yet)"});
  live.max_rate_hz = 0;
  requests_.change(live);
  give(0, 50.25);
  EXPECT_EQ(step(), (Lines{"markers at 10", "cycle 50.25: *cloth@50.25 cable(no mesh yet)"}));
}

TEST_F(ChangesTest, ClassesThatAreSwitchedOnAndOffListTheirPairs) {
  parameters_.pair_classes = {true, false, false, false};
  const auto two = robot(2);
  robot_source_ = [&] { return two; };
  const auto pairs = [this] {
    std::vector<std::pair<BodyId, BodyId>> pairs;
    for (const MonitoredPair& pair : said_.pairs) pairs.emplace_back(pair.a, pair.b);
    return pairs;
  };
  using Pairs = std::vector<std::pair<BodyId, BodyId>>;
  step();
  ASSERT_EQ(pairs(), (Pairs{{0, 2}, {0, 3}, {1, 2}, {1, 3}}));
  LiveParameters live = startValues(parameters_);
  live.pair_classes = {false, false, true, true};
  requests_.change(live);
  ros_time_ = ros::Time(50);
  addTransform(&transforms_, "link0", 50);
  addTransform(&transforms_, "link1", 50);
  EXPECT_EQ(step(), (Lines{"markers at 10", "cycle 50: *link0@50 *link1@50 cloth cable"}));
  EXPECT_EQ(pairs(), (Pairs{{0, 1}, {2, 2}, {3, 3}}));
  live.pair_classes = {false, true, false, false};
  requests_.change(live);
  addTransform(&transforms_, "link0", 50.25);
  addTransform(&transforms_, "link1", 50.25);
  EXPECT_EQ(stepAfter(200), Lines{"markers at 10"}) << "the robot has no cycles any more";
  EXPECT_EQ(pairs(), (Pairs{{2, 3}}));
}

TEST_F(ChangesTest, AClockThatGoesBackResets) {
  give(0, 50);
  step();
  ros_time_ = ros::Time(49.95);
  EXPECT_EQ(step(), Lines()) << "a small step";
  ros_time_ = ros::Time(40.95);
  const std::string reason = "time jump: the clock went back by 9.000000 s";
  EXPECT_EQ(step(), (Lines{"forget all: " + reason, "reset: " + reason}));
  EXPECT_EQ(step(), Lines());
  ros_time_ = ros::Time(50);
  EXPECT_EQ(stepAfter(1000), (Lines{"forget all: no new mesh",
                                    "heartbeat 50: cloth(no mesh yet) cable(no mesh yet)"}));
}

TEST_F(ChangesTest, WhatACycleFoundBeforeTheClockWentBackIsNotKnown) {
  give(0, 50);
  at_cycle_ = [this] { ros_time_ = ros::Time(40); };
  EXPECT_EQ(
      step(),
      Lines{"cycle 50: *cloth@50(time jump: the clock went back during the cycle) cable(no mesh "
            "yet)"});
  give(1, 40);
  at_cycle_ = [this] { ros_time_ = ros::Time(39.95); };
  EXPECT_EQ(step().back(), "cycle 40: cloth(no mesh yet) *cable@40") << "a small step";
}

TEST_F(ChangesTest, ForHalfASecondAfterAJumpMeshesFromBeforeAreDropped) {
  step();
  ros_time_ = ros::Time(40);
  step();
  give(0, 50);
  EXPECT_EQ(stepAfter(499), Lines());
  EXPECT_FALSE(meshes()[0].hasWaiting());
  give(0, 40);
  EXPECT_EQ(step(), Lines{"cycle 40: *cloth@40 cable(no mesh yet)"}) << "it is from after the jump";
  give(1, 40.5);
  EXPECT_EQ(stepAfter(1), Lines{"cycle 40.5: cloth@40 *cable@40.5"}) << "the half second is over";
}

// tf2 would interpolate between it and one of the new time.
TEST_F(ChangesTest, ATransformFromBeforeTheJumpIsLeftOutForHalfASecond) {
  step();
  ros_time_ = ros::Time(49.5);
  step();
  const auto arrives = [this](double stamp_s, double angle = 0) {
    return transforms_.add(transformAt("camera", stamp_s, angle), "test", false, steady_time_);
  };
  EXPECT_TRUE(arrives(49.5));
  EXPECT_FALSE(arrives(50, 1.5)) << "it was under way when the clock jumped";
  EXPECT_TRUE(arrives(49.59)) << "clocks differ a little";
  EXPECT_TRUE(transforms_.add(transformAt("lens", 60), "test", true, steady_time_)) << "static";
  EXPECT_TRUE(transforms_.canTransform("base", "camera", ros::Time(49.5625)));
  EXPECT_FALSE(transforms_.canTransform("base", "camera", ros::Time(49.75)));
  steady_time_ += std::chrono::milliseconds(500);
  EXPECT_TRUE(arrives(50)) << "some publishers predict";
}

// A step may be a quarter of a second after the jump.
TEST_F(ChangesTest, TransformsBetweenAJumpAndTheNextStepStay) {
  step();
  ros_time_ = ros::Time(40);
  transforms_.lookAtClock(steady_time_);  // as whoever receives them does
  EXPECT_TRUE(transforms_.add(transformAt("camera", 40), "test", false, steady_time_));
  EXPECT_EQ(step().size(), 2U) << "it forgets and resets";
  EXPECT_TRUE(transforms_.canTransform("base", "camera", ros::Time(40)));
  requests_.requestReset();
  step();
  EXPECT_FALSE(transforms_.canTransform("base", "camera", ros::Time(40))) << "it was asked to";
}

// Meshes and states from before it would be joined with transforms from after it.
TEST_F(ChangesTest, AJumpThatIsOverAtTheNextStepResetsToo) {
  step();
  ros_time_ = ros::Time(49.75);
  transforms_.lookAtClock(steady_time_);
  ros_time_ = ros::Time(50);
  const std::string reason = "time jump: the clock went back";
  EXPECT_EQ(step(), (Lines{"forget all: " + reason, "reset: " + reason}));
  give(0, 50);
  at_cycle_ = [this] {
    for (const double now_s : {49.75, 50.0}) {
      ros_time_ = ros::Time(now_s);
      transforms_.lookAtClock(steady_time_);
    }
  };
  EXPECT_EQ(step(),
            Lines{"cycle 50: *cloth@50(" + reason + " during the cycle) cable(no mesh yet)"});
  EXPECT_EQ(step().size(), 2U) << "it forgets and resets";
}

TEST_F(ChangesTest, ANewRobotEndsContactsTheFirstOneDoesNot) {
  parameters_.pair_classes.robot_deformable = true;
  EXPECT_EQ(step(), Lines());
  const auto one = robot(1), two = robot(2);
  robot_source_ = [&] { return one; };
  EXPECT_EQ(step(), Lines{"robot of 1"});
  EXPECT_EQ(step(), Lines());
  robot_source_ = [&] { return two; };
  EXPECT_EQ(step(), (Lines{"forget all: robot changed", "robot of 2"}));
  EXPECT_EQ(detector_.resets, 2);
  EXPECT_EQ(stepAfter(1000),
            (Lines{"forget all: no new mesh",
                   "heartbeat 50: link0 link1 cloth(no mesh yet) cable(no mesh yet)"}));
}

}  // namespace
}  // namespace deformable_contact_monitor
