// Requests are taken once, and whoever waits is woken.
#include "monitor/cycle/mailbox.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>
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

class MailboxTest : public ::testing::Test {
 protected:
  // Whether wait() came back long before its time.
  bool isWoken() {
    const Clock::time_point start = Clock::now();
    EXPECT_TRUE(mailbox_.wait(start + std::chrono::seconds(20)));
    return Clock::now() - start < std::chrono::seconds(10);
  }

  // What is new; nothing held: nothing is.
  AttachedObjects takeAttached() {
    const auto attached = mailbox_.take().attached;
    return attached ? *attached : AttachedObjects();
  }

  Mailbox mailbox_{initialRules()};
};

TEST_F(MailboxTest, WhatIsExpectedIsWaitedFor) {
  for (const int wait_us : {0, 200, 50000}) {  // awake, and asleep again
    std::atomic<bool> is_there{false};
    mailbox_.expect();
    std::thread later([&] {
      std::this_thread::sleep_for(std::chrono::microseconds(wait_us));
      is_there = true;
      mailbox_.wake();
    });
    EXPECT_TRUE(isWoken());
    EXPECT_TRUE(is_there);
    later.join();
  }
}

TEST_F(MailboxTest, WhatIsExpectedAndDoesNotComeChangesNothing) {
  constexpr std::chrono::milliseconds kTime(60);
  const Clock::time_point start = Clock::now();
  mailbox_.expect();
  EXPECT_TRUE(mailbox_.wait(start + kTime));
  EXPECT_GE(Clock::now() - start, kTime);
  mailbox_.expect();
  mailbox_.stop();
  EXPECT_FALSE(mailbox_.wait(start + std::chrono::seconds(20)));
  EXPECT_LT(Clock::now() - start, std::chrono::seconds(10));
}

TEST_F(MailboxTest, NothingIsAskedForAtFirst) {
  const Requests requests = mailbox_.take();
  EXPECT_FALSE(requests.reset);
  EXPECT_FALSE(requests.allowed_contacts);
  EXPECT_TRUE(requests.enabled);
}

TEST_F(MailboxTest, AResetIsTakenOnce) {
  mailbox_.requestReset();
  mailbox_.requestReset();
  EXPECT_TRUE(mailbox_.take().reset);
  EXPECT_FALSE(mailbox_.take().reset);
}

TEST_F(MailboxTest, EnabledStaysAsItWasAskedFor) {
  mailbox_.setEnabled(false);
  EXPECT_FALSE(mailbox_.take().enabled);
  EXPECT_FALSE(mailbox_.take().enabled);
  mailbox_.setEnabled(true);
  EXPECT_TRUE(mailbox_.take().enabled);
}

TEST_F(MailboxTest, RulesAddUpAndAreTakenOnce) {
  EXPECT_EQ(mailbox_.changeAllowedContacts({false, {}, {rule("arm", "cloth")}}).size(), 2U);
  EXPECT_EQ(mailbox_.changeAllowedContacts({false, {}, {rule("hand", "cloth")}}).size(), 3U);
  const Requests requests = mailbox_.take();
  ASSERT_TRUE(requests.allowed_contacts);
  EXPECT_TRUE(requests.allowed_contacts->allows("base", "cloth"));
  EXPECT_TRUE(requests.allowed_contacts->allows("arm", "cloth"));
  EXPECT_TRUE(requests.allowed_contacts->allows("cloth", "hand"));
  EXPECT_FALSE(mailbox_.take().allowed_contacts);
  EXPECT_EQ(mailbox_.changeAllowedContacts({false, {}, {}}).size(), 3U) << "rules stay in force";
}

TEST_F(MailboxTest, OneBadRuleAndNoneIsAdded) {
  EXPECT_THROW(
      mailbox_.changeAllowedContacts({false, {}, {rule("arm", "cloth"), rule("", "cloth")}}),
      std::invalid_argument);
  EXPECT_FALSE(mailbox_.take().allowed_contacts);
  EXPECT_EQ(mailbox_.changeAllowedContacts({false, {}, {}}).size(), 1U);
}

TEST_F(MailboxTest, RulesAreRemovedAndReplaced) {
  mailbox_.changeAllowedContacts({false, {}, {rule("arm", "cloth"), rule("hand", "cloth")}});
  const auto left = mailbox_.changeAllowedContacts({false, {rule("*", "base")}, {}});
  ASSERT_EQ(left.size(), 2U);
  EXPECT_EQ(left[0].body_a, "arm");
  EXPECT_FALSE(mailbox_.take().allowed_contacts->allows("base", "cloth"));
  EXPECT_EQ(mailbox_.changeAllowedContacts({true, {}, {rule("wrist", "*")}}).size(), 1U);
  EXPECT_TRUE(mailbox_.changeAllowedContacts({true, {}, {}}).empty());
}

TEST_F(MailboxTest, WhatIsHeldIsTakenOnceAndTheLastCallHolds) {
  EXPECT_FALSE(mailbox_.take().attached);
  mailbox_.attach("cable", {"hand"});
  mailbox_.attach("cloth", {"hand", "finger", "hand"});
  const AttachedObjects both{{"cable", {"hand"}}, {"cloth", {"finger", "hand"}}};
  EXPECT_EQ(mailbox_.attach("cloth", {"finger", "hand"}), both);
  EXPECT_EQ(takeAttached(), both);
  EXPECT_FALSE(mailbox_.take().attached);
  EXPECT_EQ(mailbox_.attach("cloth", {"wrist"}),
            (AttachedObjects{{"cable", {"hand"}}, {"cloth", {"wrist"}}}));
  EXPECT_EQ(mailbox_.attach("cable", {}), (AttachedObjects{{"cloth", {"wrist"}}}));
  EXPECT_EQ(mailbox_.attach("cable", {}), (AttachedObjects{{"cloth", {"wrist"}}}));
  EXPECT_EQ(takeAttached(), (AttachedObjects{{"cloth", {"wrist"}}}));
}

TEST_F(MailboxTest, AResetReleasesNothing) {
  mailbox_.attach("cloth", {"hand"});
  mailbox_.requestReset();
  const Requests requests = mailbox_.take();
  EXPECT_TRUE(requests.reset);
  EXPECT_EQ(requests.attached ? *requests.attached : AttachedObjects(),
            (AttachedObjects{{"cloth", {"hand"}}}));
}

TEST_F(MailboxTest, LinksThatAreGoneHoldNothing) {
  mailbox_.attach("cable", {"hand"});
  mailbox_.attach("cloth", {"finger", "hand"});
  mailbox_.take();
  EXPECT_TRUE(mailbox_.releaseFromOthers({"arm", "hand", "finger"}).empty());
  EXPECT_FALSE(mailbox_.take().attached) << "nothing changed";
  EXPECT_EQ(mailbox_.releaseFromOthers({"arm", "finger"}),
            (std::vector<std::string>{"cable by hand", "cloth by hand"}));
  EXPECT_EQ(takeAttached(), (AttachedObjects{{"cloth", {"finger"}}}));
}

// Each object is held by the links of one call, never by those of two.
TEST_F(MailboxTest, ThreadsAttachWhileAnotherTakes) {
  constexpr int kCalls = 500;
  const std::vector<std::string> objects{"cloth", "cable", "bag"};
  std::vector<std::thread> callers;
  for (const std::string& object : objects) {
    callers.emplace_back([&, object] {
      for (int i = 0; i < kCalls; ++i) {
        const std::string number = std::to_string(i);
        mailbox_.attach(object, {"left" + number, "right" + number});
      }
    });
  }
  AttachedObjects last;
  const auto look = [&] {
    const Requests requests = mailbox_.take();
    if (!requests.attached) return;
    last = *requests.attached;
    for (const auto& [object, links] : last) {
      ASSERT_EQ(links.size(), 2U);
      EXPECT_EQ(links[0].substr(4), links[1].substr(5)) << object;
    }
  };
  const std::string at_last = std::to_string(kCalls - 1);
  std::thread taker([&] {
    const auto give_up = Clock::now() + std::chrono::seconds(60);
    const std::vector<std::string> links{"left" + at_last, "right" + at_last};
    const AttachedObjects all{{"bag", links}, {"cable", links}, {"cloth", links}};
    while (last != all && Clock::now() < give_up) look();
    EXPECT_EQ(last, all);
  });
  for (std::thread& caller : callers) caller.join();
  taker.join();
}

TEST_F(MailboxTest, OfLiveParametersTheLastAreTakenOnce) {
  EXPECT_FALSE(mailbox_.take().live);
  LiveParameters live;
  live.margin_m = 0.25;
  mailbox_.change(live);
  live.margin_m = 0.5;
  mailbox_.change(live);
  EXPECT_EQ(mailbox_.take().live.value_or(LiveParameters()).margin_m, 0.5);
  EXPECT_FALSE(mailbox_.take().live);
}

TEST_F(MailboxTest, WithoutAnythingNewTheWaitLasts) {
  const Clock::time_point then = Clock::now() + std::chrono::milliseconds(30);
  EXPECT_TRUE(mailbox_.wait(then));
  EXPECT_GE(Clock::now(), then);
}

TEST_F(MailboxTest, EverythingThatIsAskedForWakes) {
  mailbox_.wake();
  EXPECT_TRUE(isWoken()) << "what comes before the wait counts too";
  mailbox_.requestReset();
  EXPECT_TRUE(isWoken());
  mailbox_.setEnabled(true);
  EXPECT_TRUE(isWoken());
  mailbox_.changeAllowedContacts({false, {}, {}});
  EXPECT_TRUE(isWoken());
  mailbox_.attach("cloth", {});
  EXPECT_TRUE(isWoken());
  mailbox_.change(LiveParameters());
  EXPECT_TRUE(isWoken());
  std::thread other([this] { mailbox_.wake(); });
  EXPECT_TRUE(isWoken());
  other.join();
}

TEST_F(MailboxTest, OneWakeEndsOneWait) {
  mailbox_.wake();
  mailbox_.wake();
  EXPECT_TRUE(isWoken());
  const Clock::time_point then = Clock::now() + std::chrono::milliseconds(30);
  EXPECT_TRUE(mailbox_.wait(then));
  EXPECT_GE(Clock::now(), then);
}

TEST_F(MailboxTest, StopEndsTheWaitForGood) {
  std::thread other([this] { mailbox_.stop(); });
  EXPECT_FALSE(mailbox_.wait(Clock::now() + std::chrono::seconds(20)));
  other.join();
  const Clock::time_point then = Clock::now() + std::chrono::seconds(20);
  EXPECT_FALSE(mailbox_.wait(then));
  EXPECT_LT(Clock::now(), then) << "it ends every later wait too";
}

}  // namespace
}  // namespace deformable_contact_monitor
