// Tests of states that follow from the nearest pair of two bodies.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <string>

#include "core/cpu_detector.h"
#include "random_scenes.h"
#include "tracker_fixture.h"

namespace deformable_contact_monitor {
namespace {

Vec3f toVector(const geometry_msgs::Point32& p) { return {p.x, p.y, p.z}; }

// Hand and cloth 3 m apart at their nearest pair; nothing is listed.
class NearStatesTest : public ::testing::Test {
 protected:
  NearStatesTest() {
    sample_.result.contacts.clear();
    sample_.result.nearest = {{{0, 1, 2, 2}, 3, {5, 0, 0}, {2, 0, 0}, {-1, 0, 0}}};
  }

  NearestPair& nearest() { return sample_.result.nearest[0]; }
  ContactState look(std::size_t pair = kHandCloth) {
    ContactStateTracker tracker(rules_);
    states_ = take(&tracker, sample_.report);
    return states_.states.at(pair);
  }
  // Makes the hand touch the cloth in the first of the listed contacts.
  void touch() {
    sample_.result.contacts = {{0, 0, 2, 0}, {0, 0, 2, 1}, {0, 1, 2, 1}};
    nearest() = {{0, 0, 2, 0}, 0, {1, 2, 3}, {1, 2, 3}, {}};
  }

  StateRules rules_ = rules(1, 1);
  SampleReport sample_;
  ContactStates states_;
};

TEST_F(NearStatesTest, APairWithANearestPairIsNearThere) {
  const ContactState state = look();
  EXPECT_EQ(state.state, ContactState::NEAR);
  EXPECT_EQ(state.min_separation, 3);
  EXPECT_EQ(toVector(state.point_a), (Vec3f{5, 0, 0}));
  EXPECT_EQ(toVector(state.point_b), (Vec3f{2, 0, 0}));
  EXPECT_EQ(toVector(state.normal), (Vec3f{-1, 0, 0}));
  EXPECT_EQ(toVector(state.centroid), (Vec3f{3.5F, 0, 0})) << "the middle";
  EXPECT_EQ(toVector(state.mean_normal), (Vec3f{-1, 0, 0}));
  EXPECT_EQ(state.pair_count, 0U) << "no pair is listed";
  EXPECT_TRUE(states_.complete);
}

// The distance is rounded to the nearest float32.
TEST_F(NearStatesTest, TheBoundIsTheNextSmallerFloat) {
  EXPECT_EQ(look().distance_low, std::nextafter(3.F, 0.F));
  nearest().distance_m = std::numeric_limits<float>::denorm_min();
  const ContactState state = look();
  EXPECT_EQ(state.state, ContactState::NEAR);
  EXPECT_EQ(state.min_separation, std::numeric_limits<float>::denorm_min());
  EXPECT_EQ(state.distance_low, 0);
}

TEST_F(NearStatesTest, APairWithoutANearestPairIsNone) {
  const ContactState state = look(kBaseCloth);
  EXPECT_EQ(state.state, ContactState::NONE);
  EXPECT_EQ(state.min_separation, std::numeric_limits<float>::infinity());
  EXPECT_EQ(toVector(state.point_a), Vec3f());
  EXPECT_EQ(toVector(state.normal), Vec3f());
}

// With near_pairs, pairs of one body's own triangles are listed as well.
TEST_F(NearStatesTest, ABodyHasNoDistanceFromItself) {
  sample_.report.pairs.push_back({2, 2, false});
  const std::size_t cloth_itself = sample_.report.pairs.size() - 1;
  sample_.result.nearest.clear();
  sample_.result.contacts = {{2, 0, 2, 2}, {2, 1, 2, 2}};
  sample_.result.separations_m = {0.25F, 0.5F};
  const ContactState state = look(cloth_itself);
  EXPECT_EQ(state.state, ContactState::NONE);
  EXPECT_EQ(state.min_separation, std::numeric_limits<float>::infinity());
  EXPECT_EQ(state.pair_count, 0U);
  sample_.result.separations_m = {0.25F, 0};
  EXPECT_EQ(look(cloth_itself).state, ContactState::CONTACT);
  EXPECT_EQ(look(cloth_itself).min_separation, 0);
}

TEST_F(NearStatesTest, WhatWasCutOffIsNeitherNearNorNone) {
  sample_.result.cutOff(kNoTime);
  for (const std::size_t pair : {kHandCloth, kBaseCloth}) {
    const ContactState state = look(pair);
    EXPECT_EQ(state.state, ContactState::UNKNOWN);
    EXPECT_EQ(state.reason, kNoTime);
    EXPECT_EQ(state.distance_low, 0);
    EXPECT_EQ(toVector(state.point_a), Vec3f());
  }
}

TEST_F(NearStatesTest, WhatTouchesIsAContactAlsoWhenCutOff) {
  nearest() = {{0, 0, 2, 0}, 0, {1, 2, 3}, {1, 2, 3}, {}};
  sample_.result.cutOff(kNoTime);
  const ContactState state = look();
  EXPECT_EQ(state.state, ContactState::CONTACT);
  EXPECT_EQ(toVector(state.point_b), (Vec3f{1, 2, 3}));
}

// The bounds know that no triangles are missing.
TEST_F(NearStatesTest, ACutOffCycleKeepsWhatItsBoundsDecide) {
  sample_.scene.setMargin(2, 4);
  BodyDistance bounds;
  bounds.body_b = 2;
  bounds.low_m = 2.875F;
  bounds.high_m = 3;
  bounds.point_a = {5, 0, 0};
  bounds.point_b = {2, 0, 0};
  sample_.result.distances = {bounds};
  rules_.tolerance_m = 0.25F;
  sample_.result.cutOff(kNoTime);
  EXPECT_EQ(look().state, ContactState::NEAR);
  EXPECT_EQ(look().min_separation, 3) << "the nearest pair is exact";
  sample_.result.distances[0].low_m = 2;
  EXPECT_EQ(look().state, ContactState::UNKNOWN) << "the bounds do not decide";
  sample_.result.distances[0].low_m = 2.875F;
  sample_.result.nearest.clear();
  const ContactState state = look();
  EXPECT_EQ(state.state, ContactState::NEAR);
  EXPECT_EQ(state.min_separation, 2.875F);
  EXPECT_EQ(state.point_b.x, 2);
  EXPECT_EQ(state.normal.x, -1);
}

// Bounds may say that all contacts of a pair are listed while it is near and none is.
TEST_F(NearStatesTest, BoundsOfAPairWithoutContactsAreNoInfinity) {
  BodyDistance bounds;
  bounds.body_b = 2;
  bounds.low_m = bounds.high_m = 3;
  bounds.is_listed = true;
  sample_.scene.setMargin(2, 4);
  sample_.result.distances = {bounds};
  EXPECT_EQ(look().state, ContactState::NEAR);
  EXPECT_EQ(look().min_separation, 3);
}

TEST_F(NearStatesTest, ListedPairsAreCountedAndSayWhere) {
  sample_.result.contacts = {{0, 0, 2, 0}, {0, 1, 2, 2}};
  sample_.result.separations_m = {3.5F, 3};
  const ContactState state = look();
  EXPECT_EQ(state.state, ContactState::NEAR);
  EXPECT_EQ(state.pair_count, 2U);
  EXPECT_EQ(state.min_separation, 3);
  EXPECT_EQ(toVector(state.normal), (Vec3f{-1, 0, 0}));
  EXPECT_EQ(state.mean_normal.z, 1) << "of the hand's triangles";
}

TEST_F(NearStatesTest, AContactHasOnePointTwice) {
  touch();
  const ContactState state = look();
  EXPECT_EQ(state.state, ContactState::CONTACT);
  EXPECT_EQ(toVector(state.point_a), (Vec3f{1, 2, 3}));
  EXPECT_EQ(toVector(state.point_b), (Vec3f{1, 2, 3}));
  EXPECT_EQ(toVector(state.normal), Vec3f()) << "contact_geometry is off";
  EXPECT_EQ(state.distance_low, 0);
}

TEST_F(NearStatesTest, AContactHasTheNormalOfTheDeepestListedPair) {
  touch();
  sample_.report.options.geometry = true;
  sample_.result.geometry.resize(3);
  const float depths_m[] = {0.5F, 2, 2};
  for (std::size_t i = 0; i < 3; ++i) {
    sample_.result.geometry[i].separation_m = -depths_m[i];
    sample_.result.geometry[i].normal = {i == 0 ? 1.F : 0, i == 1 ? 1.F : 0, i == 2 ? 1.F : 0};
  }
  const ContactState state = look();
  EXPECT_EQ(toVector(state.normal), (Vec3f{0, 1, 0})) << "the first of the two deepest";
  EXPECT_EQ(state.min_separation, -2);
}

// A body with itself has no nearest pair.
TEST_F(NearStatesTest, AContactWithItselfHasAPointOfItsFirstPair) {
  sample_.report.pairs = {{2, 2, false}};
  // Triangle 3 stands on triangle 0 at (0.25, 0.25, 0).
  sample_.scene.setMesh(
      2, {{0, 0, 0, 1, 0, 0, 0, 1, 0, 0.25F, 0.25F, 0, 0.25F, 0.25F, 1, 0.5F, 0.25F, 1},
          {0, 1, 2, 3, 4, 5}});
  sample_.result.nearest.clear();
  sample_.result.contacts = {{2, 0, 2, 1}};
  const ContactState state = look(0);
  EXPECT_EQ(state.state, ContactState::CONTACT);
  EXPECT_EQ(toVector(state.point_a), (Vec3f{0.25F, 0.25F, 0}));
  EXPECT_EQ(toVector(state.point_b), (Vec3f{0.25F, 0.25F, 0}));
}

TEST_F(NearStatesTest, APartInsideIsAContactInItsMiddle) {
  sample_.addContainment().parts = {{2, 0, 0, {7, 8, 9}}};
  const ContactState state = look();
  EXPECT_EQ(state.state, ContactState::CONTACT);
  EXPECT_EQ(state.inside, 2);
  EXPECT_EQ(toVector(state.point_a), (Vec3f{7, 8, 9}));
  EXPECT_EQ(toVector(state.point_b), (Vec3f{7, 8, 9}));
  EXPECT_EQ(toVector(state.mean_normal), Vec3f());
  EXPECT_EQ(state.distance_low, 0) << "the surfaces are apart, the bodies are not";
}

TEST_F(NearStatesTest, RejectedTrianglesMayBeNearer) {
  sample_.report.bodies[2].rejected = 1;
  EXPECT_EQ(look().state, ContactState::UNKNOWN);
  EXPECT_EQ(look().distance_low, 0);
  rules_.tolerated_rejects = 0.5;
  EXPECT_EQ(look().state, ContactState::NEAR);
}

TEST_F(NearStatesTest, NearPointsAreThoseOfTheState) {
  const auto near = [this] { return nearPoints(sample_.report, {0, 2, false}, rules_); };
  ASSERT_TRUE(near());
  EXPECT_EQ(near()->distance_m, 3);
  EXPECT_EQ(near()->point_b, (Vec3f{2, 0, 0}));
  EXPECT_FALSE(nearPoints(sample_.report, {1, 2, false}, rules_)) << "none";
  EXPECT_FALSE(nearPoints(sample_.report, {0, 2, true}, rules_)) << "allowed";
  sample_.report.bodies[2].rejected = 1;
  EXPECT_FALSE(near()) << "unknown";
  sample_.report.bodies[2].rejected = 0;
  sample_.report.bodies[0].unknown_because = "no mesh";
  EXPECT_FALSE(near()) << "unknown";
  sample_.report.bodies[0].unknown_because.clear();
  touch();
  EXPECT_FALSE(near()) << "in contact";
  nearest().distance_m = 3;
  sample_.result.contacts.clear();
  sample_.report.bodies[2].triggered = false;
  EXPECT_FALSE(near()) << "of another cycle";
}

// Returns the states of a scene whose bodies are all objects, by a detection with these options.
ContactStates statesBy(Detector* detector, const Scene& scene, const Options& options) {
  SampleReport sample;
  sample.report.bodies.clear();
  for (const Body& body : scene.bodies()) {
    sample.report.bodies.push_back(
        {body.name, BodyKind::kDeformable, sample.report.header.stamp, 0, "", true});
  }
  sample.report.pairs.clear();
  for (const auto& [a, b] : scene.enabledPairs()) {
    if (a != b) sample.report.pairs.push_back({a, b, false});
  }
  sample.report.scene = &scene;
  sample.report.options = options;
  sample.report.result = std::make_shared<const DetectionResult>(detector->detect(scene, options));
  ContactStateTracker tracker(rules(1, 1, 1));
  return take(&tracker, sample.report);
}

// The list of all pairs within the margins, as version 0.2 made it, gives the same states.
TEST(NearStates, AreThoseOfTheListInRandomScenes) {
  const std::unique_ptr<Detector> detector = makeCpuDetector();
  int counts[3] = {0, 0, 0};
  for (std::uint32_t seed = 0; seed < 400; ++seed) {
    Scene scene = randomScene(seed);
    std::mt19937 random(seed);
    for (BodyId id = 0; id < scene.bodyCount(); ++id) {
      const float margins_m[] = {0, 0.5F, 2, 10};
      scene.setMargin(id, margins_m[random() % 4]);
    }
    Options by_list, by_search, by_both;
    by_search.nearest = by_both.nearest = by_both.near_pairs = true;
    const ContactStates list = statesBy(detector.get(), scene, by_list);
    const ContactStates search = statesBy(detector.get(), scene, by_search);
    const ContactStates both = statesBy(detector.get(), scene, by_both);
    for (std::size_t i = 0; i < list.states.size(); ++i) {
      const ContactState &expected = list.states[i], &state = search.states[i];
      SCOPED_TRACE("seed " + std::to_string(seed) + ", " + state.body_a + " and " + state.body_b);
      ASSERT_EQ(state.state, expected.state);
      ASSERT_EQ(state.min_separation, expected.min_separation);
      ASSERT_EQ(toVector(state.point_a), toVector(expected.point_a));
      ASSERT_EQ(toVector(state.point_b), toVector(expected.point_b));
      ASSERT_EQ(toVector(state.normal), toVector(expected.normal));
      ASSERT_LE(state.distance_low, state.min_separation);
      ASSERT_EQ(state.state, both.states[i].state);
      ASSERT_EQ(state.min_separation, both.states[i].min_separation);
      ASSERT_EQ(toVector(state.point_b), toVector(both.states[i].point_b));
      ASSERT_EQ(both.states[i].pair_count, expected.pair_count);
      ASSERT_TRUE(state.state != ContactState::NEAR || state.pair_count == 0);
      ++counts[state.state];
    }
  }
  for (const int count : counts) EXPECT_GT(count, 50);
}

}  // namespace
}  // namespace deformable_contact_monitor
