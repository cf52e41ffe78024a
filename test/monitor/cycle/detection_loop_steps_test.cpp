// Tests of continuous collision detection in the detection loop: where its time intervals begin,
// which pairs they have, when there is none, and what their detection does.
#include <chrono>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "steps_fixture.h"

namespace deformable_contact_monitor {
namespace {

TEST_F(StepsTest, InstantMotionHasNone) {
  parameters_.motion = Motion::kInstant;
  for (const double stamp : {50.0, 50.125}) {
    give(0, stamp);
    give(1, stamp);
    step();
    EXPECT_EQ(steps(), Lines());
  }
}

TEST_F(StepsTest, TheFirstCycleHasNone) {
  give(0, 50);
  give(1, 50);
  step();
  EXPECT_EQ(steps(), Lines{"0 of cloth cable: cloth/cable (cloth: its first cycle) (cable: its "
                           "first cycle)"});
}

TEST_F(StepsTest, WhatPassesBetweenTwoCyclesIsFound) {
  give(0, 50);
  give(1, 50, "base", -1);
  step();
  EXPECT_FALSE(stamp_touches_);
  give(0, 50.125);
  give(1, 50.125, "base", 1);
  step();
  EXPECT_FALSE(stamp_touches_);
  EXPECT_EQ(steps(), Lines{"50 of cloth cable: cloth/cable"});
  EXPECT_EQ(found_, Lines{"cloth/cable"});
  EXPECT_EQ(earlierZ(1), -1);
}

// Of a pair of objects, each cycle of either begins where the one before it ended.
TEST_F(StepsTest, APairsStepsJoinWithoutGaps) {
  give(0, 50, "base", 0);
  give(1, 50, "base", 1);
  step();
  give(1, 50.0625, "base", 2);
  step();
  EXPECT_EQ(steps(), Lines{"50 of cable: cloth/cable"});
  EXPECT_EQ(earlierZ(1), 1);
  give(1, 50.125, "base", 3);
  step();
  EXPECT_EQ(earlierZ(1), 2);
  give(0, 50.125, "base", 5);
  step();
  EXPECT_EQ(steps(), (Lines{"50 of cloth:", "50.125 of: cloth/cable"}))
      << "the cable's cycle was the last of the two, and that is no step of the cloth";
  give(0, 50.1875, "base", 6);
  step();
  EXPECT_EQ(steps(), Lines{"50.125 of cloth: cloth/cable"});
  EXPECT_EQ(earlierZ(0), 5);
  EXPECT_TRUE(std::isnan(earlierZ(1))) << "it stood still";
}

// The cable sinks through the cloth while that stands still, and the cloth then sinks through the
// cable. In between the cable has a cycle of its own below the cloth.
TEST_F(StepsTest, ObjectsWhoseCyclesTakeTurnsDoNotPassUnseen) {
  give(0, 50, "base", 0);
  give(1, 50, "base", 1);
  step();
  give(1, 50.0625, "base", -1);
  step();
  EXPECT_EQ(found_, Lines{"cloth/cable"});
  give(0, 50.125, "base", -3);
  step();
  EXPECT_EQ(found_, Lines{"cloth/cable"});
  EXPECT_FALSE(stamp_touches_);
}

// A cycle of the partner that is ahead of this one, or did not know both, begins nothing.
TEST_F(StepsTest, APartnersLaterStampBeginsNothing) {
  give(0, 50);
  give(1, 50);
  step();
  give(1, 50.125);
  step();
  give(0, 50.0625);
  step();
  EXPECT_EQ(steps(), Lines{"50 of cloth: cloth/cable"});
}

// Nobody knows what happened in the step of a cycle whose states were lost, even if the state of a
// pair is of a later stamp, because the other object's clock is ahead.
TEST_F(StepsTest, AfterACycleThatCouldNotBePublishedTheStepBeginsWhereItsStepBegan) {
  give(0, 50, "base", 0);
  give(1, 50, "base", 1);
  step();
  give(0, 50.125, "base", 0);
  step();
  const auto publish =
      std::exchange(said_.at_result, [](const CycleReport& /*report*/) { throw std::bad_alloc(); });
  give(1, 50.0625, "base", -1);
  step();
  EXPECT_EQ(steps(), Lines{"50 of cable: cloth/cable"});
  said_.at_result = publish;
  give(1, 50.1875, "base", -2);
  step();
  EXPECT_EQ(steps(), (Lines{"50 of cable:", "50.125 of: cloth/cable"}))
      << "the cloth's cycle saw the cable above it";
  EXPECT_EQ(found_, Lines{"cloth/cable"});
}

TEST_F(StepsTest, ObjectsOfOneCycleWithDifferentPreviousOnesHaveAStepEach) {
  parameters_.pair_classes = {false, true, true, false};
  give(0, 50);
  step();
  give(1, 50.0625);
  step();
  give(0, 50.125);
  give(1, 50.125);
  step();
  EXPECT_EQ(steps(),
            (Lines{"50 of cloth: cloth/cloth", "50.0625 of cable: cloth/cable cable/cable"}))
      << "of the pair between them, the later is the previous cycle";
  EXPECT_EQ(said_.enabled, (std::vector<std::pair<BodyId, BodyId>>{{0, 0}, {0, 1}, {1, 1}}))
      << "the scene's pairs are the cycle's again";
  give(0, 50.25);
  give(1, 50.25);
  step();
  EXPECT_EQ(steps(), Lines{"50.125 of cloth cable: cloth/cloth cloth/cable cable/cable"});
}

TEST_F(StepsTest, OnlyPairsOfThoseWhoseCycleItIsHaveOne) {
  parameters_.pair_classes = {false, true, true, false};
  for (const double stamp : {50.0, 50.125}) {
    give(0, stamp);
    give(1, stamp);
    step();
  }
  give(1, 50.1875);
  step();
  EXPECT_EQ(steps(), Lines{"50.125 of cable: cloth/cable cable/cable"});
}

TEST_F(StepsTest, AfterALongGapThereIsNone) {
  give(0, 50);
  step();
  ros_time_ = ros::Time(50.5);
  give(0, 50.5);
  step();
  EXPECT_EQ(steps(), Lines{"50 of cloth:"}) << "max_mesh_age_s, no longer";
  ros_time_ = ros::Time(51.03125);
  give(0, 51.03125);
  step();
  EXPECT_EQ(steps(), Lines{"0 of cloth: (cloth: its previous cycle is 0.531250 s older, more than "
                           "max_mesh_age_s)"});
}

TEST_F(StepsTest, AfterAResetThereIsNone) {
  give(0, 50);
  step();
  requests_.requestReset();
  give(0, 50.0625);
  step();
  EXPECT_EQ(steps(), Lines{"0 of cloth: (cloth: reset)"});
}

TEST_F(StepsTest, AfterItWasDisabledThereIsNone) {
  give(0, 50);
  step();
  requests_.setEnabled(false);
  step();
  requests_.setEnabled(true);
  give(0, 50.125);
  step();
  EXPECT_EQ(steps(), Lines{"0 of cloth: (cloth: it was disabled)"});
}

TEST_F(StepsTest, AfterItWasDisabledForAMomentThereIsNone) {
  give(0, 50);
  step();
  requests_.setEnabled(false);
  requests_.setEnabled(true);
  step();
  give(0, 50.125);
  step();
  EXPECT_EQ(steps(), Lines{"0 of cloth: (cloth: it was disabled)"});
}

TEST_F(StepsTest, AfterTheClockWentBackThereIsNone) {
  give(0, 50);
  step();
  ros_time_ = ros::Time(40);
  step();
  give(0, 40);
  step();
  ASSERT_EQ(steps().size(), 1U);
  EXPECT_EQ(steps()[0].substr(0, 35), "0 of cloth: (cloth: time jump: the ");
}

TEST_F(StepsTest, AfterAnObjectsStampsWentBackItAloneHasNone) {
  give(0, 50);
  give(1, 50);
  step();
  give(0, 49.25);
  give(1, 50.125);
  ros_time_ = ros::Time(49.5);
  step();
  step();
  give(0, 49.375);
  step();
  EXPECT_EQ(steps(), Lines{"49.25 of cloth:"});
}

TEST_F(StepsTest, OfOtherTrianglesThereIsNone) {
  give(0, 50);
  give(1, 50);
  step();
  give(0, 50.125, "base", 0, 4);
  give(1, 50.125);
  step();
  EXPECT_EQ(steps(), (Lines{"0 of cloth: (cloth: other triangles than in the previous cycle)",
                            "50 of cable: cloth/cable (cloth: other triangles than in the previous "
                            "cycle)"}));
  EXPECT_EQ(found_, Lines());
  give(0, 50.25, "base", 0, 4);
  step();
  EXPECT_EQ(steps(), Lines{"50.125 of cloth: cloth/cable"});
}

TEST_F(StepsTest, APartnerThatWasNotThereCostsItsPairsAlone) {
  parameters_.pair_classes = {false, true, true, false};
  give(0, 50);
  step();
  give(1, 50.125);
  give(0, 50.125);
  step();
  EXPECT_EQ(steps(), (Lines{"0 of cable: cable/cable (cable: its first cycle)",
                            "50 of cloth: cloth/cloth cloth/cable (cable: not known in the "
                            "previous cycle)"}));
  EXPECT_EQ(found_, Lines());
}

TEST_F(StepsTest, AnObjectThatWasNotKnownItselfHasNone) {
  addTransform(&transforms_, "camera", 50);
  give(0, 50, "lens");
  step();
  addTransform(&transforms_, "lens", 50);
  addTransform(&transforms_, "lens", 51);
  give(0, 50.125, "lens");
  step();
  EXPECT_EQ(steps(), Lines{"0 of cloth: (cloth: not known in the previous cycle)"});
}

TEST_F(StepsTest, AnotherFrameThanBeforeHasNone) {
  addTransform(&transforms_, "camera", 50);
  addTransform(&transforms_, "camera", 51);
  give(0, 50);
  step();
  give(0, 50.125, "camera");
  step();
  EXPECT_EQ(steps(), Lines{"0 of cloth: (cloth: another frame than in the previous cycle)"});
}

// The robot's first cycle has no interval, nor has the first one after the robot has changed.
TEST_F(StepsTest, OfAnotherRobotThereIsNone) {
  useRobot(1);
  parameters_.pair_classes = {true, false, false, false};
  addTransform(&transforms_, "link0", 50);
  addTransform(&transforms_, "link1", 50);
  addTransform(&transforms_, "link0", 51);
  addTransform(&transforms_, "link1", 51);
  give(0, 50);
  step();
  useRobot(2);
  give(0, 50.125);
  step();
  EXPECT_EQ(steps(), Lines{"0 of cloth: link0/cloth link1/cloth (cloth: the robot changed)"});
}

// The fake detector's script decides how the detection of an interval ends.
class StepDetectionTest : public StepsTest {
 protected:
  StepDetectionTest() {
    make_detector_ = [this] { return std::make_unique<FakeDetector>(&detector_); };
    give(0, 50);
    give(1, 50);
    step();
    give(0, 50.125);
    give(1, 50.125);
  }
};

TEST_F(StepDetectionTest, ItIsAskedWithTheSameDeadlineAndWithTimes) {
  step();
  EXPECT_EQ(detector_.options.motion, Motion::kSwept);
  EXPECT_TRUE(detector_.options.first_times);
  EXPECT_FALSE(detector_.options.nearest) << "distances are those of the stamp";
  EXPECT_EQ(detector_.deadline, steady_time_ + std::chrono::seconds(1));
}

TEST_F(StepDetectionTest, OneThatFailsCostsTheStepAlone) {
  detector_.step_failure = "no memory";
  EXPECT_EQ(step(), (Lines{"error: of a step: no memory",
                           "cycle 50.125: *cloth@50.125 "
                           "*cable@50.125"}));
  ASSERT_EQ(said_.sweeps.size(), 1U);
  EXPECT_EQ(said_.sweeps[0].problem, "no memory");
  EXPECT_EQ(said_.sweeps[0].result, nullptr);
  EXPECT_EQ(said_.enabled, (std::vector<std::pair<BodyId, BodyId>>{{0, 1}}));
}

TEST_F(StepDetectionTest, OneThatRunsOutOfTimeIsAnOverrun) {
  detector_.step_out_of_time = true;
  bool is_out_of_time = false;
  said_.at_result = [&](const CycleReport& report) { is_out_of_time = isOutOfTime(report); };
  step();
  EXPECT_TRUE(is_out_of_time);
  give(0, 50.25);
  step();
  EXPECT_EQ(detector_.deadline, steady_time_ + std::chrono::milliseconds(250))
      << "less the next time";
}

}  // namespace
}  // namespace deformable_contact_monitor
