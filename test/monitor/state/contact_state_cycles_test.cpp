// Tests of states of pairs of bodies from cycle to cycle: events, their debouncing, each pair's own
// cycles.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "tracker_fixture.h"

namespace deformable_contact_monitor {
namespace {

// Feeds cycles to a tracker, 0.1 s apart; 'C' contact, '-' none, '?' unknown, 'n' near.
struct Feed {
  Feed(int on, int off) : tracker(rules(on, off)) {}

  std::vector<std::string> run(const std::string& cycles) {
    const auto contacts = sample.result.contacts;
    for (const char c : cycles) {
      sample.report.header.stamp += ros::Duration(0.1);
      sample.report.now = sample.report.header.stamp;
      sample.result.contacts = c == '-' ? TrianglePairs() : contacts;
      sample.result.separations_m =
          c == 'n' ? std::vector<float>{.1F, .2F, .3F} : std::vector<float>();
      sample.report.bodies[0].unknown_because = c == '?' ? "no transform" : "";
      tracker.update(sample.report);
    }
    sample.result.contacts = contacts;
    return texts(tracker.takeEvents());
  }

  SampleReport sample;
  ContactStateTracker tracker;
};

TEST(ContactStateTrackerTest, sinceCountsStampsInTheSameState) {
  SampleReport sample;
  ContactStateTracker tracker(rules(1, 1));
  const ros::Time start = sample.report.header.stamp;
  const auto since = [&](double after_s) {
    sample.report.header.stamp = start + ros::Duration(after_s);
    return take(&tracker, sample.report).states[kHandCloth].since.toSec();
  };
  EXPECT_EQ(since(0), 0);
  EXPECT_NEAR(since(0.5), 0.5, 1e-9);
  sample.result.contacts.clear();
  EXPECT_EQ(since(0.75), 0);
  EXPECT_NEAR(since(1.5), 0.75, 1e-9);
  EXPECT_NEAR(since(-1), 0.75, 1e-9) << "an older cycle leaves the state alone";
}

TEST(ContactStateTrackerTest, eventsAreDebounced) {
  Feed prompt(1, 1);
  EXPECT_EQ(prompt.run("-C-C"),
            (std::vector<std::string>{"BEGIN arm/hand cloth 3", "END arm/hand cloth 0",
                                      "BEGIN arm/hand cloth 3"}));
  Feed slow(2, 3);
  EXPECT_EQ(slow.run("C-C-"), std::vector<std::string>());
  EXPECT_EQ(slow.run("CC"), std::vector<std::string>{"BEGIN arm/hand cloth 3"});
  EXPECT_EQ(slow.run("--C--C"), std::vector<std::string>());
  EXPECT_EQ(slow.run("-n-"), std::vector<std::string>{"END arm/hand cloth 0"});
}

TEST(ContactStateTrackerTest, anInterruptionEndsAContactAtOnceAndSaysWhy) {
  Feed feed(2, 3);
  EXPECT_EQ(feed.run("CC?"),
            (std::vector<std::string>{"BEGIN arm/hand cloth 3",
                                      "END arm/hand cloth 0 arm/hand: no transform"}));
  EXPECT_EQ(feed.run("C?C"), std::vector<std::string>());
  EXPECT_EQ(feed.run("C"), std::vector<std::string>{"BEGIN arm/hand cloth 3"});
}

TEST(ContactStateTrackerTest, resetEndsEveryOpenContact) {
  Feed feed(1, 5);
  feed.run("C");
  feed.tracker.forget("", "time jump", ros::Time(102));
  EXPECT_EQ(texts(feed.tracker.takeEvents()),
            std::vector<std::string>{"END arm/hand cloth 0 time jump"});
  feed.tracker.forget("", "again", ros::Time(102));
  EXPECT_TRUE(feed.tracker.takeEvents().empty());
  EXPECT_EQ(feed.run("C"), std::vector<std::string>{"BEGIN arm/hand cloth 3"});
}

TEST(ContactStateTrackerTest, aPairThatIsGoneEndsItsContact) {
  SampleReport sample;
  ContactStateTracker tracker(rules(1, 5));
  tracker.update(sample.report);
  tracker.takeEvents();
  sample.report.pairs.erase(sample.report.pairs.begin() + kHandCloth);
  tracker.update(sample.report);
  EXPECT_EQ(texts(tracker.takeEvents()),
            std::vector<std::string>{"END arm/hand cloth 0 no longer monitored"});
}

// Two objects of which each has its cycles: pairs 0 (hand, cloth), 1 (hand, cable), 2 (cloth,
// cable).
struct TwoObjects {
  TwoObjects() {
    for (const char* name : {"hand", "cloth", "cable"}) scene.addBody(name, threeTriangles());
    report.bodies = {{"hand", BodyKind::kLink, ros::Time(), 0, ""},
                     {"cloth", BodyKind::kDeformable, ros::Time(), 9, ""},
                     {"cable", BodyKind::kDeformable, ros::Time(), 9, ""}};
    report.pairs = {{0, 1, false}, {0, 2, false}, {1, 2, false}};
    report.header.frame_id = "base";
    report.scene = &scene;
    report.result = owned_result;
  }

  // The cycle of an object at a stamp, a tenth of a second later.
  const CycleReport& cycle(BodyId object, double stamp_s) {
    report.header.stamp = ros::Time(stamp_s);
    report.now = ros::Time(stamp_s + 0.1);
    ++report.cycle;
    for (BodyId id = 0; id < 3; ++id) report.bodies[id].triggered = id == object;
    return report;
  }

  Scene scene;
  const std::shared_ptr<DetectionResult> owned_result = std::make_shared<DetectionResult>();
  DetectionResult& result = *owned_result;
  CycleReport report;
};

constexpr BodyId kCloth = 1, kCable = 2;

std::vector<double> stampsOf(const ContactStates& states) {
  std::vector<double> stamps_s;
  for (const ContactState& state : states.states) stamps_s.push_back(state.stamp.toSec());
  return stamps_s;
}

TEST(ContactStateTrackerTest, everyPairHasTheStampOfItsOwnCycle) {
  TwoObjects two;
  ContactStateTracker tracker(rules(1, 1));
  ContactStates states = take(&tracker, two.cycle(kCloth, 50));
  EXPECT_EQ(statesOf(states), "-?-");
  EXPECT_EQ(states.states[1].reason, "not looked at yet");
  EXPECT_FALSE(states.complete);
  two.result.contacts = {{0, 0, 2, 0}};
  states = take(&tracker, two.cycle(kCable, 50.25));
  EXPECT_EQ(statesOf(states), "-C-");
  EXPECT_EQ(stampsOf(states), (std::vector<double>{50, 50.25, 50.25}));
  EXPECT_TRUE(states.complete);
  EXPECT_EQ(states.cycle, two.report.cycle);
  EXPECT_NEAR(states.age.toSec(), 0.35, 1e-9) << "of the oldest";
  for (const ContactState& state : states.states) EXPECT_EQ(state.reason, "");
}

// An object whose clock is five seconds behind is looked at in turn with the other.
TEST(ContactStateTrackerTest, clocksOfObjectsMayDiffer) {
  TwoObjects two;
  StateRules patient = rules(1, 1);
  patient.max_age_s = 10;
  ContactStateTracker tracker(patient);
  take(&tracker, two.cycle(kCloth, 50));
  ContactStates states = take(&tracker, two.cycle(kCable, 45));
  EXPECT_EQ(statesOf(states), "---");
  EXPECT_EQ(stampsOf(states), (std::vector<double>{50, 45, 50})) << "what is newer stays";
  two.result.contacts = {{0, 0, 2, 0}, {1, 0, 2, 0}};
  states = take(&tracker, two.cycle(kCable, 45.25));
  EXPECT_EQ(statesOf(states), "-C-");
  EXPECT_EQ(states.states[1].since.toSec(), 0);
  two.result.contacts.clear();
  states = take(&tracker, two.cycle(kCloth, 50.25));
  EXPECT_EQ(statesOf(states), "-C-") << "it was not looked at";
  EXPECT_EQ(texts(tracker.takeEvents()), std::vector<std::string>{"BEGIN hand cable 1"});
}

TEST(ContactStateTrackerTest, debounceAndSinceAdvanceInThePairsOwnCyclesAlone) {
  TwoObjects two;
  ContactStateTracker tracker(rules(2, 2));
  two.result.contacts = {{0, 0, 1, 0}};
  take(&tracker, two.cycle(kCloth, 50));
  for (int i = 1; i < 5; ++i) take(&tracker, two.cycle(kCable, 50 + 0.01 * i));
  EXPECT_TRUE(tracker.takeEvents().empty());
  const ContactStates states = take(&tracker, two.cycle(kCloth, 50.25));
  EXPECT_EQ(texts(tracker.takeEvents()), std::vector<std::string>{"BEGIN hand cloth 1"});
  EXPECT_NEAR(states.states[0].since.toSec(), 0.25, 1e-9);
}

TEST(ContactStateTrackerTest, whatIsTooOldIsUnknown) {
  TwoObjects two;
  ContactStateTracker tracker(rules(1, 1));
  two.result.contacts = {{0, 0, 1, 0}};
  take(&tracker, two.cycle(kCloth, 50));
  take(&tracker, two.cycle(kCable, 50.25));
  EXPECT_FALSE(tracker.expire(ros::Time(50.5), "no new mesh")) << "max_age_s is closed";
  EXPECT_TRUE(tracker.expire(ros::Time(50.6), "no new mesh"));
  EXPECT_FALSE(tracker.expire(ros::Time(50.6), "no new mesh"));
  const ros::Time now(50.7);
  const ContactStates states = tracker.states(now, now);
  EXPECT_EQ(statesOf(states), "?--");
  EXPECT_EQ(states.states[0].reason, "no new mesh");
  EXPECT_TRUE(std::isnan(states.states[0].min_separation));
  EXPECT_EQ(states.states[0].stamp, now);
  EXPECT_NEAR(states.states[0].since.toSec(), 0.1, 1e-9);
  EXPECT_NEAR(states.age.toSec(), 0.45, 1e-9) << "of what is known";
  EXPECT_EQ(texts(tracker.takeEvents()),
            (std::vector<std::string>{"BEGIN hand cloth 1", "END hand cloth 0 no new mesh"}));
}

TEST(ContactStateTrackerTest, aPartnerWithoutAMeshForTheCycleCostsNothingThatIsKnown) {
  TwoObjects two;
  ContactStateTracker tracker(rules(1, 1));
  take(&tracker, two.cycle(kCable, 50.25));
  two.report.bodies[kCable].unknown_because = "no mesh as old as this cycle";
  ContactStates states = take(&tracker, two.cycle(kCloth, 50));
  EXPECT_EQ(statesOf(states), "---");
  EXPECT_EQ(states.states[2].stamp, ros::Time(50.25));
  two.report.bodies[0].unknown_because = "no transform";
  states = take(&tracker, two.cycle(kCloth, 50.3));
  EXPECT_EQ(statesOf(states), "?--") << "a link without a transform is another thing";
  EXPECT_EQ(states.states[0].reason, "hand: no transform");
}

TEST(ContactStateTrackerTest, reasonsOfUnknownPairsAreTheNewestOnes) {
  TwoObjects two;
  ContactStateTracker tracker(rules(1, 1));
  const auto reason = [&] { return take(&tracker, two.cycle(0, 50)).states[1].reason; };
  EXPECT_EQ(reason(), "not looked at yet");
  two.report.bodies[kCable].unknown_because = "no mesh yet";
  EXPECT_EQ(reason(), "cable: no mesh yet");
}

TEST(ContactStateTrackerTest, oneBodyIsForgotten) {
  TwoObjects two;
  ContactStateTracker tracker(rules(1, 1));
  take(&tracker, two.cycle(kCloth, 50));
  take(&tracker, two.cycle(kCable, 50));
  tracker.forget("cable", "the stamps of its meshes went back", ros::Time(50));
  EXPECT_EQ(statesOf(tracker.states(ros::Time(50), ros::Time(50))), "-??");
  EXPECT_EQ(statesOf(take(&tracker, two.cycle(kCable, 49))), "---") << "an older stamp is new";
}

TEST(ContactStateTrackerTest, refusesToDebounceByNoCycle) {
  EXPECT_THROW(ContactStateTracker(rules(0, 1)), std::invalid_argument);
  EXPECT_THROW(ContactStateTracker(rules(1, 0)), std::invalid_argument);
}

}  // namespace
}  // namespace deformable_contact_monitor
