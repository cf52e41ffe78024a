// Tests of how long the detection loop waits for transforms, and which objects that delays.
#include <string>

#include "loop_fixture.h"

namespace deformable_contact_monitor {
namespace {

// The cloth is seen by a camera; the cable needs no transforms.
class TransformsTest : public LoopTest {
 protected:
  TransformsTest() { parameters_.tf_timeout_s = 0.125; }

  static std::string late(const std::string& wanted, const std::string& newest) {
    return "(TF from 'camera' to 'base' is late: wanted " + wanted + "00000000, newest available " +
           newest + "00000000)";
  }

  const std::string kLate = late("50.0", "49.5");
};

TEST_F(TransformsTest, TheWaitEndsAtTheTimeout) {
  addTransform(&transforms_, "camera", 49.5);
  give(0, 50, "camera");
  EXPECT_EQ(step(), Lines());
  EXPECT_LE(sleepMs(), 1) << "transforms wake nobody";
  EXPECT_GT(sleepMs(), 0);
  EXPECT_EQ(stepAfter(124), Lines());
  EXPECT_EQ(stepAfter(1),
            (Lines{"miss of cloth", "cycle 50: *cloth" + kLate + " cable(no mesh yet)"}));
  EXPECT_EQ(step(), Lines()) << "once";
}

TEST_F(TransformsTest, TheWaitEndsAsSoonAsTheTransformComes) {
  addTransform(&transforms_, "camera", 49.5);
  give(0, 50, "camera");
  EXPECT_EQ(step(), Lines());
  EXPECT_EQ(stepAfter(3), Lines());
  addTransform(&transforms_, "camera", 50);
  EXPECT_EQ(stepAfter(1), Lines{"cycle 50: *cloth@50 cable(no mesh yet)"});
}

// A simulator at a tenth of real time publishes transforms at 50 Hz of its own time, and meshes at
// 30 Hz of it. Two in three meshes wait for their transform, up to 200 ms of real time.
TEST_F(TransformsTest, ASlowSimulatorsMeshesAllHaveTheirTransforms) {
  parameters_.tf_timeout_s = 0.05;
  is_simulated_ = true;
  addTransform(&transforms_, "camera", 50);
  int cycles = 0;
  for (int ms = 1; ms <= 1000; ++ms) {
    const double stamp_s = 50 + ms / 1000.0;
    if (ms % 20 == 0) addTransform(&transforms_, "camera", stamp_s);
    if (ms % 33 == 7) give(0, stamp_s, "camera");
    for (const std::string& line : stepAfter(10, 1)) {
      ASSERT_EQ(line.compare(0, 6, "cycle "), 0) << line;
      EXPECT_NE(line.find("*cloth@"), std::string::npos) << line;
      EXPECT_EQ(line.find("*cloth("), std::string::npos) << line;
      ++cycles;
    }
  }
  EXPECT_EQ(cycles, 31);
}

TEST_F(TransformsTest, AClockThatStandsStillEndsNoWaitForLong) {
  is_simulated_ = true;
  addTransform(&transforms_, "camera", 49.5);
  give(0, 50, "camera");
  EXPECT_EQ(stepAfter(0, 0), Lines());
  EXPECT_EQ(stepAfter(4999, 0), Lines());
  EXPECT_EQ(stepAfter(1, 0).back(), "cycle 50: *cloth" + kLate + " cable(no mesh yet)");
}

TEST_F(TransformsTest, AFastClockLeavesTransformsTheirTimeToCome) {
  is_simulated_ = true;
  addTransform(&transforms_, "camera", 49.5);
  give(0, 50, "camera");
  EXPECT_EQ(stepAfter(0, 0), Lines());
  EXPECT_EQ(stepAfter(20, 200), Lines());
  addTransform(&transforms_, "camera", 50);
  EXPECT_EQ(stepAfter(1, 10), Lines{"cycle 50: *cloth@50 cable(no mesh yet)"});
}

TEST_F(TransformsTest, OthersHaveTheirTurnsMeanwhile) {
  addTransform(&transforms_, "camera", 49.5);
  give(0, 50, "camera");
  EXPECT_EQ(step(), Lines());
  for (int i = 0; i < 4; ++i) {
    give(1, 50 + i / 64.0);
    const Lines said = stepAfter(16);
    ASSERT_FALSE(said.empty()) << i;
    EXPECT_NE(said.back().find("*cable@"), std::string::npos) << said.back();
    EXPECT_EQ(said.back().find("*cloth"), std::string::npos) << said.back();
  }
  EXPECT_EQ(stepAfter(60), Lines());
  EXPECT_EQ(stepAfter(1), (Lines{"miss of cloth", "cycle 50: *cloth" + kLate + " cable@50"}))
      << "125 ms after it came, whatever others did";
}

// Objects with equal stamps share a cycle, but one that is ready does not wait for the other.
TEST_F(TransformsTest, WhoHasTheStampOfOneThatWaitsDoesNotWaitForIt) {
  addTransform(&transforms_, "camera", 49.5);
  give(0, 50, "camera");
  give(1, 50);
  EXPECT_EQ(step().back(), "cycle 50: cloth" + kLate + " *cable@50");
}

TEST_F(TransformsTest, AFrameThatStandsStillIsWaitedForOnce) {
  addTransform(&transforms_, "camera", 49.5);
  give(0, 50, "camera");
  EXPECT_EQ(step(), Lines());
  EXPECT_EQ(stepAfter(125).size(), 2U);
  give(0, 50.5, "camera");
  EXPECT_EQ(step(), (Lines{"miss of cloth",
                           "cycle 50.5: *cloth" + late("50.5", "49.5") + " cable(no mesh yet)"}))
      << "at once";
  addTransform(&transforms_, "camera", 50.5);
  give(0, 50.75, "camera");
  EXPECT_EQ(step(), Lines()) << "it moves again";
  addTransform(&transforms_, "camera", 51);
  EXPECT_EQ(stepAfter(1), Lines{"cycle 50.75: *cloth@50.75 cable(no mesh yet)"});
}

TEST_F(TransformsTest, AFrameThatWasNeverSeenIsNotWaitedFor) {
  addTransform(&transforms_, "arm", 50);
  give(0, 50, "camera");
  EXPECT_EQ(step(), (Lines{"miss of cloth",
                           "cycle 50: *cloth(TF frame 'camera' never seen)"
                           " cable(no mesh yet)"}));
}

TEST_F(TransformsTest, WhatWasSeenBeforeAResetIsWaitedFor) {
  addTransform(&transforms_, "camera", 50);
  give(0, 50, "camera");
  EXPECT_EQ(step().size(), 1U);
  requests_.requestReset();
  ros_time_ = ros::Time(50.25);
  step();
  give(0, 50.25, "camera");
  EXPECT_EQ(step(), Lines()) << "its transform is on its way";
  addTransform(&transforms_, "camera", 50.25);
  EXPECT_EQ(stepAfter(1), Lines{"cycle 50.25: *cloth@50.25 cable(no mesh yet)"});
}

// The mesh that waits has its cycle first, and then the one that came meanwhile.
TEST_F(TransformsTest, ANewerMeshDoesNotProlongTheWait) {
  addTransform(&transforms_, "camera", 49.5);
  give(0, 50, "camera");
  EXPECT_EQ(step(), Lines());
  give(0, 50.25, "camera");
  EXPECT_EQ(stepAfter(124), Lines());
  EXPECT_EQ(stepAfter(1).back(), "cycle 50: *cloth" + kLate + " cable(no mesh yet)");
  EXPECT_EQ(step().back().substr(0, 11), "cycle 50.25");
}

TEST_F(TransformsTest, MissesAreSaidOnceASecond) {
  parameters_.tf_timeout_s = 0;
  addTransform(&transforms_, "camera", 49.5);
  step();
  const auto warnings = [this](int ms) {
    ::testing::internal::CaptureStderr();
    give(0, 50, "camera");
    EXPECT_EQ(stepAfter(ms).front(), "miss of cloth");
    const std::string text = ::testing::internal::GetCapturedStderr();
    const bool is_said = text.find("UNKNOWN for want of a transform:\n  cloth: TF from 'camera'") !=
                         std::string::npos;
    EXPECT_EQ(text.empty(), !is_said) << text;
    return is_said;
  };
  EXPECT_TRUE(warnings(0));
  EXPECT_FALSE(warnings(500));
  EXPECT_FALSE(warnings(499));
  EXPECT_TRUE(warnings(1));
}

}  // namespace
}  // namespace deformable_contact_monitor
