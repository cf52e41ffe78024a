// Tests of meshes that come faster than the transforms that they wait for: which of them have a
// cycle, and when.
#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "loop_fixture.h"

namespace deformable_contact_monitor {
namespace {

using Stamps = std::vector<int>;  // [ms] since the beginning

// The cloth is seen by a camera, whose transforms come now and then. The cable needs no transforms.
class QueuesTest : public LoopTest {
 protected:
  QueuesTest() {
    parameters_.tf_timeout_s = 0.05;
    parameters_.max_rate_hz = 100;
    addTransform(&transforms_, "camera", 50);
  }

  struct Cycle {
    int stamp_ms, start_ms;
    bool knows_it;  // the object has a mesh of that very stamp, and a pose
  };

  static double stampS(int ms) { return 50 + ms / 1000.0; }

  // Makes a step every millisecond, except while a cycle runs. `arrive` runs before each.
  void play(int from_ms, int to_ms, const std::function<void(int ms)>& arrive) {
    for (int ms = from_ms; ms < to_ms; ++ms) {
      ros_time_ = ros::Time(stampS(ms));
      arrive(ms);
      steady_time_ += std::chrono::milliseconds(1);
      if (ms < busy_until_ms_) continue;
      for (const std::string& line : step()) note(line, ms);
    }
  }

  void note(const std::string& line, int ms) {
    if (line.compare(0, 6, "cycle ") != 0) return;
    // Stamps in the log have six digits, so they are exact to tenths of milliseconds.
    const int stamp_ms =
        static_cast<int>(std::lround(1000 * (std::strtod(line.c_str() + 6, nullptr) - 50)));
    for (std::size_t i = 0; i < 2; ++i) {
      const std::string body = "*" + parameters_.objects[i].name + "@";
      const std::size_t at = line.find(body);
      if (line.find("*" + parameters_.objects[i].name) == std::string::npos) continue;
      const bool knows_it =
          at != std::string::npos && line.find("(", at) > line.find(" ", at) &&
          std::lround(1000 * (std::strtod(line.c_str() + at + body.size(), nullptr) - 50)) ==
              stamp_ms;
      cycles_[i].push_back({stamp_ms, ms, knows_it});
      busy_until_ms_ = ms + cycle_ms_;
    }
  }

  // Gives a mesh every 10 ms and a transform every 20 ms.
  void giveAndTransform(int ms) {
    if (ms % 10 == 0) give(0, stampS(ms), "camera");
    if (ms % 20 == 0) addTransform(&transforms_, "camera", stampS(ms));
  }

  Stamps stamps(std::size_t object) const {
    Stamps stamps;
    for (const Cycle& cycle : cycles_[object]) stamps.push_back(cycle.stamp_ms);
    return stamps;
  }
  int longestDelayMs(std::size_t object) const {
    int most = 0;
    for (const Cycle& c : cycles_[object]) most = std::max(most, c.start_ms - c.stamp_ms);
    return most;
  }
  bool allKnown(std::size_t object) const {
    return std::all_of(cycles_[object].begin(), cycles_[object].end(),
                       [](const Cycle& cycle) { return cycle.knows_it; });
  }
  static Stamps every(int period_ms, int from_ms, int to_ms) {
    Stamps stamps;
    for (int ms = from_ms; ms < to_ms; ms += period_ms) stamps.push_back(ms);
    return stamps;
  }

  int cycle_ms_ = 0;
  int busy_until_ms_ = 0;
  std::vector<Cycle> cycles_[2];
};

TEST_F(QueuesTest, EveryMeshHasACycleThoughTransformsComeHalfAsOften) {
  play(0, 1001, [this](int ms) { giveAndTransform(ms); });
  play(1001, 1010, [](int) {});
  EXPECT_EQ(stamps(0), every(10, 0, 1001));
  EXPECT_TRUE(allKnown(0));
  EXPECT_LE(longestDelayMs(0), 10);
  EXPECT_EQ(meshes()[0].counters().dropped, 0U);
}

TEST_F(QueuesTest, AlsoWhenCyclesTakeMostOfTheTimeAndTransformsComeLate) {
  cycle_ms_ = 8;
  play(0, 1100, [this](int ms) {
    if (ms % 10 == 0 && ms <= 1000) give(0, stampS(ms), "camera");
    if (ms % 20 == 15) addTransform(&transforms_, "camera", stampS(ms - 3));
  });
  EXPECT_EQ(stamps(0), every(10, 0, 1001));
  EXPECT_TRUE(allKnown(0));
  EXPECT_LE(longestDelayMs(0), 3 + 20 + 2 * 8);
}

TEST_F(QueuesTest, OthersHaveTheirTurnsMeanwhile) {
  play(0, 1001, [this](int ms) {
    giveAndTransform(ms);
    if (ms % 10 == 5) give(1, stampS(ms));
  });
  play(1001, 1010, [](int) {});
  EXPECT_EQ(stamps(0), every(10, 0, 1001));
  EXPECT_EQ(stamps(1), every(10, 5, 1001));
  EXPECT_EQ(longestDelayMs(1), 0);
}

// Some meshes are dropped, and those that have cycles are fresh.
TEST_F(QueuesTest, ASlowDetectorHasTheNewestInTheirOrder) {
  cycle_ms_ = 15;
  play(0, 3000, [this](int ms) { giveAndTransform(ms); });
  const Stamps had = stamps(0);
  EXPECT_TRUE(std::is_sorted(had.begin(), had.end()));
  EXPECT_TRUE(std::adjacent_find(had.begin(), had.end()) == had.end()) << "each once";
  EXPECT_TRUE(allKnown(0));
  EXPECT_GE(had.size(), 180U) << "of 200 that there is time for";
  EXPECT_LE(longestDelayMs(0), 2 * 15 + 10);
  const std::size_t waiting = 300 - had.size() - meshes()[0].counters().dropped;
  EXPECT_LE(waiting, 2U) << "what has no cycle is counted";
}

// No transforms come for a while, and meshes pile up. Then cycles are too slow for all of these.
TEST_F(QueuesTest, NoneHasItsTurnLongAfterItsTimeWhileThereAreNewer) {
  parameters_.tf_timeout_s = 0.2;
  cycle_ms_ = 40;
  play(0, 1000, [this](int ms) {
    if (ms % 10 == 0) give(0, stampS(ms), "camera");
    if (ms == 190 || ms > 200) addTransform(&transforms_, "camera", stampS(ms));
  });
  const Stamps had = stamps(0);
  EXPECT_TRUE(std::is_sorted(had.begin(), had.end()));
  EXPECT_TRUE(allKnown(0));
  EXPECT_LE(longestDelayMs(0), 200 + 40);
  EXPECT_GE(had.size(), 18U) << "no time is lost";
  EXPECT_GE(had.back(), 940);
}

TEST_F(QueuesTest, EachWaitsNoLongerThanTheTimeout) {
  addTransform(&transforms_, "camera", 49.5);
  play(10, 40, [this](int ms) {
    if (ms % 10 == 0) give(0, stampS(ms), "camera");
  });
  EXPECT_EQ(stamps(0), Stamps());
  play(40, 200, [](int) {});
  EXPECT_EQ(stamps(0), (Stamps{10, 20, 30}));
  EXPECT_FALSE(cycles_[0][0].knows_it);
  EXPECT_EQ(longestDelayMs(0), 50);
}

// When the queue is full, the newest mesh waits in its MeshInput.
TEST_F(QueuesTest, TheQueueIsBounded) {
  parameters_.max_rate_hz = 0;
  parameters_.tf_timeout_s = 1;
  play(1, 101, [this](int ms) { give(0, stampS(ms), "camera"); });
  EXPECT_EQ(meshes()[0].counters().dropped, 100 - CycleScheduler::kMostWaiting - 1);
  addTransform(&transforms_, "camera", 51);
  play(101, 150, [](int) {});
  Stamps expected = every(1, 1, 1 + static_cast<int>(CycleScheduler::kMostWaiting));
  expected.push_back(100);
  EXPECT_EQ(stamps(0), expected);
  EXPECT_TRUE(allKnown(0));
}

// A mesh that only waits for its turn is replaced by a newer one only if that one is ready as well.
TEST_F(QueuesTest, WhatHasToWaitDoesNotReplaceWhatWaitsForItsTurn) {
  cycle_ms_ = 25;
  parameters_.max_rate_hz = 0;
  play(1, 200, [this](int ms) {
    if (ms == 1 || ms == 10 || ms == 45) give(0, stampS(ms), "camera");
    if (ms == 12) give(1, stampS(ms));
    if (ms == 1 || ms == 10 || ms == 100) addTransform(&transforms_, "camera", stampS(ms));
  });
  EXPECT_EQ(stamps(1), Stamps{12});
  EXPECT_EQ(cycles_[1][0].start_ms, 26) << "its turn was the longer ago";
  EXPECT_EQ(stamps(0), (Stamps{1, 10, 45}));
  EXPECT_EQ(cycles_[0][1].start_ms, 51);
}

TEST_F(QueuesTest, ARefusedMeshHidesThoseThatWait) {
  parameters_.max_rate_hz = 0;
  play(10, 35, [this](int ms) {
    if (ms % 10 == 0) give(0, stampS(ms), "camera");
  });
  give(0, 0, "camera");
  const Lines said = stepAfter(1);
  ASSERT_EQ(said.size(), 1U);
  EXPECT_NE(said[0].find("*cloth(mesh refused: header.stamp is zero)"), std::string::npos)
      << said[0];
  EXPECT_EQ(meshes()[0].counters().dropped, 3U);
  addTransform(&transforms_, "camera", 51);
  EXPECT_EQ(stepAfter(1), Lines());
}

TEST_F(QueuesTest, OfEqualStampsThereIsOneCycleAndItsTimeStands) {
  play(10, 100, [this](int ms) {
    if (ms % 10 == 0 && ms < 60) give(0, stampS(10), "camera");
  });
  EXPECT_EQ(stamps(0), Stamps{10});
  EXPECT_EQ(longestDelayMs(0), 50);
  EXPECT_EQ(meshes()[0].counters().dropped, 4U);
}

}  // namespace
}  // namespace deformable_contact_monitor
