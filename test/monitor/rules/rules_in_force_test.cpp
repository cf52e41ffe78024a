// Margins and rules in words.
#include "monitor/rules/rules_in_force.h"

#include <gtest/gtest.h>

#include "monitor/rules/pair_table.h"

namespace deformable_contact_monitor {
namespace {

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
  rules.links = LinkRules(srdf);
  rules.attached = {{"cloth", {"hand"}}};
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
  for (int i = 0; i < 12; ++i) add("link" + std::to_string(i), BodyKind::kLink, 0);
  ContactRules rules;
  rules.links = LinkRules(srdf);
  EXPECT_EQ(describe(rules).bodies[0].second,
            "margin 0 m, may touch link1 (srdf), link2 (srdf), link3 (srdf), link4 (srdf), link5 "
            "(srdf), link6 (srdf), link7 (srdf), link8 (srdf) and 3 more");
}

}  // namespace
}  // namespace deformable_contact_monitor
