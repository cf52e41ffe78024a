// Whose cycle is next.
#include "monitor/cycle/cycle_turns.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace deformable_contact_monitor {
namespace {

using std::chrono::milliseconds;
using Who = std::vector<std::size_t>;

const SteadyTime kStart{std::chrono::hours(7)};

CycleTurns::Waiting at(double stamp_s) { return {ros::Time(stamp_s), kStart, kStart}; }

bool always(std::size_t /*who*/) { return true; }

TEST(CycleTurnsTest, NobodyWaitsAtFirst) {
  const CycleTurns turns({0, 0});
  EXPECT_TRUE(turns.next(always).empty());
  EXPECT_FALSE(turns.anyWaits());
  EXPECT_TRUE(turns.mayWait(0, kStart) && turns.mayWait(1, kStart));
}

TEST(CycleTurnsTest, WhoseTurnIsTheLongestAgoIsNextWhateverTheStamps) {
  CycleTurns turns({0, 0, 0});
  for (int round = 0; round < 3; ++round) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (turns.waiting(i).empty()) turns.wait(i, at(50 - static_cast<double>(i)), kStart);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const Who next = turns.next(always);
      ASSERT_EQ(next, Who{i});
      turns.start(next);
      if (i == 0) turns.wait(0, at(10 + round), kStart);
      turns.replaceLast(0, at(10 + round));  // the earliest, again and again
    }
    for (const std::size_t i : {1, 2}) turns.wait(i, at(50), kStart);
    for (std::size_t i = 0; i < 3; ++i) turns.start({i});
  }
}

TEST(CycleTurnsTest, OneStampIsOneCycle) {
  CycleTurns turns({0, 0, 0});
  turns.wait(0, at(50), kStart);
  turns.wait(1, at(51), kStart);
  turns.wait(2, at(50), kStart);
  EXPECT_EQ(turns.next(always), (Who{0, 2}));
  EXPECT_EQ(turns.next([](std::size_t who) { return who != 2; }), Who{0}) << "it is not ready";
  turns.start({0, 2});
  EXPECT_EQ(turns.next(always), Who{1});
  EXPECT_TRUE(turns.waiting(0).empty());
}

TEST(CycleTurnsTest, WhoOverranSharesWithNobodyUntilATurnEndsInTime) {
  CycleTurns turns({0, 0, 0});
  turns.finish({0, 1}, true);
  EXPECT_TRUE(turns.overran(0) && turns.overran(1) && !turns.overran(2));
  for (std::size_t i = 0; i < 3; ++i) turns.wait(i, at(50), kStart);
  EXPECT_EQ(turns.next(always), Who{0});
  turns.start({0});
  turns.finish({0}, false);
  turns.wait(0, at(50), kStart);
  EXPECT_EQ(turns.next(always), Who{1});
  turns.start({1});
  turns.wait(1, at(50), kStart);
  EXPECT_EQ(turns.next(always), (Who{0, 2})) << "1 has not ended in time yet";
  turns.clear();
  EXPECT_FALSE(turns.overran(1));
}

TEST(CycleTurnsTest, WhoIsNotReadyLetsOthersPass) {
  CycleTurns turns({0, 0});
  turns.wait(0, at(50), kStart);
  turns.wait(1, at(51), kStart);
  EXPECT_EQ(turns.next([](std::size_t who) { return who == 1; }), Who{1});
  EXPECT_TRUE(turns.next([](std::size_t) { return false; }).empty());
}

// To ask costs lookups of transforms.
TEST(CycleTurnsTest, OnlyThoseAreAskedWhoseAnswerMatters) {
  CycleTurns turns({0, 0, 0, 0});
  for (std::size_t i = 0; i < 4; ++i)
    turns.wait(i, at(i == 3 ? 50 : 50 + static_cast<double>(i)), kStart);
  Who asked;
  const Who next = turns.next([&asked](std::size_t who) {
    asked.push_back(who);
    return true;
  });
  EXPECT_EQ(next, (Who{0, 3}));
  EXPECT_EQ(asked, (Who{0, 3}));
}

TEST(CycleTurnsTest, EachHasARateOfItsOwn) {
  CycleTurns turns({10, 0});
  for (const std::size_t who : {0, 1}) turns.wait(who, at(50), kStart);
  turns.start({0, 1});
  EXPECT_FALSE(turns.mayWait(0, kStart + milliseconds(99)));
  EXPECT_TRUE(turns.mayWait(0, kStart + milliseconds(100)));
  EXPECT_TRUE(turns.mayWait(1, kStart));
  EXPECT_EQ(turns.earliest(0), kStart + milliseconds(100));
}

TEST(CycleTurnsTest, NewRatesHoldFromTheLastTurnOn) {
  CycleTurns turns({10, 0, 10});
  for (const std::size_t who : {0, 1}) turns.wait(who, at(50), kStart);
  turns.start({0, 1});
  turns.setRates({20, 10, 1});
  EXPECT_EQ(turns.earliest(0), kStart + milliseconds(50));
  EXPECT_EQ(turns.earliest(1), kStart + milliseconds(100));
  EXPECT_TRUE(turns.mayWait(2, kStart)) << "it had no turn yet";
  turns.setRates({0, 0, 0});
  EXPECT_EQ(turns.earliest(0), kStart);
  turns.wait(0, at(60), kStart + milliseconds(1));
  turns.start({0});
  EXPECT_TRUE(turns.mayWait(0, kStart + milliseconds(1)));
}

TEST(CycleTurnsTest, WhatIsDroppedHasNoTurn) {
  CycleTurns turns({0, 0});
  for (const std::size_t who : {0, 1}) turns.wait(who, at(50), kStart);
  turns.drop(0);
  EXPECT_EQ(turns.next(always), Who{1});
  EXPECT_TRUE(turns.mayWait(0, kStart));
}

TEST(CycleTurnsTest, WhatIsClearedDoesNotWait) {
  CycleTurns turns({0});
  turns.wait(0, at(50), kStart);
  EXPECT_TRUE(turns.anyWaits());
  turns.clear();
  EXPECT_FALSE(turns.anyWaits());
  EXPECT_TRUE(turns.waiting(0).empty());
}

TEST(CycleTurnsTest, AQueueIsServedFromItsFront) {
  CycleTurns turns({0});
  turns.wait(0, at(50), kStart);
  turns.wait(0, at(51), kStart);
  EXPECT_TRUE(turns.isLastReplaceable(0));
  turns.holdUp(0);
  EXPECT_FALSE(turns.isLastReplaceable(0)) << "it waits for transforms";
  turns.wait(0, at(52), kStart);
  EXPECT_TRUE(turns.isLastReplaceable(0));
  turns.replaceLast(0, at(53));
  std::vector<double> stamps;
  for (; !turns.next(always).empty(); turns.start({0})) {
    stamps.push_back(turns.waiting(0).front().stamp.toSec());
  }
  EXPECT_EQ(stamps, (std::vector<double>{50, 51, 53}));
}

TEST(CycleTurnsTest, AQueueIsBounded) {
  CycleTurns turns({0});
  std::size_t waiting = 0;
  for (; turns.mayWait(0, kStart); ++waiting) {
    turns.wait(0, at(50 + static_cast<double>(waiting)), kStart);
    ASSERT_LT(waiting, CycleTurns::kMostWaiting);
  }
  EXPECT_EQ(waiting, CycleTurns::kMostWaiting);
}

// Meshes at the very rate, each a little late: what one is late is not added to the next one's.
TEST(CycleTurnsTest, LatenessDoesNotAddUp) {
  CycleTurns turns({100});
  for (int i = 0; i < 1000; ++i) {
    const SteadyTime now = kStart + milliseconds(10 * i + (i == 0 ? 0 : i % 5));
    ASSERT_TRUE(turns.mayWait(0, now)) << i;
    turns.wait(0, at(50), now);
    turns.start({0});
    ASSERT_FALSE(turns.mayWait(0, now + milliseconds(5))) << i;
  }
  const SteadyTime late = kStart + milliseconds(10011);
  turns.wait(0, at(50), late);
  EXPECT_EQ(turns.earliest(0), late + milliseconds(10)) << "what comes much later starts anew";
}

// Or meshes that come one by one while the detector is busy would use up the rate.
TEST(CycleTurnsTest, WhatReplacesTakesTheShareOfTheRate) {
  CycleTurns turns({10});
  turns.wait(0, at(50), kStart);
  EXPECT_TRUE(turns.mayWait(0, kStart + milliseconds(1))) << "it may replace";
  turns.replaceLast(0, at(51));
  EXPECT_EQ(turns.earliest(0), kStart + milliseconds(100));
}

}  // namespace
}  // namespace deformable_contact_monitor
