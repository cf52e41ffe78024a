// Tests of what ~contact_states says by itself: order, numbers, and how `since` counts.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "monitor/state/contact_state_tracker.h"
#include "sample_report.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kBaseHand = 0, kHandCloth = 1;
constexpr double kStepS = 0.1;

StateRules rulesOf(double since_survives_s) {
  StateRules rules;
  rules.debounce_off_cycles = 2;
  rules.since_survives_s = since_survives_s;
  return rules;
}

// Cycles 0.1 s apart, each at its stamp: 'C' contact, '-' none, 'n' near, '?' the hand is unknown,
// 'a' allowed.
struct Feed {
  explicit Feed(double since_survives_s) : tracker(rulesOf(since_survives_s)) {}

  const ContactStates& step(char c) {
    sample.report.header.stamp += ros::Duration(kStepS);
    sample.report.now = sample.report.header.stamp;
    sample.result.contacts = c == '-' || c == 'n' ? TrianglePairs() : contacts;
    sample.result.nearest.clear();
    if (c == 'n') {
      sample.result.nearest = {{{0, 0, 2, 0}, .1F, {1, 0, 0}, {1, 0, .1F}, {0, 0, 1}}};
    }
    sample.report.bodies[0].unknown_because = c == '?' ? "no transform" : "";
    sample.report.pairs[kHandCloth].allowed = c == 'a';
    tracker.update(sample.report);
    return message = tracker.states(sample.report.header.stamp, sample.report.now);
  }

  // `since` of hand and cloth after these cycles, in cycles.
  int since(const std::string& cycles) {
    for (const char c : cycles) step(c);
    return static_cast<int>(std::lround(message.states[kHandCloth].since.toSec() / kStepS));
  }

  SampleReport sample;
  const TrianglePairs contacts = sample.result.contacts;
  ContactStateTracker tracker;
  ContactStates message;
};

TEST(StateMessagesTest, sinceSurvivesAShortUnknown) {
  EXPECT_EQ(Feed(0.15).since("CCC?CC"), 5);
  EXPECT_EQ(Feed(0.15).since("nn?nnn"), 5);
  EXPECT_EQ(Feed(0.15).since("--?-"), 3);
  EXPECT_EQ(Feed(0.15).since("CC?C?C?C"), 7);
}

TEST(StateMessagesTest, aLongerUnknownOrAnotherStateInterrupts) {
  EXPECT_EQ(Feed(0.15).since("CCC??CC"), 1);
  EXPECT_EQ(Feed(0.1).since("CCC?CC"), 1) << "shorter than the parameter, not as long";
  EXPECT_EQ(Feed(0).since("CCC?CC"), 1);
  EXPECT_EQ(Feed(0.15).since("CCC?-CC"), 1);
  EXPECT_EQ(Feed(0.15).since("CCC?nn"), 1);
  EXPECT_EQ(Feed(1.0).since("CCCa?C"), 0) << "an allowed pair was not in contact";
}

TEST(StateMessagesTest, unknownHasASinceOfItsOwn) {
  EXPECT_EQ(Feed(1.0).since("CCC?"), 0);
  EXPECT_EQ(Feed(1.0).since("CCC???"), 2);
  EXPECT_EQ(Feed(1.0).since("CC?C???"), 2);
}

TEST(StateMessagesTest, aNewPairHasNothingToResume) {
  EXPECT_EQ(Feed(1.0).since("-"), 0);
  EXPECT_EQ(Feed(1.0).since("?-"), 0);
}

TEST(StateMessagesTest, whatIsForgottenIsNotResumed) {
  for (const char* unknown : {"", "?"}) {
    Feed feed(1.0);
    feed.since("CCC" + std::string(unknown));
    feed.tracker.forget("", "reset", feed.sample.report.now);
    EXPECT_EQ(feed.since("CC"), 1);
  }
}

TEST(StateMessagesTest, eventsAreTheSameWithAndWithout) {
  std::vector<std::string> before;
  for (const double since_survives_s : {0.0, 0.15, 1.0}) {
    Feed feed(since_survives_s);
    feed.since("CCC?CC--?-nCC??C");
    std::vector<std::string> events;
    for (const ContactEvent& event : feed.tracker.takeEvents()) {
      events.push_back(std::to_string(event.type) + " " + event.body_a + " " +
                       std::to_string(event.header.stamp.toSec()) + " " + event.reason);
    }
    EXPECT_EQ(events.size(), 7U);
    if (!before.empty()) {
      EXPECT_EQ(events, before);
    }
    before = events;
  }
}

// `since` of a known state in a walk, by its definition: back over cycles of that state, and over
// UNKNOWN in between that was said for less than the parameter.
int sinceByDefinition(const std::string& walk, double since_survives_s) {
  const auto end = static_cast<int>(walk.size()) - 1;
  int began = end;
  int unknown = 0;
  for (int i = end - 1; i >= 0; --i) {
    if (walk[i] == '?') {
      ++unknown;
      continue;
    }
    if (walk[i] != walk[end] || (unknown > 0 && unknown * kStepS >= since_survives_s)) break;
    began = i;
    unknown = 0;
  }
  return end - began;
}

TEST(StateMessagesTest, randomWalksAgreeWithTheDefinition) {
  std::mt19937 random(14);
  int resumed = 0;
  for (int round = 0; round < 300; ++round) {
    const double since_survives_s = 0.05 + kStepS * static_cast<double>(random() % 4);
    Feed feed(since_survives_s);
    std::string walk;
    for (int i = 0; i < 25; ++i) {
      walk += std::string("CCCn-??")[random() % 7];
      const int since = feed.since(walk.substr(walk.size() - 1));
      if (walk.back() == '?') continue;
      ASSERT_EQ(since, sinceByDefinition(walk, since_survives_s))
          << walk << " with " << since_survives_s;
      if (since > sinceByDefinition(walk, 0)) ++resumed;
    }
  }
  EXPECT_GT(resumed, 300);
}

// Everything that a reader goes by, in every state.
void expectReadableAlone(const ContactStates& message, const std::vector<BodyStatus>& bodies) {
  const auto place = [&bodies](const std::string& name) {
    return std::find_if(bodies.begin(), bodies.end(),
                        [&name](const BodyStatus& body) { return body.name == name; }) -
           bodies.begin();
  };
  std::pair<std::ptrdiff_t, std::ptrdiff_t> last(-1, -1);
  bool complete = true;
  for (const ContactState& s : message.states) {
    const std::pair<std::ptrdiff_t, std::ptrdiff_t> pair(place(s.body_a), place(s.body_b));
    EXPECT_LE(pair.first, pair.second);
    EXPECT_LT(last, pair);
    last = pair;
    const bool unknown = s.state == ContactState::UNKNOWN;
    complete = complete && !unknown;
    EXPECT_EQ(s.reason.empty(), !unknown);
    EXPECT_EQ(std::isnan(s.min_separation), unknown || s.state == ContactState::ALLOWED);
    EXPECT_EQ(s.min_separation == std::numeric_limits<float>::infinity(),
              s.state == ContactState::NONE);
    EXPECT_TRUE(s.state != ContactState::NEAR || s.min_separation > 0);
    EXPECT_TRUE(s.state != ContactState::CONTACT || s.min_separation <= 0);
    const bool is_near = s.state == ContactState::NEAR;
    const bool has_place = is_near || s.state == ContactState::CONTACT;
    EXPECT_EQ(s.pair_count > 0, s.state == ContactState::CONTACT);
    for (const geometry_msgs::Point32& p :
         {s.centroid, s.mean_normal, s.point_a, s.point_b, s.normal}) {
      EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
      EXPECT_TRUE(has_place || (p.x == 0 && p.y == 0 && p.z == 0));
    }
    EXPECT_EQ(s.point_a == s.point_b, !is_near);
    EXPECT_EQ(s.normal == geometry_msgs::Point32(), !is_near) << "contact_geometry is off";
    EXPECT_FALSE(std::isnan(s.distance_low));
    EXPECT_GE(s.since, ros::Duration(0));
    EXPECT_FALSE(s.stamp.isZero());
  }
  EXPECT_EQ(message.complete, complete);
}

TEST(StateMessagesTest, canBeReadAloneInEveryState) {
  Feed feed(0.15);
  for (const char c : std::string("-nC?a-?Can?nC-")) {
    const ContactStates& message = feed.step(c);
    ASSERT_EQ(message.states.size(), 3U);
    expectReadableAlone(message, feed.sample.report.bodies);
    EXPECT_EQ(message.states[kBaseHand].state, ContactState::ALLOWED);
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
