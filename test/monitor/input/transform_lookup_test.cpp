// Tests of poses at a stamp: their matrix, and the reason that is given if there is no pose.
#include "monitor/input/transform_lookup.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <string>

namespace deformable_contact_monitor {
namespace {

using Outcome = PoseAnswer::Outcome;

geometry_msgs::TransformStamped transform(const std::string& parent, const std::string& child,
                                          double stamp_s, double x = 0) {
  geometry_msgs::TransformStamped t;
  t.header.frame_id = parent;
  t.header.stamp = ros::Time(stamp_s);
  t.child_frame_id = child;
  t.transform.translation.x = x;
  t.transform.rotation.w = 1;
  return t;
}

class TransformLookupTest : public ::testing::Test {
 protected:
  void set(const geometry_msgs::TransformStamped& t, bool is_static = false) {
    ASSERT_TRUE(buffer_.add(t, "test", is_static, steady_time_));
  }

  PoseAnswer ask(const std::string& frame, double stamp_s) {
    return lookup_.lookup({{frame, ros::Time(stamp_s)}}).at(0);
  }
  bool isWorthWaiting(const std::string& frame, double stamp_s) const {
    return lookup_.isWorthWaiting({{frame, ros::Time(stamp_s)}});
  }

  const SteadyTime steady_time_;
  TransformBuffer buffer_{[] { return ros::Time(10); }};
  TransformLookup lookup_{buffer_, "base"};
};

TEST_F(TransformLookupTest, ProposesThePrefixOfFramesThatAreThere) {
  const auto problem = [this](const std::string& frame, const std::string& link) {
    return lookup_.lookup({{frame, ros::Time(5), link}}).at(0).problem;
  };
  set(transform("base", "left/hand", 5));
  set(transform("base", "forearm", 5));
  EXPECT_EQ(problem("hand", "hand"),
            "TF frame 'hand' never seen; there is 'left/hand': set frame_prefix to 'left/'");
  EXPECT_EQ(problem("x/hand", "hand"),
            "TF frame 'x/hand' never seen; there is 'left/hand': set frame_prefix to 'left/'");
  EXPECT_EQ(problem("arm", "arm"), "TF frame 'arm' never seen") << "the end of a word is no link";
  EXPECT_EQ(problem("hand", ""), "TF frame 'hand' never seen") << "an object's frame has no prefix";
  EXPECT_EQ(problem("left/hand", "hand"), "");
  set(transform("base", "right_hand", 5));
  EXPECT_EQ(problem("hand", "hand"),
            "TF frame 'hand' never seen; there is 'left/hand', 'right_hand': set frame_prefix to "
            "'left/' or 'right_'");
}

TEST_F(TransformLookupTest, ProposesAReferenceFrame) {
  set(transform("left/base", "left/hand", 5));
  EXPECT_EQ(lookup_.lookup({{"left/hand", ros::Time(5), "hand"}}).at(0).problem,
            "TF frame 'base' never seen; there is 'left/base': set reference_frame to it");
}

TEST(ToRigidTransform, IsTheRotationOfTheQuaternion) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 1000; ++i) {
    geometry_msgs::Transform t;
    t.rotation.x = normal(random);
    t.rotation.y = normal(random);
    t.rotation.z = normal(random);
    t.rotation.w = normal(random);
    t.translation.x = normal(random);
    const RigidTransform pose = toRigidTransform(t);
    const Eigen::Quaterniond q(t.rotation.w, t.rotation.x, t.rotation.y, t.rotation.z);
    const Eigen::Matrix3d expected = q.normalized().toRotationMatrix();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        EXPECT_NEAR(pose.rotation[3 * row + column], expected(row, column), 1e-14);
      }
    }
    EXPECT_EQ(pose.translation[0], t.translation.x);
  }
}

TEST(ToRigidTransform, UnitQuaternionsGiveExactMatrices) {
  geometry_msgs::Transform t;
  t.rotation.w = 1;
  EXPECT_TRUE(toRigidTransform(t).isIdentity());
  t.rotation.w = 0;
  t.rotation.z = 1;  // half a turn
  const RigidTransform pose = toRigidTransform(t);
  EXPECT_EQ(pose.rotation[0], -1);
  EXPECT_EQ(pose.rotation[1], 0);
  EXPECT_EQ(pose.rotation[8], 1);
}

TEST_F(TransformLookupTest, FoundAtTheStampItself) {
  set(transform("base", "arm", 10, 1));
  set(transform("base", "arm", 11, 3));
  const PoseAnswer answer = ask("arm", 10.5);
  EXPECT_EQ(answer.outcome, Outcome::kFound);
  EXPECT_DOUBLE_EQ(answer.pose.translation[0], 2);
  EXPECT_TRUE(answer.problem.empty());
}

TEST_F(TransformLookupTest, StaticAtAnyStamp) {
  set(transform("base", "arm", 10, 4), true);
  EXPECT_EQ(ask("arm", 1e6).outcome, Outcome::kFound);
}

TEST_F(TransformLookupTest, LateNamesWantedAndAvailable) {
  set(transform("base", "arm", 10));
  const PoseAnswer answer = ask("arm", 10.5);
  EXPECT_EQ(answer.outcome, Outcome::kLate);
  EXPECT_EQ(answer.available, ros::Time(10));
  for (const char* text :
       {"arm", "base", "late", "wanted 10.500000000", "available 10.000000000"}) {
    EXPECT_NE(answer.problem.find(text), std::string::npos) << text << ": " << answer.problem;
  }
}

TEST_F(TransformLookupTest, PastIsNotLate) {
  set(transform("base", "arm", 10));
  EXPECT_EQ(ask("arm", 9).outcome, Outcome::kPast);
}

TEST_F(TransformLookupTest, NeverSeenIsNotWaitedFor) {
  set(transform("base", "arm", 10));
  set(transform("island", "palm", 10));
  const PoseAnswer unknown = ask("ghost", 10);
  EXPECT_EQ(unknown.outcome, Outcome::kNever);
  EXPECT_NE(unknown.problem.find("'ghost' never seen"), std::string::npos) << unknown.problem;
  const PoseAnswer apart = ask("palm", 10);
  EXPECT_EQ(apart.outcome, Outcome::kNever);
  EXPECT_NE(apart.problem.find("'palm' to 'base' never seen"), std::string::npos) << apart.problem;
  EXPECT_FALSE(isWorthWaiting("ghost", 10) || isWorthWaiting("palm", 10));
}

TEST_F(TransformLookupTest, LateIsWorthWaitingFor) {
  set(transform("base", "arm", 10, 1));
  EXPECT_TRUE(isWorthWaiting("arm", 10.5));
  EXPECT_FALSE(isWorthWaiting("arm", 10)) << "it is there";
  EXPECT_FALSE(isWorthWaiting("arm", 9)) << "it will not come any more";
  set(transform("base", "arm", 11, 3));
  EXPECT_FALSE(isWorthWaiting("arm", 10.5));
}

TEST_F(TransformLookupTest, AFrameThatStandsStillIsNotWaitedForAgain) {
  set(transform("base", "arm", 10));
  set(transform("base", "hand", 11));
  lookup_.giveUp({{"arm", ros::Time(10.5)}, {"hand", ros::Time(10.5)}, {"ghost", ros::Time(10)}});
  EXPECT_FALSE(isWorthWaiting("arm", 10.5) || isWorthWaiting("arm", 12));
  EXPECT_TRUE(isWorthWaiting("hand", 12)) << "it was not late then";
  set(transform("base", "arm", 10.1));
  EXPECT_TRUE(isWorthWaiting("arm", 10.5)) << "it moves again";
}

TEST_F(TransformLookupTest, WhatWasThereBeforeAResetIsLateUntilItIsThereAgain) {
  set(transform("base", "arm", 10));
  set(transform("arm", "hand", 10));
  set(transform("island", "palm", 10));
  lookup_.giveUp({{"hand", ros::Time(11)}});
  for (const char* reset : {"one", "another before anything came"}) {
    buffer_.forget(SteadyTime::min());
    lookup_.noteReset();
    const PoseAnswer answer = ask("hand", 10);
    EXPECT_EQ(answer.outcome, Outcome::kLate) << reset;
    EXPECT_TRUE(answer.available.isZero());
    EXPECT_NE(answer.problem.find("is late: wanted 10.000000000, none available yet"),
              std::string::npos)
        << answer.problem;
    EXPECT_TRUE(isWorthWaiting("hand", 10));
    lookup_.giveUp({{"hand", ros::Time(10)}});
    EXPECT_FALSE(isWorthWaiting("hand", 10) || isWorthWaiting("hand", 11)) << "it was, in vain";
  }
  EXPECT_EQ(ask("palm", 10).outcome, Outcome::kNever) << "it had no way to the base";
  EXPECT_EQ(ask("ghost", 10).outcome, Outcome::kNever);
  set(transform("arm", "hand", 11));
  EXPECT_EQ(ask("hand", 11).outcome, Outcome::kLate) << "its parent is not there yet";
  set(transform("base", "arm", 11));
  EXPECT_EQ(ask("hand", 11).outcome, Outcome::kFound);
  EXPECT_EQ(ask("hand", 10).outcome, Outcome::kPast);
  EXPECT_TRUE(isWorthWaiting("hand", 12)) << "it moves";
}

// Then the newest transforms make a circle.
TEST_F(TransformLookupTest, AnEdgeThatWasTurnedAroundConnectsFrames) {
  set(transform("odom", "base", 10));
  set(transform("base", "arm", 10));
  set(transform("base", "odom", 11));
  buffer_.forget(SteadyTime::min());
  EXPECT_EQ(ask("arm", 12).outcome, Outcome::kLate);
  EXPECT_EQ(ask("odom", 12).outcome, Outcome::kLate);
  EXPECT_EQ(ask("ghost", 12).outcome, Outcome::kNever);
}

TEST_F(TransformLookupTest, OneLateFrameCostsNoOtherItsPose) {
  set(transform("base", "arm", 10));
  set(transform("base", "hand", 11));
  set(transform("base", "hand", 12));
  const std::vector<PoseAnswer> all =
      lookup_.lookup({{"arm", ros::Time(11)}, {"hand", ros::Time(11)}, {"ghost", ros::Time(11)}});
  EXPECT_EQ(all[0].outcome, Outcome::kLate);
  EXPECT_EQ(all[1].outcome, Outcome::kFound);
  EXPECT_EQ(all[2].outcome, Outcome::kNever);
}

TEST_F(TransformLookupTest, TheNewestCommonStampIsThatOfTheSlowestThatMoves) {
  const auto newest = [this](const std::vector<std::string>& frames, double now_s = 0) {
    return lookup_.newestCommon(frames, 0.5, ros::Time(now_s));
  };
  EXPECT_FALSE(newest({"arm", "hand"})) << "nothing is known";
  set(transform("base", "wall", 10), true);
  EXPECT_EQ(newest({"wall", "ghost"}), ros::Time()) << "always";
  set(transform("base", "arm", 10));
  set(transform("base", "hand", 10.25));
  EXPECT_EQ(newest({"arm", "hand", "wall", "ghost"}), ros::Time(10));
  set(transform("base", "hand", 10.75));
  EXPECT_EQ(newest({"arm", "hand"}), ros::Time(10.75)) << "the arm has stopped";
  EXPECT_EQ(newest({"arm", "hand"}, 10.5), ros::Time(10)) << "the hand is ahead";
  EXPECT_EQ(newest({"arm", "hand"}, 10.625), ros::Time(10.75)) << "the arm has stopped";
  EXPECT_EQ(newest({"arm", "hand"}, 9), ros::Time(10)) << "both are";
  const auto later = [this](double after_s) {
    return lookup_.newestCommon({"arm", "hand"}, 5, ros::Time(11), ros::Time(after_s));
  };
  EXPECT_EQ(later(9), ros::Time(10));
  EXPECT_EQ(later(10), ros::Time(10.75));
  EXPECT_EQ(later(10.75), ros::Time(10.75)) << "none is later";
}

TEST(PlainFrame, DropsTheOldSlash) {
  EXPECT_EQ(plainFrame("/base"), "base");
  EXPECT_EQ(plainFrame("base"), "base");
  EXPECT_EQ(plainFrame(""), "");
}

}  // namespace
}  // namespace deformable_contact_monitor
