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
std::vector<std::string> run(ContactStateTracker* tracker, const std::string& cycles) {
  SampleReport sample;
  const auto contacts = sample.result.contacts;
  for (const char c : cycles) {
    sample.report.header.stamp += ros::Duration(0.1);
    sample.result.contacts = c == '-' ? std::vector<TrianglePair>() : contacts;
    sample.result.separations_m =
        c == 'n' ? std::vector<float>{.1F, .2F, .3F} : std::vector<float>();
    sample.report.bodies[0].unknown_because = c == '?' ? "no transform" : "";
    tracker->update(sample.report);
  }
  return texts(tracker->takeEvents());
}

TEST(ContactStateTrackerTest, describesEachMonitoredPair) {
  const SampleReport sample;
  ContactStateTracker tracker(1, 2);
  const ContactStates message = tracker.update(sample.report);
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
  ContactStateTracker tracker(1, 1);
  const ContactState state = tracker.update(sample.report).states[kHandCloth];
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
  ContactStateTracker tracker(1, 1);
  const ContactState state = tracker.update(sample.report).states[kHandCloth];
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
  ContactStateTracker tracker(1, 1);
  const ContactState state = tracker.update(sample.report).states[kHandCloth];
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
    ContactStateTracker tracker(1, 1);
    const ContactState state = tracker.update(sample->report).states[kHandCloth];
    EXPECT_EQ(state.state, ContactState::CONTACT);
    EXPECT_EQ(state.mean_normal.x, 0);
    EXPECT_EQ(state.mean_normal.y, 0);
    EXPECT_EQ(state.mean_normal.z, 0);
  }
}

TEST(ContactStateTrackerTest, nearMeansThatEveryTrianglePairIsApart) {
  SampleReport sample;
  ContactStateTracker tracker(1, 1);
  sample.result.separations_m = {0.02F, 0.01F, 0.03F};
  ContactState state = tracker.update(sample.report).states[kHandCloth];
  EXPECT_EQ(state.state, ContactState::NEAR);
  EXPECT_EQ(state.min_separation, 0.01F);
  sample.result.separations_m[2] = 0;
  state = tracker.update(sample.report).states[kHandCloth];
  EXPECT_EQ(state.state, ContactState::CONTACT);
  EXPECT_EQ(state.min_separation, 0);
}

TEST(ContactStateTrackerTest, unknownIsNeverNoContact) {
  SampleReport sample;
  sample.result.contacts.clear();
  sample.report.bodies[2].unknown_because = "stale";
  ContactStateTracker tracker(1, 1);
  ContactStates message = tracker.update(sample.report);
  EXPECT_EQ(message.states[kBaseHand].state, ContactState::ALLOWED);
  EXPECT_EQ(message.states[kHandCloth].state, ContactState::UNKNOWN);
  EXPECT_EQ(message.states[kBaseCloth].state, ContactState::UNKNOWN);
  EXPECT_TRUE(std::isnan(message.states[kBaseCloth].min_separation));

  SampleReport nothing_ran;
  nothing_ran.report.result = nullptr;
  nothing_ran.report.scene = nullptr;
  message = tracker.update(nothing_ran.report);
  EXPECT_EQ(message.states[kHandCloth].state, ContactState::UNKNOWN);
  EXPECT_EQ(message.states[kBaseCloth].state, ContactState::UNKNOWN);
}

// A contact may be among those that did not fit: no pair without one in the list is known.
TEST(ContactStateTrackerTest, contactsThatWereLeftOutAreNotNoContact) {
  SampleReport sample;
  sample.result.left_out = 1;
  ContactStateTracker tracker(1, 2);
  ContactStates message = tracker.update(sample.report);
  EXPECT_EQ(message.states[kHandCloth].state, ContactState::CONTACT);
  EXPECT_EQ(message.states[kBaseCloth].state, ContactState::UNKNOWN);
  sample.result.separations_m = {.1F, .2F, .3F};
  message = tracker.update(sample.report);
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
  ContactStateTracker tracker(1, 2);
  ContactStates message = tracker.update(sample.report);
  EXPECT_EQ(message.states[kHandCloth].state, ContactState::CONTACT);
  EXPECT_EQ(message.states[kBaseCloth].state, ContactState::UNKNOWN);
  sample.result.separations_m = {.1F, .2F, .3F};
  message = tracker.update(sample.report);
  EXPECT_EQ(message.states[kHandCloth].state, ContactState::UNKNOWN) << "near, but it may touch";
  EXPECT_EQ(texts(tracker.takeEvents()).back(), "END arm/hand cloth 0 no time");
}

TEST(ContactStateTrackerTest, sinceCountsStampsInTheSameState) {
  SampleReport sample;
  ContactStateTracker tracker(1, 1);
  const ros::Time start = sample.report.header.stamp;
  const auto since = [&](double after_s) {
    sample.report.header.stamp = start + ros::Duration(after_s);
    return tracker.update(sample.report).states[kHandCloth].since.toSec();
  };
  EXPECT_EQ(since(0), 0);
  EXPECT_NEAR(since(0.5), 0.5, 1e-9);
  sample.result.contacts.clear();
  EXPECT_EQ(since(0.75), 0);
  EXPECT_NEAR(since(1.5), 0.75, 1e-9);
  EXPECT_EQ(since(-1), 0);
}

TEST(ContactStateTrackerTest, eventsAreDebounced) {
  ContactStateTracker prompt(1, 1);
  EXPECT_EQ(run(&prompt, "-C-C"),
            (std::vector<std::string>{"BEGIN arm/hand cloth 3", "END arm/hand cloth 0",
                                      "BEGIN arm/hand cloth 3"}));
  ContactStateTracker slow(2, 3);
  EXPECT_EQ(run(&slow, "C-C-"), std::vector<std::string>());
  EXPECT_EQ(run(&slow, "CC"), std::vector<std::string>{"BEGIN arm/hand cloth 3"});
  EXPECT_EQ(run(&slow, "--C--C"), std::vector<std::string>());
  EXPECT_EQ(run(&slow, "-n-"), std::vector<std::string>{"END arm/hand cloth 0"});
}

TEST(ContactStateTrackerTest, anInterruptionEndsAContactAtOnceAndSaysWhy) {
  ContactStateTracker tracker(2, 3);
  EXPECT_EQ(run(&tracker, "CC?"),
            (std::vector<std::string>{"BEGIN arm/hand cloth 3",
                                      "END arm/hand cloth 0 arm/hand: no transform"}));
  EXPECT_EQ(run(&tracker, "C?C"), std::vector<std::string>());
  EXPECT_EQ(run(&tracker, "C"), std::vector<std::string>{"BEGIN arm/hand cloth 3"});
}

TEST(ContactStateTrackerTest, resetEndsEveryOpenContact) {
  ContactStateTracker tracker(1, 5);
  run(&tracker, "C");
  tracker.reset("time jump");
  EXPECT_EQ(texts(tracker.takeEvents()),
            std::vector<std::string>{"END arm/hand cloth 0 time jump"});
  tracker.reset("again");
  EXPECT_TRUE(tracker.takeEvents().empty());
  EXPECT_EQ(run(&tracker, "C"), std::vector<std::string>{"BEGIN arm/hand cloth 3"});
}

TEST(ContactStateTrackerTest, aPairThatIsGoneEndsItsContact) {
  SampleReport sample;
  ContactStateTracker tracker(1, 5);
  tracker.update(sample.report);
  tracker.takeEvents();
  sample.report.pairs.erase(sample.report.pairs.begin() + kHandCloth);
  tracker.update(sample.report);
  EXPECT_EQ(texts(tracker.takeEvents()),
            std::vector<std::string>{"END arm/hand cloth 0 no longer monitored"});
}

TEST(ContactStateTrackerTest, refusesToDebounceByNoCycle) {
  EXPECT_THROW(ContactStateTracker(0, 1), std::invalid_argument);
  EXPECT_THROW(ContactStateTracker(1, 0), std::invalid_argument);
}

}  // namespace
}  // namespace deformable_contact_monitor
