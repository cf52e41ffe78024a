// Tests what services and diagnostics say about rules.
#include "monitor/rules/rule_texts.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace deformable_contact_monitor {
namespace {

MonitorParameters parameters() {
  MonitorParameters parameters;
  parameters.objects = {{"cloth", "", 0, true}, {"cable", "", 0, true}};
  parameters.rigids = {{"table", "table"}, {"clamp", "clamp"}};
  return parameters;
}

const MonitorParameters kParameters = parameters();

RobotGeometry robot() {
  RobotGeometry robot;
  robot.link_names = {"arm", "hand", "tool_frame"};
  robot.links.push_back({"arm", "test", TriangleMesh(), ""});
  return robot;
}

TEST(RuleTexts, AnyLinkOfTheRobotMayHold) {
  const RobotGeometry known = robot();
  EXPECT_EQ(attachProblem("cloth", {"hand", "tool_frame"}, kParameters, &known), "");
  EXPECT_EQ(attachProblem("cable", {}, kParameters, &known), "");
  EXPECT_EQ(attachProblem("cable", {}, kParameters, nullptr), "") << "to release needs no robot";
}

TEST(RuleTexts, UnknownNamesAreRefusedAllOfThem) {
  const RobotGeometry known = robot();
  EXPECT_EQ(attachProblem("clot", {"hnd", "arm", "xxxxxxxx"}, kParameters, &known),
            "no object 'clot' is monitored (did you mean 'cloth'?); the robot has no link 'hnd' "
            "(did you mean 'hand'?); the robot has no link 'xxxxxxxx'");
  EXPECT_EQ(attachProblem("", {""}, kParameters, &known).find("no object '' is monitored"), 0U);
  EXPECT_NE(attachProblem("cloth", {""}, kParameters, &known), "");
  EXPECT_NE(attachProblem("cloth", {"*"}, kParameters, &known), "") << "no wildcards";
  EXPECT_NE(attachProblem("hand", {}, kParameters, &known), "") << "a link is no object";
  EXPECT_EQ(attachProblem("cloth", {"hand"}, kParameters, nullptr),
            "no robot is loaded yet, so no link can hold the object");
}

TEST(RuleTexts, RigidObjectsHoldWhatDeformsAndLinksHoldThem) {
  const RobotGeometry known = robot();
  EXPECT_EQ(attachProblem("clamp", {"hand"}, kParameters, &known), "");
  EXPECT_EQ(attachProblem("clamp", {}, kParameters, nullptr), "");
  EXPECT_EQ(attachProblem("cloth", {"clamp"}, kParameters, nullptr), "") << "without a robot";
  EXPECT_EQ(attachProblem("cloth", {"clamp", "hand"}, kParameters, &known), "");
  EXPECT_EQ(attachProblem("cloth", {"clmp"}, kParameters, &known),
            "the robot has no link 'clmp' (did you mean 'clamp'?)");
  EXPECT_EQ(attachProblem("clamp", {"table"}, kParameters, &known),
            "'table' is rigid as 'clamp' is, and only links hold rigid objects");
}

TEST(RuleTexts, WhatIsHeldInWords) {
  EXPECT_EQ(describeHeld({}), "nothing is held");
  EXPECT_EQ(describeHeld({{"cloth", {{"finger", "hand"}}}, {"cable", {{"arm"}}}}),
            "held: cable by arm; cloth by finger, hand");
  HeldPart part;
  part.triangles = {7, 9};
  EXPECT_EQ(describeHeld({{"cloth", {{"hand"}, std::make_shared<const HeldPart>(part)}}}),
            "held: 2 triangles of cloth by hand");
}

class RulesInForceTest : public ::testing::Test {
 protected:
  void add(const std::string& name, BodyKind kind, float margin_m) {
    BodyStatus body;
    body.name = name;
    body.kind = kind;
    bodies_.push_back(body);
    scene_.setMargin(scene_.addBody(name, TriangleMesh()), margin_m);
  }

  RulesInForce describe(const ContactRules& rules) const {
    const PairClasses classes{true, false, true, true};
    return describeRules(bodies_, monitoredPairs(bodies_, classes, rules), rules, scene_);
  }

  std::vector<BodyStatus> bodies_;
  Scene scene_;
};

std::size_t index(RuleSource source) { return static_cast<std::size_t>(source); }

TEST_F(RulesInForceTest, EachBodySaysWhomItMayTouchAndWhy) {
  add("arm", BodyKind::kLink, 0);
  add("hand", BodyKind::kLink, 0.25F);
  add("cloth", BodyKind::kDeformable, 0.5F);
  ContactRules rules;
  Srdf srdf;
  srdf.disabled = {{"arm", "hand", "Adjacent"}, {"arm", "gone", ""}};
  rules.links = LinkRules({{"r", {"arm", "hand"}, srdf}});
  rules.attached = {{"cloth", {{"hand"}}}};
  AllowedContact self;
  self.body_a = self.body_b = "cloth";
  self.allowed = true;
  rules.allowed.add(self, RuleSource::kService);
  const RulesInForce in_force = describe(rules);
  EXPECT_EQ(in_force.pairs, 4U);
  EXPECT_EQ(in_force.allowedPairs(), 3U);
  for (const RuleSource source : {RuleSource::kSrdf, RuleSource::kAttached, RuleSource::kService}) {
    EXPECT_EQ(in_force.allowed_pairs[index(source)], 1U) << toString(source);
  }
  EXPECT_EQ(in_force.rules[index(RuleSource::kSrdf)], 2U);
  EXPECT_EQ(in_force.rules[index(RuleSource::kAttached)], 1U);
  EXPECT_EQ(in_force.rules[index(RuleSource::kService)], 1U);
  EXPECT_EQ(in_force.rules[index(RuleSource::kParameters)], 0U);
  EXPECT_EQ(in_force.attached, std::vector<std::string>{"cloth by hand"});
  using Lines = std::vector<std::pair<std::string, std::string>>;
  EXPECT_EQ(in_force.bodies,
            (Lines{{"arm", "margin 0 m, may touch hand (srdf)"},
                   {"hand", "margin 0.25 m, may touch arm (srdf), cloth (attached)"},
                   {"cloth", "margin 0.5 m, may touch hand (attached), cloth (service)"}}));
}

TEST_F(RulesInForceTest, OfManyTheFirstAreNamed) {
  Srdf srdf;
  srdf.disabled_links = {"link0"};
  std::set<std::string> links;
  for (int i = 0; i < 12; ++i) {
    links.insert("link" + std::to_string(i));
    add("link" + std::to_string(i), BodyKind::kLink, 0);
  }
  ContactRules rules;
  rules.links = LinkRules({{"r", links, srdf}});
  EXPECT_EQ(describe(rules).bodies[0].second,
            "margin 0 m, may touch link1 (srdf), link2 (srdf), link3 (srdf), link4 (srdf), link5 "
            "(srdf), link6 (srdf), link7 (srdf), link8 (srdf) and 3 more");
}

TEST(RuleTexts, NamesThatAreNoBodysAreFound) {
  AllowedContacts allowed;
  for (const auto& [a, b] :
       {std::pair<const char*, const char*>{"arm", "*"}, {"cloth", "hnad"}, {"clth", "arm"}}) {
    AllowedContact rule;
    rule.body_a = a;
    rule.body_b = b;
    rule.allowed = true;
    allowed.add(rule);
  }
  std::vector<BodyStatus> bodies(2);
  bodies[0].name = "arm";
  bodies[1].name = "cloth";
  bodies[1].kind = BodyKind::kDeformable;
  MonitorParameters parameters;
  parameters.link_margin_m = {{"arm", 0.1}, {"amr", 0.1}, {"cloth", 0.1}};
  EXPECT_EQ(describeUnknownNames(parameters, allowed, bodies),
            (std::vector<std::string>{
                "margins (~link_margin_m) name 'amr' (did you mean 'arm'?), which is no link that "
                "is looked at",
                "margins (~link_margin_m) name 'cloth', which is no link that is looked at",
                "allowed contacts name 'clth' (did you mean 'cloth'?), which is no link or object",
                "allowed contacts name 'hnad', which is no link or object"}));
}

TEST(RuleTexts, ManyUnknownNamesAreCounted) {
  AllowedContacts allowed;
  for (int i = 0; i < 50; ++i) {
    AllowedContact rule;
    rule.body_a = "*";
    rule.body_b = "nothing" + std::to_string(i);
    allowed.add(rule);
  }
  const auto lines = describeUnknownNames({}, allowed, {});
  ASSERT_EQ(lines.size(), 21U);
  EXPECT_EQ(lines.back(), "and 30 more names are unknown");
}

}  // namespace
}  // namespace deformable_contact_monitor
