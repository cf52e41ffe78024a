// Tests of states that follow from what is certain of bodies' distances.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "cuda/detector_choice.h"
#include "tracker_fixture.h"

namespace deformable_contact_monitor {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Hand and cloth, with a margin of 20 mm, at 5 mm tolerance; base and cloth are far apart.
class BoundedStatesTest : public ::testing::Test {
 protected:
  BoundedStatesTest() {
    rules_.tolerance_m = 0.005F;
    sample_.scene.setMargin(2, 0.02F);
    sample_.result.guaranteed = false;
    sample_.result.contacts.clear();
    sample_.result.distances.resize(2);
    BodyDistance& far = sample_.result.distances[1];
    far.body_a = 1;
    far.body_b = 2;
    far.low_m = 3;
    distance().body_a = 0;
    distance().body_b = 2;
    distance().point_a = {1, 2, 3};
    distance().point_b = {1, 2, 3.5F};
  }

  BodyDistance& distance() { return sample_.result.distances[0]; }

  ContactState look(float low_m, float high_m) {
    distance().low_m = low_m;
    distance().high_m = high_m;
    return look();
  }
  ContactState look() {
    ContactStateTracker tracker(rules_);
    states_ = take(&tracker, sample_.report);
    return states_.states[kHandCloth];
  }

  StateRules rules_ = rules(1, 1);
  SampleReport sample_;
  ContactStates states_;
};

TEST_F(BoundedStatesTest, WhatIsFartherThanTheMarginIsNone) {
  const ContactState state = look(0.03F, kInfinity);
  EXPECT_EQ(state.state, ContactState::NONE);
  EXPECT_EQ(state.min_separation, kInfinity);
  EXPECT_EQ(state.distance_low, 0.03F);
  EXPECT_EQ(state.pair_count, 0U);
  EXPECT_TRUE(states_.complete);
  EXPECT_EQ(states_.tolerance, 0.005F);
}

TEST_F(BoundedStatesTest, AWitnessWithinTheToleranceIsAContact) {
  const ContactState state = look(0.001F, 0.005F);
  EXPECT_EQ(state.state, ContactState::CONTACT);
  EXPECT_EQ(state.min_separation, 0);
  EXPECT_EQ(state.distance_low, 0.001F);
  EXPECT_EQ(state.pair_count, 0U);
  EXPECT_EQ(state.centroid.z, 3.25F);
  EXPECT_EQ(state.mean_normal.z, 1);
  EXPECT_EQ(look(0.001F, 0.0051F).state, ContactState::NEAR) << "0.1 mm beyond it";
}

TEST_F(BoundedStatesTest, WithoutToleranceOnlyWhatIntersectsIsAContact) {
  rules_.tolerance_m = 0;
  distance().point_b = distance().point_a;
  const ContactState state = look(0, 0);
  EXPECT_EQ(state.state, ContactState::CONTACT);
  EXPECT_EQ(state.mean_normal.z, 0) << "undefined";
  EXPECT_EQ(look(0, 1e-6F).state, ContactState::UNKNOWN);
}

TEST_F(BoundedStatesTest, WhatIsApartWithinMarginAndToleranceIsNearNoFartherThanItIs) {
  const ContactState state = look(0.018F, 0.022F);
  EXPECT_EQ(state.state, ContactState::NEAR);
  EXPECT_EQ(state.min_separation, 0.018F);
  EXPECT_EQ(state.distance_low, 0.018F);
  EXPECT_EQ(state.centroid.z, 3.25F);
}

TEST_F(BoundedStatesTest, WhatIsOpenIsUnknownWithWhatIsCertain) {
  const ContactState state = look(0.004F, kInfinity);
  EXPECT_EQ(state.state, ContactState::UNKNOWN);
  EXPECT_EQ(state.reason, "not decided in time");
  EXPECT_TRUE(std::isnan(state.min_separation));
  EXPECT_EQ(state.distance_low, 0.004F);
  EXPECT_FALSE(states_.complete);
  EXPECT_EQ(states_.states[kBaseCloth].state, ContactState::NONE);
}

// A cut-off says nothing against what is certain.
TEST_F(BoundedStatesTest, TheEndOfABudgetLeavesWhatIsDecided) {
  sample_.result.cutOff(kNoTime);
  EXPECT_EQ(look(0.03F, kInfinity).state, ContactState::NONE);
  EXPECT_EQ(look(0, 0.004F).state, ContactState::CONTACT);
  EXPECT_EQ(look(0, kInfinity).reason, "not decided in time");
  sample_.result.distances.clear();
  EXPECT_EQ(look().reason, kNoTime) << "as exact detectors are cut off";
}

TEST_F(BoundedStatesTest, OtherEndsSayWhy) {
  sample_.result.cutOff("stopped");
  EXPECT_EQ(look(0, kInfinity).reason, "stopped");
}

TEST_F(BoundedStatesTest, PairsThatWereSeenCountAndSayWhere) {
  sample_.result.contacts = {{0, 0, 2, 0}, {0, 0, 2, 1}};
  distance().contact_count = 2;
  const ContactState state = look(0, 0);
  EXPECT_EQ(state.state, ContactState::CONTACT);
  EXPECT_EQ(state.pair_count, 2U);
  EXPECT_EQ(state.mean_normal.z, 1) << "of the hand's triangles";
  EXPECT_EQ(state.centroid.z, 0);
}

TEST_F(BoundedStatesTest, AListDecidesWithoutBounds) {
  distance().is_listed = true;
  EXPECT_EQ(look(0, kInfinity).state, ContactState::NONE);
  sample_.result.contacts = {{0, 0, 2, 0}};
  sample_.result.separations_m = {0.015F};
  distance().contact_count = 1;
  const ContactState state = look(0.0149F, 0.015F);
  EXPECT_EQ(state.state, ContactState::NEAR);
  EXPECT_EQ(state.min_separation, 0.015F);
}

// A part with a point within may cross the surface, which makes it no less a contact.
TEST_F(BoundedStatesTest, WithinIsSaidOnlyOfSurfacesThatAreApart) {
  Containment& containment = sample_.addContainment();
  containment.parts = {{2, 0, 0, {7, 7, 7}}};
  ContactState state = look(0.03F, kInfinity);
  EXPECT_EQ(state.state, ContactState::CONTACT);
  EXPECT_EQ(state.inside, 2);
  EXPECT_EQ(state.distance_low, 0) << "that is the surfaces'";
  EXPECT_EQ(state.centroid.x, 7);
  state = look(0, kInfinity);
  EXPECT_EQ(state.state, ContactState::CONTACT);
  EXPECT_EQ(state.inside, 0);
  state = look(0, 0.001F);
  EXPECT_EQ(state.state, ContactState::CONTACT);
  EXPECT_EQ(state.inside, 0);
  EXPECT_EQ(state.centroid.z, 3.25F);
}

TEST_F(BoundedStatesTest, WhatMayBeWithinIsNotNone) {
  Containment& containment = sample_.addContainment();
  containment.cut_off_because = kNoTime;
  const ContactState state = look(0.03F, kInfinity);
  EXPECT_EQ(state.state, ContactState::UNKNOWN);
  EXPECT_EQ(state.reason, kNoTime);
  EXPECT_EQ(state.distance_low, 0);
}

TEST_F(BoundedStatesTest, RejectedTrianglesTakeCertainty) {
  sample_.report.bodies[2].rejected = 1;
  const ContactState state = look(0.03F, kInfinity);
  EXPECT_EQ(state.state, ContactState::UNKNOWN);
  EXPECT_EQ(state.distance_low, 0);
  EXPECT_EQ(look(0, 0.001F).state, ContactState::CONTACT);
}

// A square of 1 m, of as many quads a side, at that height.
TriangleMesh sheet(std::uint32_t quads, float z) {
  TriangleMesh mesh;
  for (std::uint32_t y = 0; y <= quads; ++y) {
    for (std::uint32_t x = 0; x <= quads; ++x) {
      const auto at = [quads](std::uint32_t i) {
        return static_cast<float>(i) / static_cast<float>(quads);
      };
      for (const float c : {at(x), at(y), z}) mesh.vertices.push_back(c);
      if (x == quads || y == quads) continue;
      const std::uint32_t i = y * (quads + 1) + x, above = i + quads + 1;
      for (const std::uint32_t v : {i, i + 1, above, above, i + 1, above + 1}) {
        mesh.triangles.push_back(v);
      }
    }
  }
  return mesh;
}

// Runs the bounded detector on a cloth above a link, with a margin of 20 mm.
class ClothAboveLinkTest : public ::testing::Test {
 protected:
  ClothAboveLinkTest() {
    rules_.tolerance_m = options_.tolerance_m = 0.005F;
    options_.threads = 1;
  }

  ContactState look(float height_m, bool has_time = true) {
    SampleReport sample;
    Scene scene;
    scene.addBody("link", sheet(10, 0));
    scene.addBody("cloth", sheet(40, height_m));
    scene.setMargin(1, margin_m_);
    scene.setPairEnabled(0, 1, true);
    for (std::uint32_t i = 0; i <= TilingCache::kSettledAfter; ++i) {
      for (const Body& body : scene.bodies()) tilings_->of(body);
    }
    tilings_->wait();
    Options options = options_;
    const auto now = std::chrono::steady_clock::now();
    if (!has_time) options.limits.deadline = now - std::chrono::seconds(1);
    sample.report.bodies.erase(sample.report.bodies.begin());
    sample.report.pairs = {{0, 1, false}};
    sample.report.scene = &scene;
    sample.report.result =
        std::make_shared<const DetectionResult>(detector_->detect(scene, options));
    EXPECT_EQ(sample.report.result->distances.size(), 1U);
    ContactStateTracker tracker(rules_);
    return take(&tracker, sample.report).states.at(0);
  }

  StateRules rules_ = rules(1, 1);
  Options options_;
  float margin_m_ = 0.02F;
  std::shared_ptr<TilingCache> tilings_ = std::make_shared<TilingCache>();
  std::unique_ptr<Detector> detector_ =
      makeDetector(BackendChoice::kCpu, WithoutCuda::kRefuse, CudaSettings(), nullptr, tilings_);
};

TEST_F(ClothAboveLinkTest, IsAContactWithinTheTolerance) {
  const ContactState state = look(0.004F);
  EXPECT_EQ(state.state, ContactState::CONTACT);
  EXPECT_LE(state.distance_low, 0.004F);
  EXPECT_FLOAT_EQ(state.mean_normal.z, 1);
  EXPECT_NEAR(state.centroid.z, 0.002, 1e-6);
}

TEST_F(ClothAboveLinkTest, IsNearBeyondItWithinTheMargin) {
  const ContactState state = look(0.012F);
  EXPECT_EQ(state.state, ContactState::NEAR);
  EXPECT_GE(state.min_separation, 0.007F);
  EXPECT_LE(state.min_separation, 0.012F);
}

TEST_F(ClothAboveLinkTest, IsNoneBeyondTheMargin) {
  const ContactState state = look(0.03F);
  EXPECT_EQ(state.state, ContactState::NONE);
  EXPECT_GT(state.distance_low, 0.02F);
  EXPECT_LE(state.distance_low, 0.03F);
}

// It is as true as a contact within the tolerance would be.
TEST_F(ClothAboveLinkTest, MayBeNoneWithinTheTolerance) {
  margin_m_ = 0;
  const ContactState state = look(0.004F);
  EXPECT_NE(state.state, ContactState::UNKNOWN);
  EXPECT_LE(state.distance_low, 0.004F);
  EXPECT_EQ(look(0).state, ContactState::CONTACT);
}

TEST_F(ClothAboveLinkTest, IsUnknownInNoTime) {
  const ContactState state = look(0.004F, false);
  EXPECT_EQ(state.state, ContactState::UNKNOWN);
  EXPECT_EQ(state.reason, "not decided in time");
}

}  // namespace
}  // namespace deformable_contact_monitor
