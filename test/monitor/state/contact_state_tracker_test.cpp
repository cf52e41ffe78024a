// Tests of what the state of a pair of bodies says: whether they touch, where, how far apart.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "core/common/posed_body.h"
#include "tracker_fixture.h"

namespace deformable_contact_monitor {
namespace {

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
  sample.scene.setPose(2, RigidTransform{{0.6, -0.8, 0, 0, 0, -1, 0.8, 0.6, 0}, {0.5, 1, -2}});
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
    if (!first) continue;
    normals =
        normals + cross(toDouble(a.v[1]) - toDouble(a.v[0]), toDouble(a.v[2]) - toDouble(a.v[0]));
  }
  ContactStateTracker tracker(rules(1, 1));
  const ContactState state = take(&tracker, sample.report).states[kHandCloth];
  ASSERT_EQ(state.pair_count, sample.result.contacts.size());
  const double share = 1 / (6.0 * state.pair_count);
  EXPECT_NEAR(state.centroid.x, corners.x * share, 1e-5);
  EXPECT_NEAR(state.centroid.y, corners.y * share, 1e-5);
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

// The verdict decides whether bodies touch. A contact whose geometry has a positive separation is
// reported with a separation of 0.
TEST(ContactStateTrackerTest, withGeometryTheSeparationIsMinusTheDepth) {
  SampleReport sample;
  ContactStateTracker tracker(rules(1, 1));
  sample.result.geometry.resize(3);
  sample.result.geometry[0].separation_m = 0.25F;
  sample.result.geometry[1].separation_m = -0.5F;
  sample.result.geometry[2].separation_m = 0.375F;  // resize() leaves it uninitialised
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

// A part inside another body is reported as a contact, whatever else is missing.
TEST(ContactStateTrackerTest, whatIsInsideIsAContactThatSaysSo) {
  SampleReport sample;
  Containment& containment = sample.addContainment();
  containment.parts = {{1, 2, 0, {1, 2, 3}}, {1, 2, 5, {3, 2, 3}}, {2, 0, 0, {9, 9, 9}}};
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

}  // namespace
}  // namespace deformable_contact_monitor
