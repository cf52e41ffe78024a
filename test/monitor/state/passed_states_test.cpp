// Tests the states of pairs under continuous collision detection: what a cycle reports about the
// time since the cycle before.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdio>
#include <functional>
#include <string>

#include "monitor/state/contact_state_tracker.h"
#include "sample_step.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kHandCloth = 1, kBaseCloth = 2;
const std::string kNames[] = {"NONE", "NEAR", "CONTACT", "ALLOWED", "UNKNOWN", "PASSED"};

// Cycles 0.1 s apart. At the stamp: '-' none, 'n' near, 'C' contact; with a capital 'P' or 'N'
// there was a contact in the step before; 'L' none at the stamp, and no step; 'X' as '-', the step
// cut off.
struct Feed {
  explicit Feed(int on = 1, int off = 2, double tolerated_rejects = 0, double since_survives_s = 0)
      : tracker({on, off, 0.5, tolerated_rejects, since_survives_s}) {}

  void step(char c) {
    SampleStep sample;
    stamp += ros::Duration(0.1);
    sample.report.header.stamp = sample.report.now = stamp;
    sample.sweep().from = stamp - ros::Duration(0.1);
    if (c == 'C') sample.result.contacts = {{0, 0, 2, 0}};
    if (c == 'n' || c == 'N') {
      sample.result.nearest = {{{0, 0, 2, 0}, 0.25F, {1, 0, 0}, {1, 0, 0.25F}, {0, 0, 1}}};
    }
    if (c != 'P' && c != 'N' && c != 'C') {
      sample.step.detection.contacts.clear();
      sample.step.detection.first_times.clear();
    }
    if (c == 'L') sample.lackStep("reset");
    if (c == 'X') sample.step.detection.cutOff(kNoTime);
    if (change) change(&sample);
    tracker.update(sample.report);
    states = tracker.states(sample.report.header.stamp, sample.report.now);
    seen += (seen.empty() ? "" : " ") + kNames[of(kHandCloth).state];
  }

  // The states of hand and cloth, one a cycle.
  std::string run(const std::string& cycles) {
    seen.clear();
    for (const char c : cycles) step(c);
    return seen;
  }

  // "PASSED 0.25 2 BEGIN 0 1", with first_low and pair_count.
  std::string events() {
    std::string all;
    for (const ContactEvent& event : tracker.takeEvents()) {
      char text[60];
      std::snprintf(text, sizeof text, "%s%s %g %u", all.empty() ? "" : " ",
                    event.type == ContactEvent::BEGIN ? "BEGIN"
                    : event.type == ContactEvent::END ? "END"
                                                      : "PASSED",
                    event.first_low, event.pair_count);
      all += text;
    }
    return all;
  }

  const ContactState& of(std::size_t pair) const { return states.states[pair]; }

  ros::Time stamp{100};
  ContactStateTracker tracker;
  ContactStates states;
  std::string seen;
  std::function<void(SampleStep*)> change;
};

TEST(PassedStatesTest, WhatTouchedInBetweenAndDoesNotAtTheStampHasPassed) {
  Feed feed;
  EXPECT_EQ(feed.run("--P-NnC"), "NONE NONE PASSED NONE PASSED NEAR CONTACT");
}

// A cycle in between was lost, for example because memory ran out before it was published.
TEST(PassedStatesTest, AStepThatBeginsLaterThanTheStateBeforeIsUnknown) {
  Feed feed;
  feed.run("-");
  feed.stamp += ros::Duration(0.1);
  EXPECT_EQ(feed.run("--"), "UNKNOWN NONE");
  EXPECT_EQ(feed.run("n"), "NEAR");
  feed.stamp += ros::Duration(0.1);
  EXPECT_EQ(feed.run("nP"), "UNKNOWN PASSED");
  feed.stamp += ros::Duration(0.1);
  EXPECT_EQ(feed.run("P-"), "PASSED NONE") << "that is known, whatever happened before";
}

// The points would be those at the stamp, where the two do not touch.
TEST(PassedStatesTest, ItHasNoNearestPoints) {
  Feed feed;
  feed.run("-n");
  EXPECT_EQ(feed.of(kHandCloth).point_b.z, 0.25F);
  feed.run("N");
  const ContactState& state = feed.of(kHandCloth);
  EXPECT_EQ(state.state, ContactState::PASSED);
  EXPECT_EQ(state.point_a, geometry_msgs::Point32());
  EXPECT_EQ(state.point_b, geometry_msgs::Point32());
  EXPECT_EQ(state.normal, geometry_msgs::Point32());
}

TEST(PassedStatesTest, ItIsDescribedByWhatTouched) {
  Feed feed;
  feed.run("--P");
  const ContactState& state = feed.of(kHandCloth);
  EXPECT_EQ(state.pair_count, 2U);
  EXPECT_EQ(state.min_separation, 0);
  EXPECT_NEAR(state.centroid.x, (5 * 6 + 1.0 + 3 * 0 + 1 + 2 + 2) / 12, 1e-6);
  EXPECT_EQ(state.mean_normal.z, 1);
  EXPECT_EQ(state.since.toSec(), 0);
  EXPECT_EQ(state.stamp, feed.stamp);
  EXPECT_EQ(state.reason, "");
  EXPECT_EQ(feed.of(kBaseCloth).state, ContactState::NONE);
}

TEST(PassedStatesTest, SinceCountsAnewBehindIt) {
  Feed feed;
  feed.run("---P--");
  EXPECT_NEAR(feed.of(kHandCloth).since.toSec(), 0.1, 1e-9);
  feed.run("PPP");
  EXPECT_NEAR(feed.of(kHandCloth).since.toSec(), 0.2, 1e-9);
}

// Nobody knows what happened in a time without a step, however short its UNKNOWN was.
TEST(PassedStatesTest, SinceCountsAnewWhereAStepIsMissing) {
  Feed feed(1, 2, 0, 1);
  feed.run("---L-");
  EXPECT_NEAR(feed.of(kHandCloth).since.toSec(), 0, 1e-9) << "the step begins after the gap";
  feed.run("-");
  feed.tracker.expire(feed.stamp + ros::Duration(0.6), "no new mesh");
  EXPECT_EQ(feed.run("L-"), "UNKNOWN NONE");
  EXPECT_NEAR(feed.of(kHandCloth).since.toSec(), 0, 1e-9);
  feed.run("-C");
  feed.tracker.expire(feed.stamp + ros::Duration(0.6), "no new mesh");
  feed.run("C");
  EXPECT_NEAR(feed.of(kHandCloth).since.toSec(), 0.1, 1e-9) << "a contact says nothing of before";
}

TEST(PassedStatesTest, SinceGoesOnWhereAStepCoversTheUnknown) {
  Feed feed(1, 2, 0, 1);
  feed.run("---");
  feed.tracker.expire(feed.stamp + ros::Duration(0.6), "no new mesh");
  feed.run("-");
  EXPECT_NEAR(feed.of(kHandCloth).since.toSec(), 0.3, 1e-9);
}

TEST(PassedStatesTest, AllowedStaysAllowed) {
  Feed feed;
  feed.change = [](SampleStep* sample) { sample->report.pairs[kHandCloth].allowed = true; };
  EXPECT_EQ(feed.run("-P"), "ALLOWED ALLOWED");
}

TEST(PassedStatesTest, EventsOfContactsBetweenTwoCyclesPassDebounce) {
  Feed feed(3, 3);
  feed.run("--P-");
  EXPECT_EQ(feed.events(), "PASSED 0.25 2");
  feed.run("PN");
  EXPECT_EQ(feed.events(), "PASSED 0.25 2 PASSED 0.25 2");
}

// The step after a contact begins with it.
TEST(PassedStatesTest, TheRestOfAContactIsNoEventOfItsOwn) {
  Feed feed(1, 2);
  EXPECT_EQ(feed.run("-CCP--"), "NONE CONTACT CONTACT PASSED NONE NONE");
  EXPECT_EQ(feed.events(), "BEGIN 0 1 END 0 0");
  Feed debounced(2, 2);
  debounced.run("-CP-");
  EXPECT_EQ(debounced.events(), "") << "too short to begin";
}

TEST(PassedStatesTest, OneThatIsAboutToEndGoesOn) {
  Feed feed(1, 2);
  feed.run("-C-P-P-");
  EXPECT_EQ(feed.events(), "BEGIN 0 1");
  feed.run("-");
  EXPECT_EQ(feed.events(), "END 0 0");
}

TEST(PassedStatesTest, WithoutAStepFromAKnownStateNoneIsNotKnown) {
  Feed feed;
  EXPECT_EQ(feed.run("L-"), "NONE NONE") << "nothing was promised before";
  EXPECT_EQ(feed.run("LLL"), "UNKNOWN UNKNOWN UNKNOWN") << "what passed meanwhile was not seen";
  EXPECT_EQ(feed.of(kHandCloth).reason, "cloth: no step from the previous cycle: reset");
  EXPECT_EQ(feed.run("-"), "NONE");
  feed.tracker.forget("", "reset", feed.stamp);
  EXPECT_EQ(feed.run("L-"), "NONE NONE");
}

TEST(PassedStatesTest, ACutOffStepIsNotNoContact) {
  Feed feed;
  EXPECT_EQ(feed.run("X-X"), "UNKNOWN NONE UNKNOWN");
  EXPECT_EQ(feed.of(kHandCloth).reason, std::string("in the step: ") + kNoTime);
  feed.change = [](SampleStep* sample) { sample->step.detection.cutOff(kNoTime); };
  EXPECT_EQ(feed.run("PC"), "PASSED CONTACT") << "what was found holds";
}

TEST(PassedStatesTest, ContactsThatWereLeftOutAreNotNoContact) {
  Feed feed;
  feed.change = [](SampleStep* sample) { sample->step.detection.left_out = 1; };
  EXPECT_EQ(feed.run("-PC"), "UNKNOWN PASSED CONTACT");
}

TEST(PassedStatesTest, AStepThatFailedIsNotNoContact) {
  Feed feed;
  feed.change = [](SampleStep* sample) {
    sample->sweep().result = nullptr;
    sample->sweep().problem = "no memory";
  };
  EXPECT_EQ(feed.run("-C"), "UNKNOWN CONTACT");
  EXPECT_EQ(feed.of(kBaseCloth).reason, "the step's detection failed: no memory");
}

TEST(PassedStatesTest, RejectedTrianglesAreNotNoContact) {
  const auto reject = [](SampleStep* sample) { sample->sweep().bodies[2].rejected = 1; };
  Feed feed;
  feed.change = reject;
  EXPECT_EQ(feed.run("-PC"), "UNKNOWN PASSED CONTACT");
  Feed tolerant(1, 2, 0.5);
  tolerant.change = reject;
  EXPECT_EQ(tolerant.run("-"), "NONE");
}

TEST(PassedStatesTest, VerticesTooFarOffToFollowAreNotNoContact) {
  Feed feed;
  feed.change = [](SampleStep* sample) { sample->step.outlying = {0}; };
  feed.run("-");
  EXPECT_EQ(feed.of(kHandCloth).state, ContactState::UNKNOWN);
  EXPECT_EQ(feed.of(kBaseCloth).state, ContactState::NONE);
}

TEST(PassedStatesTest, ABodyWithoutAStepCostsItsPairsAlone) {
  Feed feed;
  feed.run("-");
  feed.change = [](SampleStep* sample) { sample->sweep().bodies[0].skipped = "its TF is late"; };
  feed.run("-");
  EXPECT_EQ(feed.of(kHandCloth).state, ContactState::UNKNOWN);
  EXPECT_EQ(feed.of(kBaseCloth).state, ContactState::NONE);
}

// The pair's other body had a cycle meanwhile, which used an older state of this one.
TEST(PassedStatesTest, AStepThatEndsBeforeWhatIsKnownCounts) {
  Feed feed;
  feed.run("--");
  const ros::Time newest = feed.stamp;
  feed.stamp -= ros::Duration(0.15);
  EXPECT_EQ(feed.run("P"), "PASSED");
  EXPECT_EQ(feed.of(kHandCloth).stamp, newest);
  EXPECT_EQ(feed.events(), "PASSED 0.25 2");
  Feed other;
  other.run("--");
  other.stamp -= ros::Duration(0.15);
  EXPECT_EQ(other.run("X"), "UNKNOWN");
  Feed touching;
  touching.run("-C");
  touching.stamp -= ros::Duration(0.15);
  EXPECT_EQ(touching.run("P"), "CONTACT");
  touching.stamp -= ros::Duration(0.15);
  EXPECT_EQ(touching.run("-"), "CONTACT");
}

}  // namespace
}  // namespace deformable_contact_monitor
