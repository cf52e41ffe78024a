// Tests of whose cycle is next, and of which requests wait, are replaced or are dropped.
#include "monitor/cycle/cycle_scheduler.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace deformable_contact_monitor {
namespace {

using std::chrono::milliseconds;
using Who = std::vector<std::size_t>;

const SteadyTime kStart{std::chrono::hours(7)};

// Objects whose transforms are late while the test says so; who comes after the last is the robot.
class CycleSchedulerTest : public ::testing::Test {
 protected:
  // One scheduler for each test, with an object for each rate but the last, which is the robot's.
  CycleScheduler& make(const std::vector<double>& max_rates_hz) {
    for (std::size_t i = 0; i + 1 < max_rates_hz.size(); ++i) {
      inputs_.emplace_back("", MeshLimits());
    }
    scheduler_ = std::make_unique<CycleScheduler>(
        max_rates_hz, inputs_,
        TransformGate{[this](std::size_t who, const CycleRequest& request) {
                        asked_.push_back(who);
                        EXPECT_EQ(request.mesh.stamp(), request.stamp);
                        return late_.count(who) > 0;
                      },
                      [this](std::size_t who, const CycleRequest& /*request*/) {
                        given_up_.push_back(who);
                      }});
    return *scheduler_;
  }

  // A mesh arrives and is accepted; its request waits for transforms for 50 ms at most.
  void add(std::size_t who, double stamp_s, SteadyTime now = kStart) {
    CycleRequest request;
    request.stamp = ros::Time(stamp_s);
    request.wait = {now, ros::Time(), milliseconds(50), milliseconds(50)};
    if (who < inputs_.size()) {
      auto message = boost::make_shared<DeformableMesh>();
      message->header.stamp = request.stamp;
      message->header.frame_id = "camera";
      message->vertices = {0, 0, 0, 1, 0, 0, 0, 1, 0};
      message->triangles = {0, 1, 2};
      inputs_[who].store({message});
      const Acceptance answer = inputs_[who].take(ros::Time(), &request.mesh);
      ASSERT_TRUE(answer == Acceptance::kAccepted || answer == Acceptance::kJumped);
    }
    scheduler_->add(who, std::move(request), now);
  }

  Who next(SteadyTime now = kStart) { return scheduler_->next(now, ros::Time()); }

  std::uint64_t dropped(std::size_t who) const { return inputs_[who].counters().dropped; }

  MeshInputs inputs_;
  std::set<std::size_t> late_;  // objects whose transforms are late
  Who asked_, given_up_;
  std::unique_ptr<CycleScheduler> scheduler_;
};

TEST_F(CycleSchedulerTest, NobodyWaitsAtFirst) {
  CycleScheduler& scheduler = make({0, 0});
  EXPECT_TRUE(next().empty());
  EXPECT_TRUE(scheduler.isEmpty());
  EXPECT_TRUE(scheduler.mayAdd(0, kStart) && scheduler.mayAdd(1, kStart));
}

TEST_F(CycleSchedulerTest, WhoseTurnIsTheLongestAgoIsNextWhateverTheStamps) {
  CycleScheduler& scheduler = make({0, 0, 0, 0});
  for (int round = 0; round < 3; ++round) {
    const double s = 0.1 * round;
    for (std::size_t i = 0; i < 3; ++i) add(i, 50 + s - 0.01 * static_cast<double>(i));
    for (std::size_t i = 0; i < 3; ++i) {
      ASSERT_EQ(next(), Who{i});
      scheduler.start({i});
      add(0, 50.01 + s + 0.01 * static_cast<double>(i));  // it waits, or replaces, every time
    }
    for (const std::size_t i : {1, 2}) add(i, 50.05 + s);
    for (std::size_t i = 0; i < 3; ++i) scheduler.start({i});
  }
}

TEST_F(CycleSchedulerTest, OneStampIsOneCycle) {
  CycleScheduler& scheduler = make({0, 0, 0, 0});
  add(0, 50);
  add(1, 51);
  add(2, 50);
  EXPECT_EQ(next(), (Who{0, 2}));
  late_ = {2};
  EXPECT_EQ(next(), Who{0}) << "2 is not ready";
  scheduler.start({0, 2});
  EXPECT_EQ(next(), Who{1});
  EXPECT_FALSE(scheduler.hasRequest(0));
}

TEST_F(CycleSchedulerTest, TheRobotIsAlwaysReadyAndSharesStamps) {
  make({0, 0});
  add(0, 50);
  add(1, 50);
  EXPECT_EQ(next(), (Who{0, 1}));
  late_ = {0};
  EXPECT_EQ(next(), Who{1});
}

TEST_F(CycleSchedulerTest, WhoOverranSharesWithNobodyUntilATurnEndsInTime) {
  CycleScheduler& scheduler = make({0, 0, 0, 0});
  scheduler.finish({0, 1}, true);
  EXPECT_TRUE(scheduler.overran(0) && scheduler.overran(1) && !scheduler.overran(2));
  for (std::size_t i = 0; i < 3; ++i) add(i, 50);
  EXPECT_EQ(next(), Who{0});
  scheduler.start({0});
  scheduler.finish({0}, false);
  add(0, 50);
  EXPECT_EQ(next(), Who{1});
  scheduler.start({1});
  add(1, 50);
  EXPECT_EQ(next(), (Who{0, 2})) << "1 has not ended in time yet";
  scheduler.clear();
  EXPECT_FALSE(scheduler.overran(1));
}

TEST_F(CycleSchedulerTest, WhoIsNotReadyLetsOthersPass) {
  make({0, 0, 0});
  add(0, 50);
  add(1, 51);
  late_ = {0};
  EXPECT_EQ(next(), Who{1});
  late_ = {0, 1};
  EXPECT_TRUE(next().empty());
}

TEST_F(CycleSchedulerTest, AfterItsTimeoutACycleGoesAheadWithoutTransforms) {
  CycleScheduler& scheduler = make({0, 0});
  late_ = {0};
  add(0, 50);
  EXPECT_TRUE(next(kStart + milliseconds(49)).empty());
  EXPECT_TRUE(given_up_.empty());
  EXPECT_EQ(next(kStart + milliseconds(50)), Who{0});
  EXPECT_EQ(given_up_, Who{0});
  EXPECT_TRUE(scheduler.first(0).waits_for_transforms);
}

// Each question costs lookups of transforms.
TEST_F(CycleSchedulerTest, OnlyThoseAreAskedWhoseAnswerMatters) {
  make({0, 0, 0, 0, 0});
  for (std::size_t i = 0; i < 4; ++i) add(i, i == 3 ? 50 : 50 + 0.1 * static_cast<double>(i));
  asked_.clear();
  EXPECT_EQ(next(), (Who{0, 3}));
  EXPECT_EQ(asked_, (Who{0, 3}));
}

TEST_F(CycleSchedulerTest, EachHasARateOfItsOwn) {
  CycleScheduler& scheduler = make({10, 0, 0});
  for (const std::size_t who : {0, 1}) add(who, 50);
  scheduler.start({0, 1});
  EXPECT_FALSE(scheduler.mayAdd(0, kStart + milliseconds(99)));
  EXPECT_TRUE(scheduler.mayAdd(0, kStart + milliseconds(100)));
  EXPECT_TRUE(scheduler.mayAdd(1, kStart));
  EXPECT_EQ(scheduler.earliest(0), kStart + milliseconds(100));
}

TEST_F(CycleSchedulerTest, NewRatesHoldFromTheLastRequestOn) {
  CycleScheduler& scheduler = make({10, 0, 10, 0});
  for (const std::size_t who : {0, 1}) add(who, 50);
  scheduler.start({0, 1});
  scheduler.setRates({20, 10, 1, 0});
  EXPECT_EQ(scheduler.earliest(0), kStart + milliseconds(50));
  EXPECT_EQ(scheduler.earliest(1), kStart + milliseconds(100));
  EXPECT_TRUE(scheduler.mayAdd(2, kStart)) << "it had no request yet";
  scheduler.setRates({0, 0, 0, 0});
  EXPECT_EQ(scheduler.earliest(0), kStart);
  add(0, 60, kStart + milliseconds(1));
  scheduler.start({0});
  EXPECT_TRUE(scheduler.mayAdd(0, kStart + milliseconds(1)));
}

TEST_F(CycleSchedulerTest, WhatIsDroppedHasNoTurn) {
  CycleScheduler& scheduler = make({0, 0, 0});
  for (const std::size_t who : {0, 1}) add(who, 50);
  scheduler.drop(0);
  EXPECT_EQ(dropped(0), 1U);
  EXPECT_EQ(next(), Who{1});
  EXPECT_TRUE(scheduler.mayAdd(0, kStart));
}

TEST_F(CycleSchedulerTest, WhatIsClearedDoesNotWait) {
  CycleScheduler& scheduler = make({0, 0});
  add(0, 50);
  EXPECT_FALSE(scheduler.isEmpty());
  scheduler.clear();
  EXPECT_EQ(dropped(0), 1U);
  EXPECT_TRUE(scheduler.isEmpty());
  EXPECT_FALSE(scheduler.hasRequest(0));
}

TEST_F(CycleSchedulerTest, AQueueIsServedFromItsFront) {
  CycleScheduler& scheduler = make({0, 0});
  add(0, 50);
  late_ = {0};
  add(0, 50.1);  // it has to wait for transforms, so it replaces none
  EXPECT_TRUE(next().empty());
  late_.clear();
  add(0, 50.2);
  add(0, 50.3);  // it replaces the one before, which waits only for its turn
  EXPECT_EQ(dropped(0), 1U);
  std::vector<double> stamps;
  for (; !next().empty(); scheduler.start({0})) {
    stamps.push_back(scheduler.first(0).stamp.toSec());
  }
  EXPECT_EQ(stamps, (std::vector<double>{50, 50.1, 50.3}));
}

TEST_F(CycleSchedulerTest, OfOneStampTheNewerMeshHasTheCycle) {
  CycleScheduler& scheduler = make({0, 0});
  add(0, 50);
  const DeformableMesh::ConstPtr before = scheduler.first(0).mesh.message;
  const SteadyTime start = scheduler.first(0).wait.start;
  add(0, 50, kStart + milliseconds(5));
  EXPECT_NE(scheduler.first(0).mesh.message, before);
  EXPECT_EQ(scheduler.first(0).wait.start, start) << "its time stands";
  EXPECT_EQ(dropped(0), 1U);
  scheduler.start({0});
  EXPECT_TRUE(scheduler.isEmpty());
}

// The stamps jump back, or a mesh is rejected.
TEST_F(CycleSchedulerTest, WhatTheInputHasForgottenHasNoCycle) {
  CycleScheduler& scheduler = make({0, 0});
  late_ = {0};
  for (const double stamp_s : {50.0, 50.1, 50.2}) {
    add(0, stamp_s);
    next();
  }
  add(0, 40);
  EXPECT_EQ(scheduler.first(0).stamp, ros::Time(40));
  EXPECT_EQ(dropped(0), 3U);
}

TEST_F(CycleSchedulerTest, AQueueIsBounded) {
  CycleScheduler& scheduler = make({0, 0});
  late_ = {0};
  std::size_t waiting = 0;
  for (; scheduler.mayAdd(0, kStart); ++waiting) {
    add(0, 50 + 0.01 * static_cast<double>(waiting));
    next();
    ASSERT_LT(waiting, CycleScheduler::kMostWaiting);
  }
  EXPECT_EQ(waiting, CycleScheduler::kMostWaiting);
}

// Meshes come at exactly the rate, each a little late: one's lateness is not added to the next's.
TEST_F(CycleSchedulerTest, LatenessDoesNotAddUp) {
  CycleScheduler& scheduler = make({100, 0});
  for (int i = 0; i < 1000; ++i) {
    const SteadyTime now = kStart + milliseconds(10 * i + (i == 0 ? 0 : i % 5));
    ASSERT_TRUE(scheduler.mayAdd(0, now)) << i;
    add(0, 50, now);
    scheduler.start({0});
    ASSERT_FALSE(scheduler.mayAdd(0, now + milliseconds(5))) << i;
  }
  const SteadyTime late = kStart + milliseconds(10011);
  add(0, 50, late);
  EXPECT_EQ(scheduler.earliest(0), late + milliseconds(10)) << "what comes much later starts anew";
}

// Otherwise meshes that come one by one while the detector is busy would use up the rate.
TEST_F(CycleSchedulerTest, WhatReplacesTakesTheShareOfTheRate) {
  CycleScheduler& scheduler = make({10, 0});
  add(0, 50);
  EXPECT_TRUE(scheduler.mayAdd(0, kStart + milliseconds(1))) << "it may replace";
  add(0, 50.1, kStart + milliseconds(1));
  EXPECT_EQ(scheduler.earliest(0), kStart + milliseconds(100));
}

}  // namespace
}  // namespace deformable_contact_monitor
