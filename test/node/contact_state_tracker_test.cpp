// Tests of the states of pairs of bodies and of their events.
#include "node/contact_state_tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/posed_body.h"
#include "node/triangle_normal.h"
#include "sample_report.h"

namespace deformable_contact_monitor {
namespace {

StateRules rules(int on, int off, double tolerated_rejects = 0) {
  return {on, off, 0.5, tolerated_rejects};
}

// All states after the report.
ContactStates take(ContactStateTracker* tracker, const CycleReport& report) {
  tracker->update(report);
  return tracker->states(report.header.stamp, report.now);
}

constexpr std::size_t kBaseHand = 0, kHandCloth = 1, kBaseCloth = 2;

// "BEGIN arm/hand cloth 3" or "END arm/hand cloth 0 reset".
std::vector<std::string> texts(const std::vector<ContactEvent>& events) {
  std::vector<std::string> lines;
  for (const ContactEvent& e : events) {
    lines.push_back(std::string(e.type == ContactEvent::BEGIN ? "BEGIN " : "END ") + e.body_a +
                    " " + e.body_b + " " + std::to_string(e.pair_count) +
                    (e.reason.empty() ? "" : " " + e.reason));
  }
  return lines;
}

// Feeds cycles to a tracker, 0.1 s apart; 'C' contact, '-' none, '?' unknown, 'n' near.
struct Feed {
  Feed(int on, int off) : tracker(rules(on, off)) {}

  std::vector<std::string> run(const std::string& cycles) {
    const auto contacts = sample.result.contacts;
    for (const char c : cycles) {
      sample.report.header.stamp += ros::Duration(0.1);
      sample.report.now = sample.report.header.stamp;
      sample.result.contacts = c == '-' ? std::vector<TrianglePair>() : contacts;
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

TEST(ContactStateTrackerTest, describesEachMonitoredPair) {
  const SampleReport sample;
  ContactStateTracker tracker(rules(1, 2));
  const ContactStates message = take(&tracker, sample.report);
  EXPECT_EQ(message.header.stamp, sample.report.header.stamp);
  EXPECT_EQ(message.header.frame_id, "base_link");
  ASSERT_EQ(message.states.size(), 3U);

  const ContactState& allowed = message.states[kBaseHand];
  EXPECT_EQ(allowed.state, ContactState::ALLOWED);
  EXPECT_TRUE(std::isnan(allowed.min_separation));

  const ContactState& touching = message.states[kHandCloth];
  EXPECT_EQ(touching.body_a, "arm/hand");
  EXPECT_EQ(touching.body_b, "cloth");
  EXPECT_EQ(touching.state, ContactState::CONTACT);
  EXPECT_EQ(touching.pair_count, 3U);
  EXPECT_EQ(touching.min_separation, 0);
  // Triangle centroids: hand 0 (16/3, 1/3), 1 (17/3, 2/3); cloth 0 (1/3, 1/3), 1 (2/3, 2/3).
  EXPECT_NEAR(touching.centroid.x, (16 / 3. + 1 / 3. + 16 / 3. + 2 / 3. + 17 / 3. + 2 / 3.) / 6,
              1e-6);
  EXPECT_NEAR(touching.centroid.y, (1 / 3. + 1 / 3. + 1 / 3. + 2 / 3. + 2 / 3. + 2 / 3.) / 6, 1e-6);
  EXPECT_EQ(touching.centroid.z, 0);
  EXPECT_EQ(touching.mean_normal.x, 0);
  EXPECT_EQ(touching.mean_normal.y, 0);
  EXPECT_EQ(touching.mean_normal.z, 1);

  const ContactState& apart = message.states[kBaseCloth];
  EXPECT_EQ(apart.state, ContactState::NONE);
  EXPECT_EQ(apart.pair_count, 0U);
  EXPECT_EQ(apart.min_separation, std::numeric_limits<float>::infinity());
  EXPECT_EQ(apart.mean_normal.z, 0);
}

TEST(ContactStateTrackerTest, aNormalIsWeightedByAreaOncePerTriangle) {
  // Triangle 0: area 1/2 towards +z, in two pairs; triangle 1: area 1 towards +x.
  SampleReport sample;
  sample.scene.setMesh(0, {{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1}, {0, 1, 2, 0, 3, 4}});
  ContactStateTracker tracker(rules(1, 1));
  const ContactState state = take(&tracker, sample.report).states[kHandCloth];
  EXPECT_NEAR(state.mean_normal.x, 2 / std::sqrt(5.), 1e-6);
  EXPECT_NEAR(state.mean_normal.z, 1 / std::sqrt(5.), 1e-6);
}

TriangleMesh randomTriangles(std::uint32_t count) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(0, 1);
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < 3 * count; ++i) {
    mesh.triangles.push_back(i);
    for (int axis = 0; axis < 3; ++axis) mesh.vertices.push_back(unit(random));
  }
  return mesh;
}

// So many that they are summed up on threads; one triangle has more than a thread's share.
TEST(ContactStateTrackerTest, sumsUpAnyNumberOfPairs) {
  constexpr std::uint32_t kTriangles = 3000, kInContact = 30000;
  SampleReport sample;
  const TriangleMesh mesh = randomTriangles(kTriangles);
  sample.scene.setMesh(0, mesh);
  sample.scene.setMesh(2, mesh);
  sample.result.contacts.clear();
  for (std::uint32_t t = 0; t < kTriangles; ++t) {
    for (std::uint32_t k = 0; k < (t == 777 ? kInContact : t % 9); ++k) {
      sample.result.contacts.push_back({0, t, 2, k % kTriangles});
    }
  }
  Vec3d corners, normals;
  for (std::size_t i = 0; i < sample.result.contacts.size(); ++i) {
    const TrianglePair& pair = sample.result.contacts[i];
    const auto a = PosedBody(sample.scene.body(0)).triangle(pair.triangle_a);
    const auto b = PosedBody(sample.scene.body(2)).triangle(pair.triangle_b);
    for (const Vec3f& corner : a.v) corners = corners + toDouble(corner);
    for (const Vec3f& corner : b.v) corners = corners + toDouble(corner);
    const bool first = i == 0 || pair.triangle_a != sample.result.contacts[i - 1].triangle_a;
    if (first) normals = normals + doubleAreaNormal(a);
  }
  ContactStateTracker tracker(rules(1, 1));
  const ContactState state = take(&tracker, sample.report).states[kHandCloth];
  ASSERT_EQ(state.pair_count, sample.result.contacts.size());
  const double share = 1 / (6.0 * state.pair_count);
  EXPECT_NEAR(state.centroid.x, corners.x * share, 1e-5);
  EXPECT_NEAR(state.centroid.z, corners.z * share, 1e-5);
  EXPECT_NEAR(state.mean_normal.x, normals.x / std::sqrt(dot(normals, normals)), 1e-5);
  EXPECT_NEAR(state.mean_normal.z, normals.z / std::sqrt(dot(normals, normals)), 1e-5);
}

// Each triangle is there once more, turned round: what is left of the normals is rounding.
TEST(ContactStateTrackerTest, normalsThatCancelOutAmongManyAreZero) {
  constexpr std::uint32_t kTriangles = 20000;
  SampleReport sample;
  TriangleMesh mesh = randomTriangles(kTriangles);
  for (std::uint32_t i = 3 * kTriangles; i > 0; --i) mesh.triangles.push_back(i - 1);
  sample.scene.setMesh(0, mesh);
  sample.result.contacts.clear();
  for (std::uint32_t t = 0; t < 2 * kTriangles; ++t) {
    sample.result.contacts.push_back({0, t, 2, 0});
  }
  ContactStateTracker tracker(rules(1, 1));
  const ContactState state = take(&tracker, sample.report).states[kHandCloth];
  EXPECT_EQ(state.pair_count, 2 * kTriangles);
  EXPECT_EQ(state.mean_normal.x, 0);
  EXPECT_EQ(state.mean_normal.y, 0);
  EXPECT_EQ(state.mean_normal.z, 0);
}

TEST(ContactStateTrackerTest, aNormalIsZeroWhereItIsUndefined) {
  SampleReport opposed;  // two triangles back to back
  opposed.scene.setMesh(0, {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2, 0, 2, 1}});
  SampleReport soft;  // no link
  soft.report.bodies[0].kind = BodyKind::kDeformable;
  for (SampleReport* sample : {&opposed, &soft}) {
    ContactStateTracker tracker(rules(1, 1));
    const ContactState state = take(&tracker, sample->report).states[kHandCloth];
    EXPECT_EQ(state.state, ContactState::CONTACT);
    EXPECT_EQ(state.mean_normal.x, 0);
    EXPECT_EQ(state.mean_normal.y, 0);
    EXPECT_EQ(state.mean_normal.z, 0);
  }
}

TEST(ContactStateTrackerTest, nearMeansThatEveryTrianglePairIsApart) {
  SampleReport sample;
  ContactStateTracker tracker(rules(1, 1));
  sample.result.separations_m = {0.02F, 0.01F, 0.03F};
  ContactState state = take(&tracker, sample.report).states[kHandCloth];
  EXPECT_EQ(state.state, ContactState::NEAR);
  EXPECT_EQ(state.min_separation, 0.01F);
  sample.result.separations_m[2] = 0;
  state = take(&tracker, sample.report).states[kHandCloth];
  EXPECT_EQ(state.state, ContactState::CONTACT);
  EXPECT_EQ(state.min_separation, 0);
}

// Whether they touch, the verdict says: what geometry finds apart after all is at 0.
TEST(ContactStateTrackerTest, withGeometryTheSeparationIsMinusTheDepth) {
  SampleReport sample;
  ContactStateTracker tracker(rules(1, 1));
  sample.result.geometry.resize(3);
  sample.result.geometry[0].separation_m = 0.25F;
  sample.result.geometry[1].separation_m = -0.5F;
  EXPECT_EQ(take(&tracker, sample.report).states[kHandCloth].min_separation, 0);
  sample.report.options.geometry = true;
  ContactState state = take(&tracker, sample.report).states[kHandCloth];
  EXPECT_EQ(state.state, ContactState::CONTACT);
  EXPECT_EQ(state.min_separation, -0.5F);
  sample.result.geometry[1].separation_m = 0.125F;
  state = take(&tracker, sample.report).states[kHandCloth];
  EXPECT_EQ(state.state, ContactState::CONTACT);
  EXPECT_EQ(state.min_separation, 0);
  sample.result.separations_m = {0.02F, 0.01F, 0.03F};
  for (int i = 0; i < 3; ++i) {
    sample.result.geometry[i].separation_m = sample.result.separations_m[i];
  }
  state = take(&tracker, sample.report).states[kHandCloth];
  EXPECT_EQ(state.state, ContactState::NEAR);
  EXPECT_EQ(state.min_separation, 0.01F);
}

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

// As what touches: whatever else is missing.
TEST(ContactStateTrackerTest, whatIsInsideIsAContactThatSaysSo) {
  SampleReport sample;
  Containment containment;
  containment.parts = {{1, 2, 0, {1, 2, 3}}, {1, 2, 5, {3, 2, 3}}, {2, 0, 0, {9, 9, 9}}};
  sample.report.containment = &containment;
  ContactStateTracker tracker(rules(1, 2));
  ContactStates message = take(&tracker, sample.report);
  ContactState base = message.states[kBaseCloth], hand = message.states[kHandCloth];
  EXPECT_EQ(base.state, ContactState::CONTACT);
  EXPECT_EQ(base.inside, 1);
  EXPECT_EQ(base.pair_count, 0U);
  EXPECT_EQ(base.min_separation, 0);
  EXPECT_EQ(base.centroid.x, 2);
  EXPECT_EQ(base.centroid.z, 3);
  EXPECT_EQ(hand.state, ContactState::CONTACT);
  EXPECT_EQ(hand.inside, 2);
  EXPECT_EQ(hand.pair_count, 3U);
  EXPECT_LT(hand.centroid.x, 9) << "where it touches";
  EXPECT_EQ(texts(tracker.takeEvents()),
            (std::vector<std::string>{"BEGIN arm/hand cloth 3", "BEGIN base cloth 0"}));

  sample.result.separations_m = {.1F, .2F, .3F};
  sample.report.bodies[2].rejected = 1;
  hand = take(&tracker, sample.report).states[kHandCloth];
  EXPECT_EQ(hand.state, ContactState::CONTACT) << "near, and inside";
  EXPECT_EQ(hand.min_separation, 0);
  EXPECT_EQ(hand.centroid.x, 9);

  containment.parts = {{1, 2, 0, {}}, {2, 1, 0, {}}};
  base = take(&tracker, sample.report).states[kBaseCloth];
  EXPECT_EQ(base.inside, 1) << "each within the other";
}

TEST(ContactStateTrackerTest, whatWasNotLookedWithinIsNotNoContact) {
  SampleReport sample;
  Containment containment;
  containment.cut_off_because = "no time";
  sample.report.containment = &containment;
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

// As of a cycle that took long.
TEST(ContactStateTrackerTest, whatIsTooOldWhenItComesIsNotNoContact) {
  SampleReport sample;
  sample.report.now = sample.report.header.stamp + ros::Duration(0.6);
  ContactStateTracker tracker(rules(1, 2));
  const ContactStates message = take(&tracker, sample.report);
  EXPECT_EQ(message.states[kHandCloth].state, ContactState::CONTACT) << "it was one";
  EXPECT_EQ(message.states[kBaseCloth].state, ContactState::UNKNOWN);
  EXPECT_NE(message.states[kBaseCloth].reason.find("max_mesh_age_s"), std::string::npos);
}

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
    report.result = &result;
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
  DetectionResult result;
  CycleReport report;
};

constexpr BodyId kCloth = 1, kCable = 2;

std::vector<double> stampsOf(const ContactStates& states) {
  std::vector<double> stamps_s;
  for (const ContactState& state : states.states) stamps_s.push_back(state.stamp.toSec());
  return stamps_s;
}

std::string statesOf(const ContactStates& states) {
  const std::string letters = "-nCa?";
  std::string text;
  for (const ContactState& state : states.states) text += letters.at(state.state);
  return text;
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

TEST(ContactStateTrackerTest, refusesToDebounceByNoCycle) {
  EXPECT_THROW(ContactStateTracker(rules(0, 1)), std::invalid_argument);
  EXPECT_THROW(ContactStateTracker(rules(1, 0)), std::invalid_argument);
}

}  // namespace
}  // namespace deformable_contact_monitor
