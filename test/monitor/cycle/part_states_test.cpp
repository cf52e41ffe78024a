// Tests the states of named parts of objects, from the mesh to the state, with the brute force
// detector.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "loop_fixture.h"
#include "monitor/state/contact_state_tracker.h"
#include "reference/reference_detectors.h"

namespace deformable_contact_monitor {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

// A cloth of four triangles side by side in the plane z = 0: triangle i has x in [2 i, 2 i + 1].
// Its parts are "hem" (0) and "half" (2). A cable of one upright triangle, which may cross one of
// them.
class PartsTest : public LoopTest {
 protected:
  PartsTest() {
    // Detectors look at the real clock, which must not overtake this one.
    steady_time_ = std::chrono::steady_clock::now() + std::chrono::hours(1);
    parameters_.max_mesh_age_s = 10;
    make_detector_ = [] { return makeBruteForceDetector(); };
    cloth().parts = {{"hem", {{0, 0}}}, {"half", {{2, 2}}}};
    said_.at_result = [this](const CycleReport& report) {
      if (tracker_ == nullptr) {
        tracker_ = std::make_unique<ContactStateTracker>(stateRules(parameters_));
      }
      tracker_->update(report);
      states_ = tracker_->states(report.header.stamp, report.now).states;
      contacts_ = report.result->contacts.size();
    };
  }

  ObjectParameters& cloth() { return parameters_.objects[0]; }

  void store(std::size_t object, const std::vector<float>& vertices, std::size_t triangles,
             std::uint32_t topology_id) {
    auto message = boost::make_shared<DeformableMesh>();
    message->header.stamp = ros_time_;
    message->header.frame_id = "base";
    message->topology_id = topology_id;
    message->vertices = vertices;
    for (std::uint32_t i = 0; i < 3 * triangles; ++i) message->triangles.push_back(i);
    meshes()[object].store({message});
  }

  // The cloth, in which one triangle has a NaN (-1: none), and the cable at a triangle and height.
  void move(int hidden, int crossed, float height = 0, std::size_t triangles = 4) {
    ros_time_ += ros::Duration(0.125);
    std::vector<float> sheet;
    for (std::size_t i = 0; i < triangles; ++i) {
      const float x = 2 * static_cast<float>(i);
      sheet.insert(sheet.end(), {x, 0, 0, x + 1, 0, 0, x, 1, 0});
    }
    if (hidden >= 0) sheet[9 * static_cast<std::size_t>(hidden) + 2] = kNaN;
    store(0, sheet, triangles, static_cast<std::uint32_t>(triangles));
    const float x = 2 * static_cast<float>(crossed) + 0.25F, low = height - 0.125F;
    store(1, {x, 0.25F, low, x, 0.25F, height + 0.125F, x + 0.125F, 0.25F, height + 0.125F}, 1, 1);
    step();
  }

  // "cloth/cable -, cloth:hem/cable C".
  std::string all() const {
    const std::string letters = "-nCa?P";
    std::string text;
    for (const ContactState& s : states_) {
      text += (text.empty() ? "" : ", ") + s.body_a + "/" + s.body_b + " " + letters.at(s.state);
    }
    return text;
  }
  // The states alone: of the cloth, its hem and its half.
  std::string letters() const {
    std::string text;
    for (const ContactState& s : states_) text += std::string("-nCa?P").at(s.state);
    return text;
  }
  void rule(const std::string& a, const std::string& b, bool allowed = true) {
    AllowedContact rule;
    rule.body_a = a;
    rule.body_b = b;
    rule.allowed = allowed;
    parameters_.allowed_contacts.add(rule);
  }

  std::unique_ptr<ContactStateTracker> tracker_;
  std::vector<ContactState> states_;
  std::size_t contacts_ = 0;
};

// The states after a rule changes, without a cycle.
class PartRulesTest : public PartsTest {
 protected:
  std::string change(const std::string& a, const std::string& b, bool allowed) {
    said_.at_list = [this](const CycleReport& report) {
      if (tracker_ == nullptr) return;
      tracker_->update(report);
      states_ = tracker_->states(ros_time_, ros_time_).states;
    };
    AllowedContactsChange change;
    change.add.resize(1);
    change.add[0].body_a = a;
    change.add[0].body_b = b;
    change.add[0].allowed = allowed;
    requests_.changeAllowedContacts(change);
    step();
    return letters();
  }
};

TEST_F(PartRulesTest, WhatIsNotAllowedAnyMoreIsUnknownUntilItIsLookedAt) {
  change("cloth:hem", "cable", true);
  move(-1, 0);
  EXPECT_EQ(letters(), "-a-");
  EXPECT_EQ(change("cloth:half", "cable", false), "-a-") << "as it was";
  EXPECT_EQ(change("cloth:hem", "cable", false),
            "?"
            "?-");
  move(-1, 0);
  EXPECT_EQ(letters(), "CC-");
}

TEST_F(PartRulesTest, SoIsThatOfTwoParts) {
  parameters_.objects[1].parts = {{"tip", {{0, 0}}}};
  change("cloth:hem", "cable:tip", true);
  move(-1, 0);
  EXPECT_EQ(all(), "cloth/cable -, cloth:hem/cable a, cloth:half/cable -, cloth/cable:tip -");
  EXPECT_EQ(change("cloth:hem", "cable:tip", false),
            "?"
            "?-?");
  move(-1, 0);
  EXPECT_EQ(letters(), "CC-C");
}

// Two parts have no state, so that of the other object's part stands for all of its parts.
TEST_F(PartsTest, AHiddenPartIsUnknownToAPartOfAnotherObject) {
  parameters_.objects[1].parts = {{"tip", {{0, 0}}}};
  move(0, 9);
  EXPECT_EQ(letters(), "-?-?");
  move(1, 9);
  EXPECT_EQ(letters(), "?--?");
}

TEST_F(PartsTest, WhatAPartMayTouchMayBeHiddenFromIt) {
  parameters_.objects[1].parts = {{"tip", {{0, 0}}}};
  rule("cloth", "cable:tip");
  rule("cloth:hem", "cable:tip", false);
  ros_time_ += ros::Duration(0.125);
  std::vector<float> sheet;
  for (const float x : {0.F, 2.F, 4.F, 6.F}) {
    sheet.insert(sheet.end(), {x, 0, 0, x + 1, 0, 0, x, 1, 0});
  }
  sheet[11] = kNaN;  // in triangle 1, which is of no part
  store(0, sheet, 4, 4);
  store(1, {20, 0, 0, 20, 0, 1, 21, 0, 1, 30, 0, 0, 30, 0, 1, 31, 0, 1}, 2, 1);
  step();
  EXPECT_EQ(all(), "cloth/cable ?, cloth:hem/cable -, cloth:half/cable -, cloth/cable:tip -");
}

TEST_F(PartsTest, EachPartHasAStateBehindThoseOfBodies) {
  move(-1, 0);
  EXPECT_EQ(all(), "cloth/cable C, cloth:hem/cable C, cloth:half/cable -");
  EXPECT_EQ(states_[1].pair_count, 1U);
  EXPECT_EQ(states_[0].centroid.x, states_[1].centroid.x);
  move(-1, 1);
  EXPECT_EQ(letters(), "C--");
  move(-1, 2);
  EXPECT_EQ(letters(), "C-C");
  move(-1, 9);
  EXPECT_EQ(letters(), "---");
}

// The cable crosses the triangles 0 and 1.
TEST_F(PartsTest, APartSumsUpAllOfItsContacts) {
  cloth().parts = {{"both", {{0, 1}}}, {"end", {{3, 3}}}};
  move(-1, 0);
  ros_time_ += ros::Duration(0.125);
  store(1, {-0.5F, 0.25F, -0.125F, 3.5F, 0.25F, -0.125F, 1.5F, 0.25F, 0.125F}, 1, 1);
  store(0, {0, 0, 0, 1, 0, 0, 0, 1, 0, 2, 0, 0, 3, 0, 0, 2, 1, 0,
            4, 0, 0, 5, 0, 0, 4, 1, 0, 6, 0, 0, 7, 0, 0, 6, 1, 0},
        4, 4);
  step();
  EXPECT_EQ(letters(), "CC-");
  EXPECT_EQ(states_[0].pair_count, 2U);
  EXPECT_EQ(states_[1].pair_count, 2U);
  EXPECT_EQ(states_[1].centroid.x, states_[0].centroid.x);
  EXPECT_NEAR(states_[1].centroid.x, (1.5 + (1 + 7) / 6.0) / 2, 1e-6);
}

TEST_F(PartsTest, AnObjectWithoutPartsHasItsOwnStateAlone) {
  cloth().parts.clear();
  move(0, 9);
  EXPECT_EQ(all(), "cloth/cable ?");
}

TEST_F(PartsTest, HiddenTrianglesMakeTheirOwnPartUnknown) {
  move(0, 9);
  EXPECT_EQ(letters(), "-?-");
  EXPECT_EQ(states_[1].reason,
            "cloth:hem: 1 of 1 triangles have a vertex that is not finite (tolerated_rejects)");
  move(1, 9);
  EXPECT_EQ(letters(), "?--");
  EXPECT_EQ(states_[0].reason,
            "cloth: 1 of 2 triangles have a vertex that is not finite (tolerated_rejects)");
  move(1, 2);
  EXPECT_EQ(letters(), "C-C") << "what was found is certain";
}

TEST_F(PartsTest, AnObjectWithoutTrianglesOfItsOwnNeedsAKnownPart) {
  cloth().parts = {{"left", {{0, 1}}}, {"right", {{2, 3}}}};
  move(0, 9);
  EXPECT_EQ(letters(), "-?-");
  move(3, 9);
  EXPECT_EQ(letters(), "--?");
  cloth().parts = {};
  tracker_.reset();
}

TEST_F(PartsTest, AnObjectWhosePartsAreAllHiddenIsUnknown) {
  cloth().parts = {{"all", {{0, 3}}}};
  move(3, 9);
  EXPECT_EQ(letters(), "??");
  EXPECT_EQ(states_[0].reason, states_[1].reason);
}

TEST_F(PartsTest, AnAllowedPartIsNotComputedAndTheRestIs) {
  rule("cloth:hem", "cable");
  move(-1, 0);
  EXPECT_EQ(letters(), "-a-");
  EXPECT_EQ(contacts_, 0U);
  move(-1, 1);
  EXPECT_EQ(letters(), "Ca-");
  EXPECT_EQ(contacts_, 1U);
  move(0, 9);
  EXPECT_EQ(letters(), "-a-") << "hidden triangles of an allowed part do not matter";
}

TEST_F(PartsTest, TheMoreParticularRuleWins) {
  rule("cloth", "cable");
  rule("cloth:hem", "cable", false);
  move(-1, 0);
  EXPECT_EQ(letters(), "CCa");
  move(-1, 1);
  EXPECT_EQ(letters(), "--a");
  move(0, 9);
  EXPECT_EQ(letters(), "??a") << "the hem is all that is monitored";
}

TEST_F(PartsTest, AnAllowedObjectHasAllowedParts) {
  rule("cloth", "*");
  move(-1, 0);
  EXPECT_EQ(letters(), "aaa");
}

TEST_F(PartsTest, ARuleForAllPartsLeavesTheObjectsOwn) {
  rule("cloth:*", "cable");
  move(-1, 0);
  EXPECT_EQ(letters(), "-aa");
  move(-1, 3);
  EXPECT_EQ(letters(), "Caa");
}

TEST_F(PartsTest, DistancesAreThoseOfThePart) {
  cloth().margin_m = 0.5F;
  move(-1, 2, 0.375F);
  EXPECT_EQ(letters(), "n-n");
  EXPECT_EQ(states_[0].min_separation, 0.25F);
  EXPECT_EQ(states_[2].min_separation, 0.25F);
  EXPECT_EQ(states_[2].point_b.z, 0.25F);
  EXPECT_EQ(states_[2].normal.z, 1);
}

// The cable is over the hem, 0.375 m from it, and 1.74 m from the cloth's own rest.
TEST_F(PartsTest, APartMayHaveALargerOrASmallerMarginThanItsObject) {
  for (const bool near_pairs : {false, true}) {
    parameters_.detector.near_pairs = near_pairs;
    cloth().margin_m = 0;
    cloth().parts[0].margin_m = 0.5F;
    restart();
    move(-1, 0, 0.5F);
    EXPECT_EQ(letters(), "nn-") << near_pairs;
    EXPECT_EQ(states_[0].min_separation, 0.375F);
    EXPECT_EQ(contacts_, near_pairs ? 1U : 0U);
    move(-1, 1, 0.5F);
    EXPECT_EQ(letters(), "---") << near_pairs;
    cloth().margin_m = 2;
    cloth().parts[0].margin_m = 0.25F;
    restart();
    move(-1, 0, 0.5F);
    EXPECT_EQ(letters(), "n--") << near_pairs;
    EXPECT_NEAR(states_[0].min_separation, std::hypot(1.625, 0.625), 1e-6);
    move(-1, 0);
    EXPECT_EQ(letters(), "CC-") << near_pairs;
  }
}

TEST_F(PartsTest, ATopologyThatDoesNotFitMakesThePartsUnknown) {
  move(-1, 0, 0, 2);
  EXPECT_EQ(letters(), "C??");
  EXPECT_EQ(states_[1].reason,
            "cloth:half has triangle 2, but the mesh of topology_id 2 has 2 triangles");
  move(-1, 0);
  EXPECT_EQ(letters(), "CC-");
  move(-1, 9, 0, 2);
  EXPECT_EQ(letters(), "-??");
}

TEST_F(PartsTest, AGroupFitsTheTrianglesOfItsFileAlone) {
  TriangleMesh of_file;
  of_file.vertices.resize(36);
  for (std::uint32_t i = 0; i < 12; ++i) of_file.triangles.push_back(i);
  const auto mesh = std::make_shared<const TriangleMesh>(of_file);
  cloth().parts = {{"hem", {{0, 0}}}, {"half", {{2, 2}}, {}, mesh}, {"end", {{3, 3}}, {}, mesh}};
  move(-1, 2);
  EXPECT_EQ(letters(), "C-C-");
  move(-1, 2, 0, 5);
  EXPECT_EQ(letters(), "C???");
  EXPECT_EQ(
      states_[1].reason,
      "cloth:half is a group of a mesh file with 12 vertices and 4 triangles, and the mesh of "
      "topology_id 5 has other triangles");
  move(-1, 3);
  EXPECT_EQ(letters(), "C--C");
}

TEST_F(PartsTest, AGroupOfOtherVerticesDoesNotFit) {
  TriangleMesh of_file;
  of_file.vertices.resize(36);
  for (std::uint32_t i = 0; i < 12; ++i) of_file.triangles.push_back(11 - i);
  cloth().parts = {{"half", {{2, 2}}, {}, std::make_shared<const TriangleMesh>(of_file)}};
  move(-1, 2);
  EXPECT_EQ(letters(), "C?");
}

TEST_F(PartsTest, WithoutKnownPartsNothingIsClaimedOfAnObjectThatIsAllowedButForAPart) {
  rule("cloth", "cable");
  rule("cloth:half", "cable", false);
  move(-1, 9, 0, 2);
  EXPECT_EQ(letters(), "?a?");
}

TEST_F(PartsTest, ABoxChoosesInTheFirstFiniteMesh) {
  cloth().parts = {{"box", {}, PartBox{{1.5, 0, 0}, {3, 1, 0}}}};
  move(3, 1);
  EXPECT_EQ(letters(), "C?");
  EXPECT_EQ(states_[1].reason,
            "cloth: boxes of parts wait for a mesh whose vertices are all finite");
  move(-1, 1);
  EXPECT_EQ(letters(), "CC");
  move(-1, 2);
  EXPECT_EQ(letters(), "C-");
  move(1, 9);
  EXPECT_EQ(letters(), "-?");
  move(-1, 1, 0, 3);
  EXPECT_EQ(states_[1].reason,
            "cloth: boxes of parts were taken in a mesh of topology_id 4, and this mesh has other "
            "triangles");
  EXPECT_EQ(letters(), "C?");
  move(-1, 1);
  EXPECT_EQ(letters(), "CC");
}

TEST_F(PartsTest, BoxesThatOverlapOrAreEmptyAreUnknownByName) {
  cloth().parts = {{"hem", {{0, 0}}}, {"box", {}, PartBox{{0, 0, 0}, {1, 1, 0}}}};
  move(-1, 9);
  EXPECT_EQ(letters(), "-??");
  EXPECT_EQ(states_[2].reason, "cloth:hem and cloth:box both have triangle 0");
}

TEST_F(PartsTest, ABoxWithoutATriangleIsUnknown) {
  cloth().parts = {{"box", {}, PartBox{{0, 0, 5}, {1, 1, 6}}}};
  move(-1, 9);
  EXPECT_EQ(letters(), "-?");
  EXPECT_EQ(states_[1].reason, "cloth:box has a box without a triangle of the first mesh");
}

TEST_F(PartsTest, APartOfAnObjectTouchesTheSameObject) {
  parameters_.pair_classes = {false, false, true, false};
  cloth().parts = {{"hem", {{0, 0}}}, {"half", {{2, 2}}}};
  ros_time_ += ros::Duration(0.125);
  store(0, {0, 0,   0,    1, 0, 0, 0, 1, 0, .25F, .25F, -1, .25F, .25F,
            1, .5F, .25F, 1, 4, 0, 0, 5, 0, 0,    4,    1,  0},
        3, 1);
  step();
  EXPECT_EQ(all(), "cloth/cloth C, cable/cable ?, cloth/cloth:hem C, cloth/cloth:half -");
}

TEST_F(PartsTest, APartPassesThrough) {
  parameters_.motion = Motion::kSwept;
  move(-1, 2, 1);
  EXPECT_EQ(letters(), "---");
  move(-1, 2, -1);
  EXPECT_EQ(letters(), "P-P");
  EXPECT_EQ(states_[2].pair_count, 1U);
  move(-1, 2, -2);
  EXPECT_EQ(letters(), "---");
  move(0, 2, -3);
  EXPECT_EQ(letters(), "-?-");
}

TEST_F(PartsTest, WhatIsForgottenOfAnObjectIsForgottenOfItsParts) {
  move(-1, 0);
  tracker_->forget("cloth", "reset", ros_time_);
  for (const ContactState& state : tracker_->states(ros_time_, ros_time_).states) {
    EXPECT_EQ(state.state, ContactState::UNKNOWN) << state.body_a;
  }
}

TEST_F(PartsTest, ADetectionThatWasCutOffDoesNotDecideAPart) {
  make_detector_ = [this] { return std::make_unique<FakeDetector>(&detector_); };
  detector_.out_of_time = true;
  move(-1, 9);
  EXPECT_EQ(letters(), "???");
  BodyDistance apart;
  apart.body_b = 1;
  apart.low_m = 2;
  apart.is_listed = true;
  detector_.distances = {apart};
  move(-1, 9);
  EXPECT_EQ(letters(), "---") << "the bodies are apart, and so are their parts";
  detector_.distances[0].low_m = 0;
  detector_.distances[0].high_m = 0;
  move(-1, 9);
  EXPECT_EQ(letters(), "C??");
}

}  // namespace
}  // namespace deformable_contact_monitor
