// Tests that requests are taken once, and that whoever waits is woken.
#include "monitor/cycle/loop_requests.h"

#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace deformable_contact_monitor {
namespace {

using Clock = std::chrono::steady_clock;

AllowedContact rule(const std::string& a, const std::string& b) {
  AllowedContact rule;
  rule.body_a = a;
  rule.body_b = b;
  rule.allowed = true;
  return rule;
}

AllowedContacts initialRules() {
  AllowedContacts allowed;
  allowed.add(rule("base", "*"));
  return allowed;
}

class LoopRequestsTest : public ::testing::Test {
 protected:
  // Returns whether wait() came back long before its time.
  bool isWoken() {
    const Clock::time_point start = Clock::now();
    EXPECT_TRUE(requests_.wait(start + std::chrono::seconds(20)));
    return Clock::now() - start < std::chrono::seconds(10);
  }

  // Returns the new attachments; empty: there are none, or nothing new.
  AttachedObjects takeAttached() {
    const auto attached = requests_.take().attached;
    return attached ? *attached : AttachedObjects();
  }

  LoopRequests requests_{initialRules()};
};

TEST_F(LoopRequestsTest, NothingIsAskedForAtFirst) {
  const Requests requests = requests_.take();
  EXPECT_FALSE(requests.reset);
  EXPECT_FALSE(requests.allowed_contacts);
  EXPECT_TRUE(requests.enabled);
}

TEST_F(LoopRequestsTest, AResetIsTakenOnce) {
  requests_.requestReset();
  requests_.requestReset();
  EXPECT_TRUE(requests_.take().reset);
  EXPECT_FALSE(requests_.take().reset);
}

TEST_F(LoopRequestsTest, EnabledStaysAsItWasAskedFor) {
  requests_.setEnabled(false);
  EXPECT_FALSE(requests_.take().enabled);
  EXPECT_FALSE(requests_.take().enabled);
  requests_.setEnabled(true);
  EXPECT_TRUE(requests_.take().enabled);
}

TEST_F(LoopRequestsTest, DisabledForAMomentIsTakenOnce) {
  requests_.setEnabled(false);
  requests_.setEnabled(true);
  const Requests requests = requests_.take();
  EXPECT_TRUE(requests.enabled);
  EXPECT_TRUE(requests.disabled);
  EXPECT_FALSE(requests_.take().disabled);
}

TEST_F(LoopRequestsTest, AnEpochBeginsWithEachRequestThatDiscards) {
  EXPECT_EQ(requests_.take().epoch, 0U);
  EXPECT_EQ(requests_.requestReset(), 1U);
  EXPECT_EQ(requests_.setEnabled(false), 2U);
  EXPECT_EQ(requests_.setEnabled(true), 2U);
  EXPECT_EQ(requests_.take().epoch, 2U);
  EXPECT_EQ(requests_.take().epoch, 2U);
}

TEST_F(LoopRequestsTest, RulesAddUpAndAreTakenOnce) {
  EXPECT_EQ(requests_.changeAllowedContacts({false, {}, {rule("arm", "cloth")}}).size(), 2U);
  EXPECT_EQ(requests_.changeAllowedContacts({false, {}, {rule("hand", "cloth")}}).size(), 3U);
  const Requests requests = requests_.take();
  ASSERT_TRUE(requests.allowed_contacts);
  EXPECT_TRUE(requests.allowed_contacts->allows("base", "cloth"));
  EXPECT_TRUE(requests.allowed_contacts->allows("arm", "cloth"));
  EXPECT_TRUE(requests.allowed_contacts->allows("cloth", "hand"));
  EXPECT_FALSE(requests_.take().allowed_contacts);
  EXPECT_EQ(requests_.changeAllowedContacts({false, {}, {}}).size(), 3U) << "rules stay in force";
}

TEST_F(LoopRequestsTest, OneBadRuleAndNoneIsAdded) {
  EXPECT_THROW(
      requests_.changeAllowedContacts({false, {}, {rule("arm", "cloth"), rule("", "cloth")}}),
      std::invalid_argument);
  EXPECT_FALSE(requests_.take().allowed_contacts);
  EXPECT_EQ(requests_.changeAllowedContacts({false, {}, {}}).size(), 1U);
}

TEST_F(LoopRequestsTest, RulesAreRemovedAndReplaced) {
  requests_.changeAllowedContacts({false, {}, {rule("arm", "cloth"), rule("hand", "cloth")}});
  const auto left = requests_.changeAllowedContacts({false, {rule("*", "base")}, {}});
  ASSERT_EQ(left.size(), 2U);
  EXPECT_EQ(left[0].body_a, "arm");
  EXPECT_FALSE(requests_.take().allowed_contacts->allows("base", "cloth"));
  EXPECT_EQ(requests_.changeAllowedContacts({true, {}, {rule("wrist", "*")}}).size(), 1U);
  EXPECT_TRUE(requests_.changeAllowedContacts({true, {}, {}}).empty());
}

TEST_F(LoopRequestsTest, WhatIsHeldIsTakenOnceAndTheLastCallHolds) {
  EXPECT_FALSE(requests_.take().attached);
  requests_.attach("cable", {"hand"});
  requests_.attach("cloth", {"hand", "finger", "hand"});
  const AttachedObjects both{{"cable", {{"hand"}}}, {"cloth", {{"finger", "hand"}}}};
  EXPECT_EQ(requests_.attach("cloth", {"finger", "hand"}), both);
  EXPECT_EQ(takeAttached(), both);
  EXPECT_FALSE(requests_.take().attached);
  EXPECT_EQ(requests_.attach("cloth", {"wrist"}),
            (AttachedObjects{{"cable", {{"hand"}}}, {"cloth", {{"wrist"}}}}));
  EXPECT_EQ(requests_.attach("cable", {}), (AttachedObjects{{"cloth", {{"wrist"}}}}));
  EXPECT_EQ(requests_.attach("cable", {}), (AttachedObjects{{"cloth", {{"wrist"}}}}));
  EXPECT_EQ(takeAttached(), (AttachedObjects{{"cloth", {{"wrist"}}}}));
}

TEST_F(LoopRequestsTest, AResetReleasesNothing) {
  requests_.attach("cloth", {"hand"});
  requests_.requestReset();
  const Requests requests = requests_.take();
  EXPECT_TRUE(requests.reset);
  EXPECT_EQ(requests.attached ? *requests.attached : AttachedObjects(),
            (AttachedObjects{{"cloth", {{"hand"}}}}));
}

TEST_F(LoopRequestsTest, LinksThatAreGoneHoldNothing) {
  requests_.attach("cable", {"hand"});
  requests_.attach("cloth", {"finger", "hand"});
  requests_.take();
  EXPECT_TRUE(requests_.releaseFromOthers({"arm", "hand", "finger"}).empty());
  EXPECT_FALSE(requests_.take().attached) << "nothing changed";
  EXPECT_EQ(requests_.releaseFromOthers({"arm", "finger"}),
            (std::vector<std::string>{"cable by hand", "cloth by hand"}));
  EXPECT_EQ(takeAttached(), (AttachedObjects{{"cloth", {{"finger"}}}}));
}

TEST_F(LoopRequestsTest, AHeldPartStaysWithItsLinksAndEndsOnce) {
  const auto part = std::make_shared<const HeldPart>(), later = std::make_shared<const HeldPart>();
  requests_.attach("cloth", {"finger", "hand"}, part);
  EXPECT_EQ(takeAttached(), (AttachedObjects{{"cloth", {{"finger", "hand"}, part}}}));
  requests_.releaseFromOthers({"finger"});
  EXPECT_EQ(takeAttached(), (AttachedObjects{{"cloth", {{"finger"}, part}}}));
  requests_.attach("cloth", {"hand"}, later);
  EXPECT_TRUE(requests_.endHolds({{"cloth", {{}, part}}, {"rope", {{}, part}}}).empty());
  EXPECT_EQ(takeAttached(), (AttachedObjects{{"cloth", {{"hand"}, later}}})) << "it was replaced";
  EXPECT_EQ(requests_.endHolds({{"cloth", {{}, later}}}).size(), 1U);
  EXPECT_FALSE(requests_.take().attached) << "the detection thread knows";
  EXPECT_TRUE(requests_.attach("cable", {}).empty());
}

TEST_F(LoopRequestsTest, ARigidObjectFallsWithTheLinkThatCarriesIt) {
  const auto grip = std::make_shared<const RigidGrip>(RigidGrip{"palm", {}});
  requests_.attach("tool", {"palm", "finger"}, nullptr, grip);
  EXPECT_EQ(takeAttached(), (AttachedObjects{{"tool", {{"finger", "palm"}, nullptr, grip}}}));
  EXPECT_EQ(requests_.attached().count("tool"), 1U);
  requests_.releaseFromOthers({"palm"});
  EXPECT_EQ(takeAttached(), (AttachedObjects{{"tool", {{"palm"}, nullptr, grip}}}));
  requests_.attach("tool", {"palm", "finger"}, nullptr, grip);
  EXPECT_EQ(requests_.releaseFromOthers({"finger"}),
            (std::vector<std::string>{"tool by finger", "tool by palm"}));
  EXPECT_TRUE(takeAttached().empty());
}

// At any time an object is attached to the links of one call, never to those of two.
TEST_F(LoopRequestsTest, ThreadsAttachWhileAnotherTakes) {
  constexpr int kCalls = 500;
  const std::vector<std::string> objects{"cloth", "cable", "bag"};
  std::vector<std::thread> callers;
  for (const std::string& object : objects) {
    callers.emplace_back([&, object] {
      for (int i = 0; i < kCalls; ++i) {
        const std::string number = std::to_string(i);
        requests_.attach(object, {"left" + number, "right" + number});
      }
    });
  }
  AttachedObjects last;
  const auto look = [&] {
    const Requests requests = requests_.take();
    if (!requests.attached) return;
    last = *requests.attached;
    for (const auto& [object, held] : last) {
      ASSERT_EQ(held.links.size(), 2U);
      EXPECT_EQ(held.links[0].substr(4), held.links[1].substr(5)) << object;
    }
  };
  const std::string at_last = std::to_string(kCalls - 1);
  std::thread taker([&] {
    const auto give_up = Clock::now() + std::chrono::seconds(60);
    const std::vector<std::string> links{"left" + at_last, "right" + at_last};
    const AttachedObjects all{{"bag", {links}}, {"cable", {links}}, {"cloth", {links}}};
    while (last != all && Clock::now() < give_up) look();
    EXPECT_EQ(last, all);
  });
  for (std::thread& caller : callers) caller.join();
  taker.join();
}

TEST_F(LoopRequestsTest, OfLiveParametersTheLastAreTakenOnce) {
  EXPECT_FALSE(requests_.take().live);
  LiveParameters live;
  live.margin_m = 0.25;
  requests_.change(live);
  live.margin_m = 0.5;
  requests_.change(live);
  EXPECT_EQ(requests_.take().live.value_or(LiveParameters()).margin_m, 0.5);
  EXPECT_FALSE(requests_.take().live);
}

TEST_F(LoopRequestsTest, WithoutAnythingNewTheWaitLasts) {
  const Clock::time_point then = Clock::now() + std::chrono::milliseconds(30);
  EXPECT_TRUE(requests_.wait(then));
  EXPECT_GE(Clock::now(), then);
}

TEST_F(LoopRequestsTest, WhatIsInForceStaysAfterItWasTaken) {
  const InForce first = requests_.inForce();
  EXPECT_TRUE(first.enabled);
  EXPECT_FALSE(first.live);
  EXPECT_EQ(first.allowed_contacts->count(), 1U);
  EXPECT_TRUE(first.attached->empty());
  std::uint64_t revision = first.revision;
  const auto changed = [&] { return std::exchange(revision, requests_.inForce().revision); };
  requests_.changeAllowedContacts({false, {}, {rule("arm", "cloth")}});
  EXPECT_LT(changed(), revision);
  requests_.attach("cloth", {"hand"}, std::make_shared<const HeldPart>());
  requests_.attach("cable", {"finger"});
  EXPECT_LT(changed(), revision);
  LiveParameters live;
  live.margin_m = 0.5;
  requests_.change(live);
  EXPECT_LT(changed(), revision);
  requests_.take();
  EXPECT_EQ(changed(), revision);
  const InForce now = requests_.inForce();
  EXPECT_TRUE(now.allowed_contacts->allows("arm", "cloth"));
  EXPECT_EQ(now.attached->size(), 2U);
  EXPECT_EQ(now.live->margin_m, 0.5);
  requests_.endHolds({{"cloth", now.attached->at("cloth")}});
  EXPECT_EQ(requests_.inForce().attached->count("cloth"), 0U);
  EXPECT_LT(changed(), revision);
  requests_.releaseFromOthers({"hand"});
  EXPECT_TRUE(requests_.inForce().attached->empty());
  EXPECT_LT(changed(), revision);
  requests_.setEnabled(false);
  EXPECT_FALSE(requests_.inForce().enabled);
}

TEST_F(LoopRequestsTest, EverythingThatIsAskedForWakes) {
  requests_.wake();
  EXPECT_TRUE(isWoken()) << "what comes before the wait counts too";
  requests_.requestReset();
  EXPECT_TRUE(isWoken());
  requests_.setEnabled(true);
  EXPECT_TRUE(isWoken());
  requests_.changeAllowedContacts({false, {}, {}});
  EXPECT_TRUE(isWoken());
  requests_.attach("cloth", {});
  EXPECT_TRUE(isWoken());
  requests_.change(LiveParameters());
  EXPECT_TRUE(isWoken());
  std::thread other([this] { requests_.wake(); });
  EXPECT_TRUE(isWoken());
  other.join();
}

TEST_F(LoopRequestsTest, OneWakeEndsOneWait) {
  requests_.wake();
  requests_.wake();
  EXPECT_TRUE(isWoken());
  const Clock::time_point then = Clock::now() + std::chrono::milliseconds(30);
  EXPECT_TRUE(requests_.wait(then));
  EXPECT_GE(Clock::now(), then);
}

TEST_F(LoopRequestsTest, StopEndsTheWaitForGood) {
  std::thread other([this] { requests_.stop(); });
  EXPECT_FALSE(requests_.wait(Clock::now() + std::chrono::seconds(20)));
  other.join();
  const Clock::time_point then = Clock::now() + std::chrono::seconds(20);
  EXPECT_FALSE(requests_.wait(then));
  EXPECT_LT(Clock::now(), then) << "it ends every later wait too";
}

}  // namespace
}  // namespace deformable_contact_monitor
