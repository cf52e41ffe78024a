// Requests are taken once, and whoever waits is woken.
#include "node/mailbox.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <thread>

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

  Mailbox mailbox_{initialRules()};
};

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
