// Tests the part of an object that a link holds, from ~attach_object to the states, with the brute
// force detector.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "loop_fixture.h"
#include "monitor/cycle/held_part.h"
#include "monitor/state/contact_state_tracker.h"
#include "reference/reference_detectors.h"

namespace deformable_contact_monitor {
namespace {

constexpr float kHiddenValue = std::numeric_limits<float>::quiet_NaN();

// A cloth of four triangles side by side in the plane z = 0: triangle i has x in [2 i, 2 i + 1].
// Two links of one upright triangle each, "finger" and "palm", which may cross one of them.
class HeldTest : public LoopTest {
 protected:
  HeldTest() {
    // Detectors look at the real clock, which must not overtake this one.
    steady_time_ = std::chrono::steady_clock::now() + std::chrono::hours(1);
    parameters_.max_mesh_age_s = 10;
    parameters_.objects.pop_back();
    parameters_.pair_classes = {true, false, false, false};
    make_detector_ = [] { return makeBruteForceDetector(); };
    auto robot = std::make_shared<RobotGeometry>();
    for (const char* name : {"finger", "palm"}) {
      const TriangleMesh upright{{0, 0, -.125F, 0, 0, .125F, .125F, 0, .125F}, {0, 1, 2}};
      robot->links.push_back({name, "", upright, ""});
      robot->link_names.insert(name);
    }
    robot_ = robot;
    robot_source_ = [this] { return robot_; };
    said_.at_result = [this](const CycleReport& report) {
      if (tracker_ == nullptr) {
        tracker_ = std::make_unique<ContactStateTracker>(stateRules(parameters_));
      }
      tracker_->update(report);
      states_ = tracker_->states(report.header.stamp, report.now).states;
    };
  }

  void put(const std::string& link, int crossed) {
    geometry_msgs::TransformStamped t;
    t.header.frame_id = "base";
    t.header.stamp = ros_time_;
    t.child_frame_id = link;
    t.transform.translation.x = 2 * crossed + .25;
    t.transform.translation.y = .25;
    t.transform.rotation.w = 1;
    transforms_.add(t, "test", false, SteadyTime::max());
  }

  // Makes a cycle in which the links cross these triangles, and one triangle has a NaN (-1: none).
  std::string move(int finger, int palm, int hidden = -1, std::size_t triangles = 4,
                   std::uint32_t topology_id = 1) {
    ros_time_ += ros::Duration(0.125);
    put("finger", finger);
    put("palm", palm);
    auto message = boost::make_shared<DeformableMesh>();
    message->header.stamp = ros_time_;
    message->header.frame_id = "base";
    message->topology_id = topology_id;
    for (std::uint32_t i = 0; i < 3 * triangles; ++i) message->triangles.push_back(i);
    for (std::size_t i = 0; i < triangles; ++i) {
      const float x = 2 * static_cast<float>(i);
      message->vertices.insert(message->vertices.end(), {x, 0, 0, x + 1, 0, 0, x, 1, 0});
    }
    if (hidden >= 0) message->vertices[9 * static_cast<std::size_t>(hidden) + 2] = kHiddenValue;
    meshes()[0].store({message});
    step();
    return letters();
  }

  // Holds the part within the radius of the finger as it was in the last cycle.
  std::shared_ptr<const HeldPart> hold(float radius_m) {
    std::string why_not;
    const std::optional<IncomingMesh> mesh = meshes()[0].newest(&why_not);
    EXPECT_TRUE(mesh) << why_not;
    const std::vector<std::string> links = {"finger"};
    const auto part = findHeldPart({"cloth", *mesh, links, radius_m}, *robot_, parameters_,
                                   TransformLookup(transforms_, "base"));
    requests_.attach("cloth", links, part);
    return part;
  }

  // The states of the finger and the palm with the cloth, then of the finger with each part of it,
  // and then of the palm.
  std::string letters() const {
    std::string text;
    for (const ContactState& s : states_) text += std::string("-nCa?P").at(s.state);
    return text;
  }

  // From now on states also follow what is reported between cycles.
  void seeLists() {
    said_.at_list = [this](const CycleReport& report) {
      if (tracker_ == nullptr) return;
      tracker_->update(report);
      states_ = tracker_->states(ros_time_, ros_time_).states;
    };
  }

  void rule(const std::string& link, const std::string& other, bool allowed) {
    AllowedContactsChange change;
    AllowedContact rule;
    rule.body_a = link;
    rule.body_b = other;
    rule.allowed = allowed;
    change.add = {rule};
    requests_.changeAllowedContacts(change);
  }

  std::shared_ptr<const RobotGeometry> robot_;
  std::unique_ptr<ContactStateTracker> tracker_;
  std::vector<ContactState> states_;
};

TEST_F(HeldTest, AllButTheHeldPartIsWatchedAgainstTheFinger) {
  EXPECT_EQ(move(0, 9), "C-");
  EXPECT_EQ(hold(.5F)->triangles.size(), 1U);
  EXPECT_EQ(move(0, 9), "--a-");
  EXPECT_EQ(states_[2].body_b, "cloth:held");
  EXPECT_EQ(said_.rules.attached, std::vector<std::string>{"1 triangle of cloth by finger"});
  EXPECT_EQ(move(1, 9), "C-a-") << "the rest touches the finger";
  EXPECT_EQ(move(0, 0), "-CaC") << "the held part touches the palm";
  EXPECT_EQ(move(0, 3), "-Ca-");
}

TEST_F(HeldTest, ItEndsWithTheAttachment) {
  move(0, 9);
  hold(.5F);
  EXPECT_EQ(move(0, 9), "--a-");
  requests_.attach("cloth", {"finger"});
  EXPECT_EQ(move(0, 0), "aC");
  requests_.attach("cloth", {});
  EXPECT_EQ(move(0, 9), "C-");
}

// The finger's state spoke of what it did not hold.
TEST_F(HeldTest, WhatIsNoLongerHeldIsUnknownUntilItIsLookedAt) {
  seeLists();
  move(0, 9);
  hold(.5F);
  EXPECT_EQ(move(0, 9), "--a-");
  requests_.attach("cloth", {});
  step();
  EXPECT_EQ(letters(), "?-");
  EXPECT_EQ(move(0, 9), "C-");
}

TEST_F(HeldTest, WhatARuleOfTheHeldPartLeftOutIsUnknownUntilItIsLookedAt) {
  seeLists();
  rule("palm", "cloth:held", true);
  move(0, 0);
  hold(.5F);
  EXPECT_EQ(move(0, 0), "--aa");
  requests_.attach("cloth", {});
  step();
  EXPECT_EQ(letters(), "??");
  EXPECT_EQ(move(0, 0), "CC");
}

TEST_F(HeldTest, AfterAClockJumpOtherTrianglesEndIt) {
  ros_time_ = ros::Time(1000);
  move(0, 9);
  hold(.5F);
  EXPECT_EQ(move(0, 9), "--a-");
  ros_time_ = ros::Time(100);
  step();
  EXPECT_EQ(move(0, 9, -1, 3, 8), "C-");
  EXPECT_EQ(said_.rules.ended_holds.size(), 1U);
  EXPECT_EQ(move(0, 9), "C-");
}

TEST_F(HeldTest, ARequestThatWaitsDoesNotBringItBack) {
  move(0, 9);
  hold(.5F);
  EXPECT_EQ(move(0, 9), "--a-");
  at_cycle_ = [this] { requests_.attach("cable", {}); };
  EXPECT_EQ(move(0, 9, -1, 3, 8), "C-");
  EXPECT_EQ(move(0, 9), "C-");
}

TEST_F(HeldTest, WhereNamedPartsAreNotKnownNothingIsClaimed) {
  parameters_.objects[0].parts = {{"hem", {}, PartBox{{-1, -1, -1}, {3, 1, 1}}}};
  rule("palm", "cloth", true);
  rule("palm", "cloth:hem", false);
  move(0, 1, 3);  // the box waits for a mesh without hidden triangles
  hold(.5F);
  EXPECT_EQ(move(0, 1, 3), "???a?a");
}

TEST_F(HeldTest, AllOfAnObjectOfNamedPartsMayBeHeld) {
  parameters_.objects[0].parts = {{"left", {{0, 1}}}, {"right", {{2, 3}}}};
  move(0, 9);
  hold(100);
  EXPECT_EQ(move(0, 9), "a-aaa---");
}

TEST_F(HeldTest, AnotherHoldReplacesIt) {
  move(0, 9);
  hold(.5F);
  move(1, 9);
  EXPECT_EQ(hold(1.5F)->triangles.size(), 2U);
  EXPECT_EQ(move(3, 9), "C-a-");
  EXPECT_EQ(move(0, 9), "--a-");
}

// A larger hold takes triangles that a rule left out of the palm's state.
TEST_F(HeldTest, WhatIsHeldAnewIsUnknownUntilItIsLookedAt) {
  seeLists();
  rule("palm", "cloth", true);
  rule("palm", "cloth:held", false);
  move(0, 1);
  hold(.5F);
  EXPECT_EQ(move(0, 1), "--a-") << "the palm touches what is not held, which is allowed";
  hold(2);
  step();
  EXPECT_EQ(letters(), "??a?");
  EXPECT_EQ(move(0, 1), "-CaC");
  hold(.5F);
  step();
  EXPECT_EQ(letters(), "?CaC") << "a contact lasts until the next mesh";
  EXPECT_EQ(move(0, 1), "--a-");
}

TEST_F(HeldTest, WhatIsHeldAnewIsUnknownWhereNothingIsAllowed) {
  seeLists();
  rule("finger", "cloth:held", false);
  move(0, 9);
  hold(.5F);
  EXPECT_EQ(move(1, 9), "C---");
  hold(.5F);
  step();
  EXPECT_EQ(letters(), "C-??");
}

// The first hold takes triangles of a part that a rule left out. `since` must not count from a time
// at which they were not watched.
TEST_F(HeldTest, WhatIsTakenFromAnAllowedPartIsUnknownUntilItIsLookedAt) {
  seeLists();
  parameters_.objects[0].parts = {{"hem", {{0, 1}}}};
  rule("palm", "cloth:hem", true);
  rule("palm", "cloth:held", false);
  EXPECT_EQ(move(0, 9), "C-Ca");
  hold(.5F);
  step();
  EXPECT_EQ(letters(), "C?Ca??");
  EXPECT_EQ(move(0, 9), "---a--");
  EXPECT_EQ(states_[1].since, ros::Duration(0));
}

// Rules that concern nothing that was taken leave the states alone.
TEST_F(HeldTest, AHoldElsewhereChangesNoState) {
  seeLists();
  parameters_.objects[0].parts = {{"hem", {{2, 3}}}};
  rule("palm", "cloth:hem", true);
  EXPECT_EQ(move(0, 9), "C--a");
  hold(.5F);
  step();
  EXPECT_EQ(letters(), "C--aa?");
}

TEST_F(HeldTest, HeldTrianglesOfANamedPartStayOfThatPart) {
  parameters_.objects[0].parts = {{"hem", {{0, 1}}}, {"logo", {{3, 3}}}};
  move(0, 9);
  EXPECT_EQ(letters(), "C-C---");
  hold(.5F);
  EXPECT_EQ(move(0, 9), "----a---");
  EXPECT_EQ(move(0, 0), "-C--aC-C") << "the palm touches the hem, where it is held";
  EXPECT_EQ(move(1, 1), "CCC-aC--") << "the finger touches the hem, where it is not held";
  EXPECT_EQ(states_[2].body_b, "cloth:hem");
  EXPECT_EQ(move(0, 3), "-C--a-C-");
}

TEST_F(HeldTest, ANamedPartThatIsHeldAsAWholeIsAllowed) {
  parameters_.objects[0].parts = {{"hem", {{0, 0}}}};
  move(0, 9);
  hold(.5F);
  EXPECT_EQ(move(0, 0), "-CaaCC");
}

TEST_F(HeldTest, HiddenTrianglesMakeTheHeldPartUnknown) {
  move(0, 9);
  hold(.5F);
  EXPECT_EQ(move(0, 9, 0), "--a?");
  EXPECT_EQ(states_[3].reason,
            "cloth:held: 1 of 1 triangles have a vertex that is not finite (tolerated_rejects)");
  EXPECT_EQ(move(0, 9, 1), "??a-");
}

TEST_F(HeldTest, ANamedPartIsUnknownByTheTrianglesThatAreWatched) {
  parameters_.objects[0].parts = {{"hem", {{0, 1}}}};
  move(0, 9);
  hold(.5F);
  EXPECT_EQ(move(0, 9, 0), "---a??") << "the finger may touch what is hidden of the hem";
  EXPECT_EQ(states_[4].reason,
            "cloth:hem: 1 of 2 triangles have a vertex that is not finite (tolerated_rejects)");
  EXPECT_EQ(move(0, 9, 1), "--?a?-");
}

TEST_F(HeldTest, OtherTrianglesEndIt) {
  move(0, 9);
  hold(.5F);
  EXPECT_EQ(move(0, 9, -1, 4, 7), "--a-") << "these are the same triangles";
  EXPECT_EQ(move(0, 9, -1, 3, 8), "C-");
  EXPECT_EQ(said_.rules.ended_holds,
            std::vector<std::string>{"1 triangle of cloth by finger, because its mesh has other "
                                     "triangles now; attach the object again"});
  EXPECT_TRUE(said_.rules.attached.empty());
  EXPECT_EQ(move(0, 9), "C-") << "the former triangles do not bring it back";
  EXPECT_TRUE(requests_.attach("cable", {}).empty()) << "services know that it has ended";
  move(0, 9);
  EXPECT_TRUE(said_.rules.ended_holds.empty()) << "the next attachment ends the notice";
}

TEST_F(HeldTest, OtherTrianglesEndAHoldOfTheWholeObject) {
  move(0, 9);
  EXPECT_EQ(hold(100)->triangles.size(), 4U);
  EXPECT_EQ(move(0, 9), "a-a-");
  EXPECT_EQ(move(0, 9, -1, 3, 8), "C-") << "the link is looked up in the same cycle";
}

TEST_F(HeldTest, AMeshFromBeforeItWasChosenDoesNotEndIt) {
  move(0, 9, -1, 3, 8);
  HeldPart part;
  part.triangles = {0};
  part.topology =
      std::make_shared<const Topology>(Topology{1, 12, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}});
  part.stamp = ros_time_ + ros::Duration(0.2);
  requests_.attach("cloth", {"finger"}, std::make_shared<const HeldPart>(part));
  EXPECT_EQ(move(0, 9, -1, 3, 8), "C-") << "nothing of this mesh is held";
  EXPECT_TRUE(said_.rules.ended_holds.empty());
  EXPECT_EQ(move(0, 9), "--a-");
}

TEST_F(HeldTest, ItSurvivesAResetAndAnotherRobot) {
  move(0, 9);
  hold(.5F);
  requests_.requestReset();
  step();
  EXPECT_EQ(move(0, 9), "--a-");
  robot_ = std::make_shared<const RobotGeometry>(*robot_);
  EXPECT_EQ(move(1, 0), "CCaC");
}

TEST_F(HeldTest, RulesNameTheHeldPart) {
  move(0, 9);
  rule("palm", "cloth:held", true);
  hold(.5F);
  EXPECT_EQ(move(0, 0), "--aa");
  EXPECT_EQ(move(0, 1), "-Caa");
  rule("finger", "cloth", false);
  EXPECT_EQ(move(0, 0), "C-Ca") << "a rule that names both bodies is stronger";
}

TEST_F(HeldTest, WhatPassesThroughTheRestIsSeen) {
  parameters_.motion = Motion::kSwept;
  move(0, 9);
  hold(.5F);
  move(0, 9);
  EXPECT_EQ(move(0, 9), "--a-") << "the finger stays in what it holds";
  EXPECT_EQ(move(9, 9), "P-a-") << "on its way it passes the other triangles";
  EXPECT_EQ(move(9, 9), "--a-");
}

// Compares each state with what follows from the sets of triangles.
TEST_F(HeldTest, RandomHoldsAndNamedPartsAgreeWithTheirSets) {
  constexpr int kTriangles = 12;
  const std::vector<std::set<int>> named = {{0, 1, 4}, {5, 6, 7, 8}};
  parameters_.objects[0].parts = {{"hem", {{0, 1}, {4, 4}}}, {"logo", {{5, 8}}}};
  std::mt19937 dice(43);
  std::uniform_int_distribution<int> place(0, kTriangles + 1), side(1, 30);
  std::set<int> held;
  const auto letter = [&](bool is_finger, int crossed, const std::set<int>& part) {
    const auto is_allowed = [&](int t) { return is_finger && held.count(t) > 0; };
    if (std::all_of(part.begin(), part.end(), is_allowed)) return 'a';
    return part.count(crossed) > 0 && !is_allowed(crossed) ? 'C' : '-';
  };
  std::set<int> all;
  for (int t = 0; t < kTriangles; ++t) all.insert(t);
  std::map<char, int> seen;
  for (int i = 0; i < 1000; ++i) {
    if (i % 5 == 4) {
      held.clear();
      requests_.attach("cloth", {});
      move(place(dice) % kTriangles, 99, -1, kTriangles);
      if (i % 15 != 14) {
        const auto part = hold(static_cast<float>(side(dice)) / 2);
        held.insert(part->triangles.begin(), part->triangles.end());
      }
    }
    const int crossed[] = {place(dice), place(dice)};
    std::vector<std::set<int>> parts = named;
    if (!held.empty()) parts.push_back(held);
    std::string expected = {letter(true, crossed[0], all), letter(false, crossed[1], all)};
    for (const bool is_finger : {true, false}) {
      for (const std::set<int>& part : parts) {
        expected += letter(is_finger, crossed[is_finger ? 0 : 1], part);
      }
    }
    ASSERT_EQ(move(crossed[0], crossed[1], -1, kTriangles), expected) << i;
    for (const char one : expected) ++seen[one];
  }
  EXPECT_GT(seen['a'], 500);
  EXPECT_GT(seen['C'], 500);
}

// Pairs of parts that rules disabled must not stay disabled when the part is gone.
TEST_F(HeldTest, NothingStaysAllowedWhenItIsReleased) {
  move(0, 9);
  rule("finger", "cloth", true);
  rule("finger", "cloth:held", false);
  hold(.5F);
  EXPECT_EQ(move(0, 9), "C-C-");
  requests_.attach("cloth", {});
  EXPECT_EQ(move(0, 9), "a-");
  rule("finger", "cloth", false);
  EXPECT_EQ(move(0, 9), "C-");
}

}  // namespace
}  // namespace deformable_contact_monitor
