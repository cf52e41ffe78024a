// Tests which rule decides, what a list of rules rejects, and which pairs are monitored.
#include "monitor/rules/contact_rules.h"

#include <gtest/gtest.h>

#include <chrono>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace deformable_contact_monitor {
namespace {

AllowedContact rule(const std::string& a, const std::string& b, bool allowed = true) {
  AllowedContact rule;
  rule.body_a = a;
  rule.body_b = b;
  rule.allowed = allowed;
  return rule;
}

TEST(AllowedContacts, NothingIsAllowedWithoutARule) {
  EXPECT_FALSE(AllowedContacts().allows("arm", "cloth"));
}

TEST(AllowedContacts, OrderOfBodiesDoesNotMatter) {
  AllowedContacts allowed;
  allowed.add(rule("cloth", "arm"));
  EXPECT_TRUE(allowed.allows("arm", "cloth"));
  EXPECT_TRUE(allowed.allows("cloth", "arm"));
  EXPECT_FALSE(allowed.allows("arm", "cable"));
}

TEST(AllowedContacts, PairBeatsWildcardBeatsDefault) {
  const AllowedContact pair = rule("hand", "cloth", false), one = rule("*", "hand", true),
                       two = rule("*", "*", false);
  const std::vector<std::vector<AllowedContact>> orders = {{pair, one, two}, {pair, two, one},
                                                           {one, pair, two}, {one, two, pair},
                                                           {two, pair, one}, {two, one, pair}};
  for (const auto& order : orders) {
    AllowedContacts allowed;
    for (const AllowedContact& r : order) allowed.add(r);
    EXPECT_FALSE(allowed.allows("hand", "cloth"));
    EXPECT_TRUE(allowed.allows("hand", "cable"));
    EXPECT_FALSE(allowed.allows("arm", "cable"));
  }
}

TEST(AllowedContacts, AmongEqualsTheLastWins) {
  AllowedContacts allowed;
  allowed.add(rule("*", "cloth", true));
  allowed.add(rule("hand", "*", false));
  EXPECT_FALSE(allowed.allows("hand", "cloth"));
  allowed.add(rule("cloth", "*", true));
  EXPECT_TRUE(allowed.allows("hand", "cloth"));
}

TEST(AllowedContacts, ARuleForTheSamePairReplaces) {
  AllowedContacts allowed;
  allowed.add(rule("hand", "cloth", true));
  allowed.add(rule("cloth", "hand", false));
  ASSERT_EQ(allowed.rules().size(), 1U);
  EXPECT_FALSE(allowed.allows("hand", "cloth"));
}

TEST(AllowedContacts, ASelfPairIsAPair) {
  AllowedContacts allowed;
  allowed.add(rule("cloth", "cloth"));
  EXPECT_TRUE(allowed.allows("cloth", "cloth"));
  EXPECT_FALSE(allowed.allows("cloth", "cable"));
  EXPECT_FALSE(allowed.allows("cable", "cable"));
}

TEST(AllowedContacts, AnEmptyNameIsRefused) {
  AllowedContacts allowed;
  EXPECT_THROW(allowed.add(rule("", "cloth")), std::invalid_argument);
  EXPECT_THROW(allowed.add(rule("cloth", "")), std::invalid_argument);
  EXPECT_TRUE(allowed.rules().empty());
}

TEST(AllowedContacts, AChangeIsMadeWholeOrNotAtAll) {
  AllowedContacts allowed;
  allowed.add(rule("arm", "cloth"));
  allowed.add(rule("hand", "cloth"));
  EXPECT_THROW(allowed.change({false, {rule("arm", "cable")}, {rule("arm", "*")}}),
               std::invalid_argument)
      << "it is not in force";
  EXPECT_THROW(allowed.change({true, {}, {rule("arm", "*"), rule("", "*")}}),
               std::invalid_argument);
  ASSERT_EQ(allowed.count(), 2U);
  allowed.change({false, {rule("cloth", "arm")}, {rule("wrist", "cloth")}});
  EXPECT_FALSE(allowed.allows("arm", "cloth"));
  EXPECT_TRUE(allowed.allows("hand", "cloth") && allowed.allows("wrist", "cloth"));
  EXPECT_THROW(allowed.change({true, {rule("hand", "cloth")}, {}}), std::invalid_argument)
      << "all are gone before";
  allowed.change({true, {}, {}});
  EXPECT_EQ(allowed.count(), 0U);
}

TEST(AllowedContacts, ThereIsALimit) {
  AllowedContacts allowed;
  for (std::size_t i = 0; i < AllowedContacts::kMostRules; ++i) {
    allowed.add(rule("link" + std::to_string(i), "cloth"));
  }
  EXPECT_THROW(allowed.add(rule("arm", "cloth")), std::invalid_argument);
  EXPECT_NO_THROW(allowed.add(rule("link7", "cloth", false))) << "it replaces one";
  EXPECT_FALSE(allowed.allows("link7", "cloth"));
}

// A comparison of each rule with each other one takes 9.7 s for 40 000 rules.
TEST(AllowedContacts, ManyRulesTakeLittleTime) {
  AllowedContactsChange change;
  for (int i = 0; i < 40000; ++i) change.add.push_back(rule("link" + std::to_string(i), "cloth"));
  const auto start = std::chrono::steady_clock::now();
  AllowedContacts allowed;
  allowed.change(change);
  EXPECT_EQ(allowed.rules().size(), 40000U);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2));
}

BodyStatus body(const std::string& name) {
  BodyStatus body;
  body.name = name;
  const bool is_object = name == "cloth" || name == "cable";
  const bool is_rigid = name == "table" || name == "clamp";
  body.kind = is_object ? BodyKind::kDeformable : is_rigid ? BodyKind::kRigid : BodyKind::kLink;
  return body;
}

// "srdf: may touch", "parameters: looked at", in either order of the bodies.
std::string verdict(const ContactRules& rules, const std::string& a, const std::string& b) {
  const ContactVerdict one = rules.verdict(body(a), body(b)),
                       other = rules.verdict(body(b), body(a));
  EXPECT_EQ(one.allowed, other.allowed) << a << ", " << b;
  EXPECT_EQ(one.source, other.source) << a << ", " << b;
  return toString(one.source) + std::string(one.allowed ? ": may touch" : ": looked at");
}

Srdf srdf() {
  Srdf srdf;
  srdf.disabled = {{"arm", "hand", "Adjacent"}, {"hand", "cloth", "is no link"}};
  srdf.enabled = {{"arm", "hand", ""}, {"cable_drum", "arm", ""}};
  srdf.disabled_links = {"cable_drum"};
  return srdf;
}

const std::set<std::string> kLinks = {"arm", "hand", "finger", "cable_drum"};

TEST(ContactRules, WithoutARuleEverythingIsLookedAt) {
  EXPECT_EQ(verdict({}, "arm", "hand"), "default: looked at");
  EXPECT_EQ(verdict({}, "arm", "cloth"), "default: looked at");
}

TEST(ContactRules, AnSrdfSpeaksOfLinksAloneAndItsPairsBeatItsDefaults) {
  const ContactRules rules{{}, {}, {}, LinkRules({{"r", kLinks, srdf()}})};
  EXPECT_EQ(verdict(rules, "arm", "hand"), "srdf: may touch") << "disabled beats enabled";
  EXPECT_EQ(verdict(rules, "cable_drum", "hand"), "srdf: may touch") << "by default";
  EXPECT_EQ(verdict(rules, "cable_drum", "arm"), "default: looked at") << "enabled beats that";
  EXPECT_EQ(verdict(rules, "hand", "cloth"), "default: looked at");
  EXPECT_EQ(verdict(rules, "cable_drum", "cloth"), "default: looked at");
}

TEST(ContactRules, AnSrdfHoldsWithinItsRobot) {
  Srdf of_a;
  of_a.disabled = {{"a/arm", "a/hand", "Adjacent"}, {"a/arm", "b/hand", "of two robots"}};
  of_a.disabled_links = {"a/drum"};
  Srdf of_b;
  of_b.disabled_links = {"b/hand"};
  ContactRules rules;
  rules.links =
      LinkRules({{"r", {"a/arm", "a/hand", "a/drum"}, of_a}, {"r", {"b/arm", "b/hand"}, of_b}});
  EXPECT_EQ(verdict(rules, "a/arm", "a/hand"), "srdf: may touch");
  EXPECT_EQ(verdict(rules, "a/drum", "a/hand"), "srdf: may touch");
  EXPECT_EQ(verdict(rules, "b/arm", "b/hand"), "srdf: may touch");
  for (const char* other : {"b/arm", "b/hand"}) {
    EXPECT_EQ(verdict(rules, "a/drum", other), "default: looked at") << other;
    EXPECT_EQ(verdict(rules, "a/arm", other), "default: looked at") << other;
  }
  EXPECT_EQ(rules.links.count(), 4U);
}

// From the weakest rule to the strongest, each of which turns what the one before said.
TEST(ContactRules, EachKindBeatsTheWeakerOnes) {
  ContactRules rules{{}, {}, {}, LinkRules({{"r", kLinks, srdf()}})};
  rules.allowed.add(rule("*", "*", false));
  EXPECT_EQ(verdict(rules, "arm", "hand"), "parameters: looked at");
  rules.allowed.add(rule("hand", "*", true), RuleSource::kService);
  EXPECT_EQ(verdict(rules, "arm", "hand"), "service: may touch");
  rules.allowed.add(rule("hand", "arm", false));
  EXPECT_EQ(verdict(rules, "arm", "hand"), "parameters: looked at");

  rules.allowed.add(rule("hand", "*", false));
  EXPECT_EQ(verdict(rules, "hand", "cloth"), "parameters: looked at");
  rules.attached = {{"cloth", {{"finger", "hand"}}}};
  EXPECT_EQ(verdict(rules, "hand", "cloth"), "attached: may touch");
  EXPECT_EQ(verdict(rules, "finger", "cloth"), "attached: may touch");
  EXPECT_EQ(verdict(rules, "arm", "cloth"), "parameters: looked at") << "it does not hold it";
  EXPECT_EQ(verdict(rules, "hand", "cable"), "parameters: looked at") << "another object";
  rules.allowed.add(rule("cloth", "hand", false), RuleSource::kService);
  EXPECT_EQ(verdict(rules, "hand", "cloth"), "service: looked at");
  EXPECT_EQ(verdict(rules, "finger", "cloth"), "attached: may touch");
}

TEST(ContactRules, RigidObjectsHoldAndAreHeldAndAnSrdfMayNameThem) {
  Srdf names;
  names.disabled = {{"arm", "table", "it stands on it"}, {"table", "cloth", ""}};
  ContactRules rules{{}, {}, {}, LinkRules({{"r", {"arm", "hand"}, names}})};
  EXPECT_EQ(verdict(rules, "arm", "table"), "srdf: may touch");
  EXPECT_EQ(verdict(rules, "b/arm", "table"), "default: looked at") << "a link of no such robot";
  EXPECT_EQ(verdict(rules, "table", "cloth"), "default: looked at") << "the cloth deforms";
  rules.attached = {{"clamp", {{"hand"}}}, {"cloth", {{"clamp"}}}};
  EXPECT_EQ(verdict(rules, "hand", "clamp"), "attached: may touch");
  EXPECT_EQ(verdict(rules, "arm", "clamp"), "default: looked at");
  EXPECT_EQ(verdict(rules, "clamp", "cloth"), "attached: may touch");
  EXPECT_EQ(verdict(rules, "hand", "cloth"), "default: looked at") << "it holds only the clamp";
  EXPECT_EQ(verdict(rules, "clamp", "cable"), "default: looked at");
  rules.allowed.add(rule("table", "*"));
  EXPECT_EQ(verdict(rules, "cable", "table"), "parameters: may touch");
  rules.allowed.add(rule("clamp", "cloth", false));
  EXPECT_EQ(verdict(rules, "clamp", "cloth"), "parameters: looked at");
}

TEST(ContactRules, RulesAreCountedByWhoMadeThem) {
  AllowedContacts allowed;
  allowed.add(rule("arm", "cloth"));
  allowed.add(rule("hand", "cloth"));
  allowed.change({false, {}, {rule("cloth", "arm", false), rule("*", "cable")}});
  EXPECT_EQ(allowed.count(RuleSource::kParameters), 1U);
  EXPECT_EQ(allowed.count(RuleSource::kService), 2U);
  allowed.change({true, {}, {}});
  EXPECT_EQ(allowed.count(RuleSource::kParameters), 0U);
}

using Triple = std::tuple<BodyId, BodyId, bool>;

std::vector<BodyStatus> bodies() {
  std::vector<BodyStatus> bodies(4);
  bodies[0].name = "arm";
  bodies[1].name = "hand";
  bodies[2].name = "cloth";
  bodies[3].name = "cable";
  bodies[2].kind = bodies[3].kind = BodyKind::kDeformable;
  return bodies;
}

std::set<Triple> pairsOf(const PairClasses& classes, const AllowedContacts& allowed = {}) {
  std::set<Triple> pairs;
  for (const MonitoredPair& pair : monitoredPairs(bodies(), classes, {allowed, {}, {}, {}})) {
    EXPECT_TRUE(pairs.emplace(pair.a, pair.b, pair.allowed).second) << "pair twice";
  }
  return pairs;
}

TEST(PairTable, DefaultIsRobotWithDeformable) {
  EXPECT_EQ(pairsOf(PairClasses()),
            (std::set<Triple>{{0, 2, false}, {0, 3, false}, {1, 2, false}, {1, 3, false}}));
}

TEST(PairTable, EachClassAloneGivesItsPairs) {
  EXPECT_EQ(pairsOf({false, true, false, false}), (std::set<Triple>{{2, 3, false}}));
  EXPECT_EQ(pairsOf({false, false, true, false}), (std::set<Triple>{{2, 2, false}, {3, 3, false}}));
  EXPECT_EQ(pairsOf({false, false, false, true}), (std::set<Triple>{{0, 1, false}}));
  EXPECT_TRUE(pairsOf({false, false, false, false}).empty());
}

TEST(PairTable, RigidObjectsArePairedWithLinksAndWithWhatDeforms) {
  const std::vector<BodyStatus> bodies = {body("arm"), body("table"), body("clamp"), body("cloth")};
  const auto pairs = [&](const PairClasses& classes) {
    std::set<std::pair<BodyId, BodyId>> pairs;
    for (const MonitoredPair& pair : monitoredPairs(bodies, classes, {})) {
      pairs.emplace(pair.a, pair.b);
    }
    return pairs;
  };
  using Pairs = std::set<std::pair<BodyId, BodyId>>;
  EXPECT_EQ(pairs({true, true, true, true}), (Pairs{{0, 3}, {3, 3}}));
  EXPECT_EQ(pairs({false, false, false, false, true, false}), (Pairs{{1, 3}, {2, 3}}));
  EXPECT_EQ(pairs({false, false, false, false, false, true}), (Pairs{{0, 1}, {0, 2}}));
  EXPECT_EQ(namesOf({false, false, false, false, true, true}),
            (std::vector<std::string>{"deformable_rigid", "robot_rigid"}));
}

TEST(PairTable, PairsAreAscending) {
  const auto pairs = monitoredPairs(bodies(), {true, true, true, true}, {});
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    EXPECT_LT(std::make_pair(pairs[i - 1].a, pairs[i - 1].b),
              std::make_pair(pairs[i].a, pairs[i].b));
  }
  EXPECT_EQ(pairs.size(), 8U);
}

TEST(PairTable, OnlyClassesWithLinksNeedTheRobot) {
  EXPECT_TRUE(PairClasses({true, false, false, false}).needRobot());
  EXPECT_TRUE(PairClasses({false, false, false, true}).needRobot());
  EXPECT_TRUE(PairClasses({false, false, false, false, false, true}).needRobot());
  EXPECT_FALSE(PairClasses({false, true, true, false, true}).needRobot());
}

TEST(PairTable, AllowedPairsAreThereAndMarked) {
  AllowedContacts allowed;
  allowed.add(rule("arm", "*"));
  EXPECT_EQ(pairsOf(PairClasses(), allowed),
            (std::set<Triple>{{0, 2, true}, {0, 3, true}, {1, 2, false}, {1, 3, false}}));
}

}  // namespace
}  // namespace deformable_contact_monitor
