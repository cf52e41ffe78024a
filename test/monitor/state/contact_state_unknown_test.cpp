// Tests of which pairs of bodies are UNKNOWN after a cycle: no contact that may be is NONE.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tracker_fixture.h"

namespace deformable_contact_monitor {
namespace {

TEST(ContactStateTrackerTest, unknownIsNeverNoContact) {
  SampleReport sample;
  sample.result.contacts.clear();
  sample.report.bodies[2].unknown_because = "stale";
  ContactStateTracker tracker(rules(1, 1));
  ContactStates message = take(&tracker, sample.report);
  EXPECT_EQ(message.states[kBaseHand].state, ContactState::ALLOWED);
  EXPECT_EQ(message.states[kHandCloth].state, ContactState::UNKNOWN);
  EXPECT_EQ(message.states[kBaseCloth].state, ContactState::UNKNOWN);
  EXPECT_TRUE(std::isnan(message.states[kBaseCloth].min_separation));

  SampleReport nothing_ran;
  nothing_ran.report.result = nullptr;
  nothing_ran.report.scene = nullptr;
  message = take(&tracker, nothing_ran.report);
  EXPECT_EQ(message.states[kHandCloth].state, ContactState::UNKNOWN);
  EXPECT_EQ(message.states[kBaseCloth].state, ContactState::UNKNOWN);
}

// Without a clock (ROS time 0), whatever was known is unknown, and an empty message is not
// complete.
TEST(ContactStateTrackerTest, withoutAClockEveryStateIsUnknown) {
  SampleReport sample;
  ContactStateTracker tracker(rules(1, 1));
  EXPECT_FALSE(tracker.states(ros::Time(), ros::Time()).complete);
  tracker.update(sample.report);
  const ContactStates message = tracker.states(ros::Time(), ros::Time());
  EXPECT_EQ(statesOf(message), "???");
  EXPECT_FALSE(message.complete);
  EXPECT_EQ(message.age, ros::Duration());
  for (const ContactState& state : message.states) {
    EXPECT_EQ(state.reason, "no clock: ROS time is zero");
    EXPECT_TRUE(std::isnan(state.min_separation));
    EXPECT_EQ(state.pair_count, 0U);
    EXPECT_TRUE(state.stamp.isZero());
  }
}

// A contact may be among those that did not fit: no pair without one in the list is known.
TEST(ContactStateTrackerTest, contactsThatWereLeftOutAreNotNoContact) {
  SampleReport sample;
  sample.result.left_out = 1;
  ContactStateTracker tracker(rules(1, 2));
  ContactStates message = take(&tracker, sample.report);
  EXPECT_EQ(message.states[kHandCloth].state, ContactState::CONTACT);
  EXPECT_EQ(message.states[kBaseCloth].state, ContactState::UNKNOWN);
  sample.result.separations_m = {.1F, .2F, .3F};
  message = take(&tracker, sample.report);
  EXPECT_EQ(message.states[kHandCloth].state, ContactState::UNKNOWN);
  EXPECT_TRUE(std::isnan(message.states[kHandCloth].min_separation));
  EXPECT_EQ(texts(tracker.takeEvents()).back(),
            "END arm/hand cloth 0 contacts were left out: memory_limit_mib");
}

// Pairs of triangles were not looked at: only what touches is known.
TEST(ContactStateTrackerTest, whatWasCutOffIsNotNoContact) {
  SampleReport sample;
  sample.result.cutOff("no time");
  sample.result.cutOff("memory_limit_mib");
  ContactStateTracker tracker(rules(1, 2));
  ContactStates message = take(&tracker, sample.report);
  EXPECT_EQ(message.states[kHandCloth].state, ContactState::CONTACT);
  EXPECT_EQ(message.states[kBaseCloth].state, ContactState::UNKNOWN);
  sample.result.separations_m = {.1F, .2F, .3F};
  message = take(&tracker, sample.report);
  EXPECT_EQ(message.states[kHandCloth].state, ContactState::UNKNOWN) << "near, but it may touch";
  EXPECT_EQ(texts(tracker.takeEvents()).back(), "END arm/hand cloth 0 no time");
}

TEST(ContactStateTrackerTest, whatWasNotLookedWithinIsNotNoContact) {
  SampleReport sample;
  Containment& containment = sample.addContainment();
  containment.cut_off_because = "no time";
  sample.report.pairs.push_back({2, 2, false});
  ContactStateTracker tracker(rules(1, 2));
  ContactStates message = take(&tracker, sample.report);
  EXPECT_EQ(message.states[kHandCloth].state, ContactState::CONTACT);
  EXPECT_EQ(message.states[kBaseCloth].state, ContactState::UNKNOWN);
  EXPECT_EQ(message.states[kBaseCloth].reason, "no time");
  EXPECT_EQ(message.states[3].state, ContactState::NONE) << "nothing is within itself";
  containment.parts = {{1, 2, 0, {}}};
  message = take(&tracker, sample.report);
  EXPECT_EQ(message.states[kBaseCloth].state, ContactState::CONTACT);
}

// The cycle took so long that its data are older than max_mesh_age_s when it ends.
TEST(ContactStateTrackerTest, whatIsTooOldWhenItComesIsNotNoContact) {
  SampleReport sample;
  sample.report.now = sample.report.header.stamp + ros::Duration(0.6);
  ContactStateTracker tracker(rules(1, 2));
  const ContactStates message = take(&tracker, sample.report);
  EXPECT_EQ(message.states[kHandCloth].state, ContactState::CONTACT) << "it was one";
  EXPECT_EQ(message.states[kBaseCloth].state, ContactState::UNKNOWN);
  EXPECT_NE(message.states[kBaseCloth].reason.find("max_mesh_age_s"), std::string::npos);
}

// No pair of a body with triangles that took no part is known, but for a contact that was found.
TEST(ContactStateTrackerTest, rejectedTrianglesAreNotNoContact) {
  SampleReport sample;
  sample.report.bodies[2].rejected = 1;  // of three
  ContactStateTracker strict(rules(1, 1));
  ContactStates states = take(&strict, sample.report);
  EXPECT_EQ(statesOf(states), "aC?");
  EXPECT_EQ(states.states[kBaseCloth].reason,
            "cloth: 1 of 3 triangles have a vertex that is not finite (tolerated_rejects)");
  ContactStateTracker lenient(rules(1, 1, 0.34)), less(rules(1, 1, 0.33));
  EXPECT_EQ(statesOf(take(&lenient, sample.report)), "aC-");
  EXPECT_EQ(statesOf(take(&less, sample.report)), "aC?");
}

// The service has answered: what a cycle finds that had begun before is not known any more.
TEST(ContactStateTrackerTest, whatWasDiscardedStaysUnknownUntilACycleThatBeginsLater) {
  SampleReport sample;
  ContactStateTracker tracker(rules(1, 1));
  EXPECT_EQ(statesOf(take(&tracker, sample.report)), "aC-");
  tracker.discard("disabled", sample.report.now, 2);
  EXPECT_EQ(statesOf(tracker.states(sample.report.now, sample.report.now)), "a??");
  EXPECT_EQ(texts(tracker.takeEvents()).back(), "END arm/hand cloth 0 disabled");
  sample.report.epoch = 1;
  const ContactStates message = take(&tracker, sample.report);
  EXPECT_EQ(statesOf(message), "a??");
  EXPECT_EQ(message.states[kHandCloth].reason, "disabled");
  sample.report.epoch = 2;
  EXPECT_EQ(statesOf(take(&tracker, sample.report)), "aC-");
}

// Its cycle may be at an older stamp than the known state: the other object of the pair had a cycle
// meanwhile, or the publisher's clock is ahead and the refused mesh has no stamp.
TEST(ContactStateTrackerTest, aMeshThatIsGoneIsNotNoContactWhateverItsStamp) {
  SampleReport sample;
  ContactStateTracker tracker(rules(1, 1));
  EXPECT_EQ(statesOf(take(&tracker, sample.report)), "aC-");
  SampleReport gone;
  gone.report.header.stamp -= ros::Duration(0.1);
  gone.report.bodies[2].unknown_because = "TF from 'camera' to 'base' is late";
  gone.report.result = nullptr;
  EXPECT_EQ(statesOf(take(&tracker, gone.report)), "aC-") << "of the later stamp, that is known";
  gone.report.bodies[2].unknown_because = "mesh refused: an index is out of range";
  gone.report.bodies[2].without_mesh = true;
  gone.report.bodies[2].triggered = false;
  EXPECT_EQ(statesOf(take(&tracker, gone.report)), "aC-") << "it is no cycle of the cloth";
  gone.report.bodies[2].triggered = true;
  const ContactStates message = take(&tracker, gone.report);
  EXPECT_EQ(statesOf(message), "a??");
  EXPECT_EQ(message.states[kBaseCloth].reason, "cloth: mesh refused: an index is out of range");
}

// Of two objects, one may have stopped while the other one has cycles.
TEST(ContactStateTrackerTest, whatIsFoundWithAnOldMeshOfThePartnerGrowsOldWithIt) {
  SampleReport sample;
  sample.report.bodies[0].kind = BodyKind::kDeformable;
  sample.report.bodies[0].stamp -= ros::Duration(0.4);
  ContactStateTracker tracker(rules(1, 1));
  EXPECT_EQ(statesOf(take(&tracker, sample.report)), "aC-");
  const ros::Time stamp = sample.report.header.stamp;
  EXPECT_FALSE(tracker.expire(stamp + ros::Duration(0.1), "old"));
  EXPECT_TRUE(tracker.expire(stamp + ros::Duration(0.2), "old"));
  EXPECT_EQ(statesOf(tracker.states(stamp, stamp)), "a?-") << "base and cloth are newer";
}

// Until the monitor has noticed that the clock went back, states would never become too old.
// As a list of pairs comes between cycles: it says why, and when that is over.
TEST(ContactStateTrackerTest, theReasonGoesWhenItsCauseHasGone) {
  SampleReport sample;
  for (BodyStatus& body : sample.report.bodies) body.triggered = false;
  ContactStateTracker tracker(rules(1, 1));
  const auto reasonWith = [&](const std::string& problem) {
    sample.report.bodies[2].unknown_because = problem;
    return take(&tracker, sample.report).states[kHandCloth].reason;
  };
  EXPECT_EQ(reasonWith(""), "not looked at yet");
  EXPECT_EQ(reasonWith("no mesh yet"), "cloth: no mesh yet");
  EXPECT_EQ(reasonWith("mesh refused"), "cloth: mesh refused");
  sample.report.bodies[0].triggered = true;
  EXPECT_EQ(reasonWith(""), "cloth: mesh refused") << "a cycle of others does not look at it";
  sample.report.bodies[0].triggered = false;
  EXPECT_EQ(reasonWith(""), "not looked at yet");
  take(&tracker, SampleReport().report);
  tracker.forget("", "reset", sample.report.now);
  EXPECT_EQ(reasonWith(""), "reset") << "that is no body's";
}

TEST(ContactStateTrackerTest, whatIsFarAheadOfTheClockIsNotKnown) {
  SampleReport sample;
  ContactStateTracker tracker(rules(1, 1));
  take(&tracker, sample.report);
  const ros::Time stamp = sample.report.header.stamp;
  EXPECT_FALSE(tracker.expire(stamp - ros::Duration(1), "old"));
  EXPECT_TRUE(tracker.expire(stamp - ros::Duration(1.1), "old"));
  const ContactStates message = tracker.states(stamp, stamp);
  EXPECT_EQ(statesOf(message), "a??");
  EXPECT_EQ(message.states[kHandCloth].reason, "time jump: the clock went back");
}

}  // namespace
}  // namespace deformable_contact_monitor
