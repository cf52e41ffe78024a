// Tests which poses are not known although tf2 gives them: within a gap of a frame's transforms,
// and of frames that are on /tf and on /tf_static.
#include "monitor/input/transform_buffer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "monitor/input/transform_lookup.h"

namespace deformable_contact_monitor {
namespace {

using Outcome = PoseAnswer::Outcome;

class TransformBufferTest : public ::testing::Test {
 protected:
  // Adds the transform of `frame`, which comes at its stamp unless the clock is ahead.
  bool add(const std::string& parent, const std::string& frame, double stamp_s, double x_m,
           bool is_static = false, std::string publisher = "") {
    if (publisher.empty()) publisher = is_static ? "/fixed" : "/moving";
    geometry_msgs::TransformStamped t;
    t.header.frame_id = parent;
    t.header.stamp = ros::Time(stamp_s);
    t.child_frame_id = frame;
    t.transform.translation.x = x_m;
    t.transform.rotation.w = 1;
    if (!is_static && !is_clock_held_) now_ = std::max(now_, t.header.stamp);
    return buffer_.add(t, publisher, is_static, SteadyTime());
  }
  void addStatic(const std::string& frame, double x_m, const std::string& publisher) {
    EXPECT_TRUE(add("base", frame, 0, x_m, true, publisher));
  }

  PoseAnswer ask(const std::string& frame, double stamp_s) const {
    return TransformLookup(buffer_, "base").lookup({{frame, ros::Time(stamp_s)}}).at(0);
  }
  Outcome outcome(const std::string& frame, double stamp_s) const {
    return ask(frame, stamp_s).outcome;
  }

  ros::Time now_;
  bool is_clock_held_ = false;
  TransformBuffer buffer_{[this] { return now_; }, 0.5};
};

TEST_F(TransformBufferTest, AFrameThatWasStaticAndMovesIsNotKnown) {
  EXPECT_TRUE(add("base", "arm", 0, 1, true));
  EXPECT_TRUE(add("arm", "hand", 0, 1, true));
  EXPECT_TRUE(add("base", "other", 0, 1, true));
  EXPECT_TRUE(add("base", "arm", 1, 1)) << "it says what is known";
  EXPECT_EQ(outcome("hand", 1.5), Outcome::kFound);
  EXPECT_FALSE(add("base", "arm", 2, 1.5));
  EXPECT_EQ(outcome("hand", 1.5), Outcome::kFound) << "it had not moved";
  for (const double stamp_s : {2.0, 9.0}) {
    for (const std::string frame : {"arm", "hand"}) {
      const PoseAnswer answer = ask(frame, stamp_s);
      EXPECT_EQ(answer.outcome, Outcome::kPast) << frame << " at " << stamp_s;
      EXPECT_EQ(answer.problem,
                "TF frame 'arm' came on /tf_static (from /fixed) and then on /tf (from /moving), "
                "and tf2 keeps to the first: publish it on one of them, and restart this node");
    }
  }
  EXPECT_EQ(outcome("other", 2), Outcome::kFound);
  buffer_.forget(SteadyTime::min());
  EXPECT_EQ(outcome("hand", 1.5), Outcome::kPast) << "tf2 keeps static frames";
  EXPECT_EQ(outcome("other", 2), Outcome::kFound);
}

// Which of them tf2 has would be chance.
TEST_F(TransformBufferTest, WhoPutsAStaticFrameElsewhereThanAnotherIsNamed) {
  addStatic("mount", 1, "/urdf");
  addStatic("mount", 1, "/copy");
  addStatic("mount", 1, "/urdf");
  addStatic("other", 1, "/urdf");
  add("mount", "camera", 1, 1);
  EXPECT_EQ(outcome("camera", 1), Outcome::kFound);
  EXPECT_TRUE(buffer_.staticRivals().empty());
  addStatic("mount", 2, "/calibration");
  for (const std::string frame : {"mount", "camera"}) {
    EXPECT_EQ(ask(frame, 1).outcome, Outcome::kPast);
    EXPECT_EQ(ask(frame, 1).problem,
              "TF frame 'mount' came on /tf_static from /urdf and from /calibration, which put it "
              "at different places: let one of them publish it");
  }
  EXPECT_EQ(outcome("other", 1), Outcome::kFound);
  const std::set<std::string> all{"/calibration", "/copy", "/urdf"};
  EXPECT_EQ(buffer_.staticRivals(), all);
  buffer_.dropStatics({"/urdf"});
  EXPECT_EQ(outcome("mount", 1), Outcome::kPast) << "the copy is still there";
  buffer_.dropStatics({"/copy"});
  EXPECT_EQ(outcome("camera", 1), Outcome::kFound);
  EXPECT_EQ(ask("mount", 1).pose.translation[0], 2);
  buffer_.dropStatics({"/calibration"});
  EXPECT_EQ(ask("mount", 1).pose.translation[0], 2) << "nobody contradicts it";

  addStatic("mount", 3, "/late");
  EXPECT_EQ(outcome("mount", 1), Outcome::kPast);
  buffer_.dropStatics({"/late"});
  EXPECT_EQ(ask("mount", 1).pose.translation[0], 2) << "that of the one that is left";
  addStatic("mount", 4, "/calibration");
  EXPECT_EQ(ask("mount", 1).pose.translation[0], 4) << "it may change its own";
  addStatic("mount", 5, "/zero_was_late");
  buffer_.dropStatics({"/calibration", "/zero_was_late"});
  EXPECT_EQ(ask("mount", 1).pose.translation[0], 5) << "both are gone, and this was the last";
  addStatic("mount", 5.0005, "/rounded");
  EXPECT_EQ(outcome("mount", 1), Outcome::kFound);
}

// The frame is on /tf, too, where it stays.
TEST_F(TransformBufferTest, AStaticRivalThatIsGoneLeavesNothingBehind) {
  addStatic("arm", 1, "/urdf");
  EXPECT_TRUE(add("base", "arm", 1, 1));
  addStatic("arm", 2, "/rival");
  EXPECT_TRUE(add("base", "arm", 1.25, 1));
  EXPECT_EQ(outcome("arm", 1.25), Outcome::kPast);
  buffer_.dropStatics({"/rival"});
  EXPECT_TRUE(add("base", "arm", 1.5, 1));
  EXPECT_EQ(outcome("arm", 1.5), Outcome::kFound);
  EXPECT_FALSE(add("base", "arm", 2, 2)) << "it moves";
  EXPECT_EQ(outcome("arm", 2), Outcome::kPast);
}

TEST_F(TransformBufferTest, AMalformedTransformChangesNothing) {
  add("base", "arm", 0, 1, true);
  EXPECT_FALSE(add("base", "arm", 1, std::nan("")));
  EXPECT_FALSE(add("arm", "arm", 1, 2));
  EXPECT_FALSE(add("", "arm", 1, 2));
  EXPECT_EQ(outcome("arm", 1), Outcome::kFound);
}

TEST_F(TransformBufferTest, WhatIsAboveBothFramesDoesNotMatter) {
  add("map", "base", 0, 1, true);
  add("base", "arm", 1, 1);
  EXPECT_FALSE(add("map", "base", 1, 2));
  EXPECT_EQ(outcome("arm", 1), Outcome::kFound);
  EXPECT_EQ(outcome("map", 1), Outcome::kPast);
}

TEST_F(TransformBufferTest, AFrameOnBothTopicsCountsWhileTheyAgree) {
  const auto isContested = [](const PoseAnswer& answer) {
    return answer.problem.find("came on /tf (from /moving) and then on /tf_static (from /fixed)") !=
           std::string::npos;
  };
  add("base", "arm", 1, 1);
  EXPECT_FALSE(add("base", "arm", 1, 1, true));
  EXPECT_TRUE(add("base", "arm", 1.4, 1));
  EXPECT_EQ(outcome("arm", 1.2), Outcome::kFound);
  EXPECT_TRUE(isContested(ask("arm", 2))) << "/tf is silent";
  EXPECT_FALSE(add("base", "arm", 1, 2, true));
  EXPECT_TRUE(add("base", "arm", 1.8, 1));
  EXPECT_EQ(outcome("arm", 1.2), Outcome::kFound);
  const PoseAnswer answer = ask("arm", 1.6);
  EXPECT_EQ(answer.outcome, Outcome::kPast);
  EXPECT_TRUE(isContested(answer)) << answer.problem;

  add("base", "leg", 1, 1);
  add("base", "leg", 1, 1, true);
  add("base", "leg", 1.4, 1);
  add("base", "leg", 1.8, 2);
  EXPECT_EQ(outcome("leg", 1.2), Outcome::kFound);
  EXPECT_TRUE(isContested(ask("leg", 1.8))) << "/tf moved on";
}

TEST_F(TransformBufferTest, NothingIsKnownWithinAGap) {
  add("base", "arm", 1, 1);
  add("base", "arm", 3, 3);
  add("arm", "hand", 0, 1, true);
  add("base", "other", 0, 1, true);
  const PoseAnswer answer = ask("hand", 2);
  EXPECT_EQ(answer.outcome, Outcome::kPast);
  EXPECT_EQ(answer.problem,
            "TF of 'arm' was silent for 2 s: wanted 2.000000000, which is between 1.000000000 and "
            "3.000000000");
  EXPECT_EQ(outcome("other", 2), Outcome::kFound);
  EXPECT_EQ(outcome("hand", 1), Outcome::kFound);
  EXPECT_EQ(outcome("hand", 3), Outcome::kFound);
  add("base", "arm", 1.6, 1.6);  // some transforms were only late
  add("base", "arm", 2, 2);
  add("base", "arm", 2.4, 2);
  EXPECT_EQ(outcome("hand", 1.3), Outcome::kPast);
  EXPECT_EQ(outcome("hand", 1.8), Outcome::kFound);
  EXPECT_EQ(outcome("hand", 2.2), Outcome::kFound);
  EXPECT_EQ(outcome("hand", 2.7), Outcome::kPast);
}

TEST_F(TransformBufferTest, WhoStampsAheadLeavesNoGap) {
  is_clock_held_ = true;
  for (const double second : {1, 2, 3}) {
    now_ = ros::Time(second);
    add("base", "arm", second + 1, second);  // as tf's static_transform_publisher does
  }
  EXPECT_EQ(outcome("arm", 2.5), Outcome::kFound);
  EXPECT_EQ(outcome("arm", 3.5), Outcome::kFound);
}

TEST_F(TransformBufferTest, WhoContradictsAnotherPublisherIsNamed) {
  add("base", "other", 0, 1, true);
  for (int i = 0; i < 4; ++i) {
    add("base", "arm", 1 + 0.1 * i, 1 + 0.01 * i);
    add("base", "arm", 1.05 + 0.1 * i, 1.5, false, "/second");
  }
  const PoseAnswer answer = ask("arm", 1.3);
  EXPECT_EQ(answer.outcome, Outcome::kPast);
  EXPECT_EQ(answer.problem,
            "two nodes publish TF frame 'arm' on /tf, at different places: /moving and /second; "
            "stop one of them");
  EXPECT_EQ(outcome("other", 1.3), Outcome::kFound);
  for (double stamp_s = 1.4; stamp_s < 4; stamp_s += 0.1) add("base", "arm", stamp_s, 1);
  EXPECT_EQ(outcome("arm", 1.3), Outcome::kPast);
  EXPECT_EQ(outcome("arm", 3.5), Outcome::kFound) << "the second one is gone";
  for (double stamp_s = 8; stamp_s < 9; stamp_s += 0.1) add("base", "arm", stamp_s, 1);
  EXPECT_EQ(outcome("arm", 8.5), Outcome::kFound) << "what is old is forgotten";
}

// A pause ends what is remembered of both while one of them is compared.
TEST_F(TransformBufferTest, PublishersThatPauseTogetherGoOn) {
  for (const double start_s : {1, 20, 40}) {
    for (int i = 0; i < 10; ++i) {
      const std::string first = start_s < 30 ? "/a" : "/z", second = start_s < 30 ? "/z" : "/a";
      add("base", "arm", start_s + 0.1 * i, 1, false, first);
      add("base", "arm", start_s + 0.05 + 0.1 * i, 1, false, second);
    }
    EXPECT_EQ(outcome("arm", start_s + 0.7), Outcome::kFound);
  }
}

TEST_F(TransformBufferTest, WhoHasTwoPlacesForAStampIsNamed) {
  add("base", "arm", 1, 1);
  EXPECT_FALSE(add("base", "arm", 1, 1.02)) << "tf2 has it";
  EXPECT_EQ(outcome("arm", 1), Outcome::kFound);
  EXPECT_FALSE(add("base", "arm", 1, 2));
  const PoseAnswer answer = ask("arm", 1);
  EXPECT_EQ(answer.outcome, Outcome::kPast);
  EXPECT_EQ(answer.problem,
            "/moving publishes TF frame 'arm' twice at one stamp, at different places");
  geometry_msgs::TransformStamped malformed;
  malformed.header.frame_id = "base";
  malformed.header.stamp = ros::Time(2);
  malformed.child_frame_id = "leg";
  malformed.transform.translation.x = 9;
  malformed.transform.rotation.w = 0.5;
  add("base", "leg", 1.9, 1);
  buffer_.add(malformed, "/moving", false, SteadyTime());
  add("base", "leg", 2, 1);
  EXPECT_EQ(outcome("leg", 2), Outcome::kFound);
}

// Both publish a frame that swings. They disagree only where one adds an offset to it, and their
// transforms come in any order.
TEST_F(TransformBufferTest, RandomPublishersAgreeUnlessOneIsElsewhere) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> share(0, 1);
    const double amplitude_m = 0.2 * share(random), frequency = 9 * share(random);  // [rad/s]
    const double offset_m = seed % 2 == 0 ? 0 : 3 * amplitude_m + 0.1;
    TransformBuffer buffer([this] { return now_; }, 0.5);
    struct Sent {
      double arrival_s, stamp_s, x_m;
      std::string publisher;
    };
    std::vector<Sent> sent;
    for (const std::string publisher : {"/one", "/two"}) {
      const double period_s = 0.01 + 0.03 * share(random), late_s = 0.2 * share(random);
      for (double stamp_s = 100 + period_s * share(random); stamp_s < 102; stamp_s += period_s) {
        const double x_m =
            amplitude_m * std::sin(frequency * stamp_s) + (publisher == "/two" ? offset_m : 0);
        sent.push_back({stamp_s + late_s, stamp_s, x_m, publisher});
      }
    }
    std::sort(sent.begin(), sent.end(),
              [](const Sent& a, const Sent& b) { return a.arrival_s < b.arrival_s; });
    for (const Sent& one : sent) {
      now_ = ros::Time(one.arrival_s);
      geometry_msgs::TransformStamped t;
      t.header.frame_id = "base";
      t.header.stamp = ros::Time(one.stamp_s);
      t.child_frame_id = "arm";
      t.transform.translation.x = one.x_m;
      t.transform.rotation.w = 1;
      buffer.add(t, one.publisher, false, SteadyTime());
    }
    for (const double stamp_s : {100.5, 101.0, 101.7}) {
      const PoseAnswer answer =
          TransformLookup(buffer, "base").lookup({{"arm", ros::Time(stamp_s)}}).at(0);
      EXPECT_EQ(answer.outcome == Outcome::kFound, offset_m == 0) << seed << " " << answer.problem;
    }
  }
}

TEST_F(TransformBufferTest, AResetEndsGaps) {
  add("base", "arm", 11, 1);
  add("base", "arm", 13, 1);
  buffer_.forget(SteadyTime::min());
  now_ = ros::Time(1);
  add("base", "arm", 1, 1);
  EXPECT_EQ(outcome("arm", 1), Outcome::kFound);
  add("base", "arm", 1.4, 1);
  EXPECT_EQ(outcome("arm", 1.2), Outcome::kFound);
}

// tf2 rejects what is more than 10 s older than its newest transform.
TEST_F(TransformBufferTest, AClockThatGoesBackIsNoticedOnce) {
  is_clock_held_ = true;
  const SteadyTime start;
  now_ = ros::Time(1000);
  buffer_.lookAtClock(start);
  EXPECT_TRUE(add("base", "arm", 1000, 1));
  now_ = ros::Time(999.95);
  buffer_.lookAtClock(start);
  EXPECT_EQ(outcome("arm", 1000), Outcome::kFound) << "a small step";
  now_ = ros::Time(600);
  EXPECT_FALSE(add("base", "arm", 600, 2)) << "nobody looked at the clock";
  buffer_.lookAtClock(start);
  EXPECT_TRUE(add("base", "arm", 600, 2));
  EXPECT_FALSE(add("base", "arm", 1000.05, 1)) << "it was under way when the clock jumped";
  buffer_.lookAtClock(start);
  EXPECT_EQ(ask("arm", 600).pose.translation[0], 2) << "it is of the new time";
  now_ = ros::Time(601);
  buffer_.lookAtClock(start);
  EXPECT_EQ(outcome("arm", 600), Outcome::kFound);
}

// The definition: a stamp is known if on each frame below `base` its neighbours are close enough.
TEST_F(TransformBufferTest, RandomTransformsAgreeWithTheDefinition) {
  const std::vector<std::string> frames = {"base", "a", "b", "c"};
  for (unsigned seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> share(0, 1);
    now_ = ros::Time(100);
    TransformBuffer buffer([this] { return now_; }, 0.5);
    std::vector<std::set<ros::Time>> stamps(frames.size());
    const auto put = [&](std::size_t i, double stamp_s) {
      geometry_msgs::TransformStamped t;
      t.header.frame_id = frames[i - 1];
      t.header.stamp = ros::Time(stamp_s);
      t.child_frame_id = frames[i];
      t.transform.rotation.w = 1;
      ASSERT_TRUE(buffer.add(t, "/test", false, SteadyTime()));
      stamps[i].insert(t.header.stamp);
    };
    for (std::size_t i = 1; i < frames.size(); ++i) put(i, 100);
    double clock_s = 100;
    for (int k = 0; k < 60; ++k) {
      clock_s += 0.3 * share(random) * share(random);
      if (share(random) < 0.05) clock_s += 0.6;
      now_ = ros::Time(clock_s);
      const double late_s = share(random) < 0.2 ? 0.8 * share(random) : 0;
      if (clock_s - late_s > 100) put(1 + random() % 3, clock_s - late_s);
    }
    for (int k = 0; k < 300; ++k) {
      const std::size_t frame = 1 + random() % 3;
      const ros::Time stamp(100 + (clock_s - 100) * share(random));
      bool is_known = true;
      for (std::size_t i = 1; i <= frame; ++i) {
        const auto after = stamps[i].lower_bound(stamp);
        if (after == stamps[i].end()) {
          is_known = false;
        } else if (*after != stamp) {
          is_known = is_known && (*after - *std::prev(after)).toSec() <= 0.5;
        }
      }
      const PoseAnswer answer =
          TransformLookup(buffer, "base").lookup({{frames[frame], stamp}}).at(0);
      ASSERT_EQ(answer.outcome == Outcome::kFound, is_known) << stamp << ": " << answer.problem;
    }
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
