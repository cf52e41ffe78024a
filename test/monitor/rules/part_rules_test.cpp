// Tests the parameter `parts` and the rules that name parts.
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "monitor/diagnostics/robot_checks.h"
#include "monitor/rules/parameters.h"
#include "monitor/rules/rule_texts.h"
#include "refusal.h"

namespace deformable_contact_monitor {
namespace {

using XmlRpc::XmlRpcValue;

XmlRpcValue listOf(const std::vector<XmlRpcValue>& items) {
  XmlRpcValue list;
  list.setSize(static_cast<int>(items.size()));
  for (std::size_t i = 0; i < items.size(); ++i) list[static_cast<int>(i)] = items[i];
  return list;
}

XmlRpcValue range(int first, int last) { return listOf({first, last}); }

XmlRpcValue part(const std::string& name, const std::vector<XmlRpcValue>& ranges) {
  XmlRpcValue part;
  part["name"] = name;
  part["triangles"] = listOf(ranges);
  return part;
}

// The parameters of one object, "cloth", with these parts.
XmlRpcValue withParts(const std::vector<XmlRpcValue>& parts) {
  XmlRpcValue object, tree;
  object["name"] = "cloth";
  object["parts"] = listOf(parts);
  tree["objects"] = listOf({object});
  return tree;
}

MonitorParameters parse(const XmlRpcValue& tree) {
  std::vector<std::string> warnings;
  MonitorParameters p = parseParameters(tree, &warnings);
  EXPECT_TRUE(warnings.empty()) << warnings.front();
  return p;
}

std::string refusalOf(const XmlRpcValue& tree) {
  return refusal<ParameterError>([&tree] { parse(tree); });
}

using Ranges = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

TEST(PartParameters, RangesAreJoined) {
  const auto parts =
      parse(withParts({part("hem", {range(7, 9), range(0, 4), range(5, 5), range(8, 12)})}))
          .objects[0]
          .parts;
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_EQ(parts[0].name, "hem");
  EXPECT_EQ(parts[0].ranges, (Ranges{{0, 5}, {7, 12}}));
}

TEST(PartParameters, AFileHasOneIndexPerLine) {
  const std::string path = ::testing::TempDir() + "part_indices.txt";
  XmlRpcValue hem;
  hem["name"] = "hem";
  hem["indices_file"] = path;
  expectIn("~objects[0]/parts[0]/indices_file is '" + path + "': ", refusalOf(withParts({hem})));
  std::ofstream(path) << "5\r\n3\n\n4\n9\n";
  EXPECT_EQ(parse(withParts({hem})).objects[0].parts[0].ranges, (Ranges{{3, 5}, {9, 9}}));
  std::ofstream(path) << "5\n-3\n";
  expectIn("line 2 is '-3', must be the index of a triangle", refusalOf(withParts({hem})));
  std::ofstream(path) << "\n";
  expectIn("the file has no triangle", refusalOf(withParts({hem})));
  std::remove(path.c_str());
}

// The part `name` of a group; `file` may be empty.
XmlRpcValue groupPart(const std::string& name, const std::string& group, const std::string& file) {
  XmlRpcValue part;
  part["name"] = name;
  part["group"] = group;
  if (!file.empty()) part["group_file"] = file;
  return part;
}

TEST(PartParameters, AGroupOfAMeshFile) {
  const std::string path = ::testing::TempDir() + "part_groups.obj";
  std::ofstream(path) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\ng hem\nf 1 2 3\nf 2 1 3\ng logo\n"
                         "f 3 2 1\n";
  const auto parts = parse(withParts({groupPart("edge", "hem", path), part("rest", {range(0, 0)}),
                                      groupPart("logo", "logo", path)}))
                         .objects[0]
                         .parts;
  EXPECT_EQ(parts[0].ranges, (Ranges{{1, 2}}));
  EXPECT_EQ(parts[2].ranges, (Ranges{{3, 3}}));
  ASSERT_NE(parts[0].mesh, nullptr);
  EXPECT_EQ(parts[0].mesh->triangleCount(), 4U);
  EXPECT_EQ(parts[1].mesh, nullptr);
  EXPECT_EQ(parts[2].mesh, parts[0].mesh);
  XmlRpcValue cloud = withParts({groupPart("edge", "hem", "")});
  cloud["objects"][0]["type"] = "point_cloud";
  cloud["objects"][0]["faces"] = path;
  EXPECT_EQ(parse(cloud).objects[0].parts[0].ranges, (Ranges{{1, 2}}));
  expectIn(
      "~objects[0]/parts[0]/group_file is missing: it names the mesh file that has the group "
      "'hem'",
      refusalOf(withParts({groupPart("edge", "hem", "")})));
  expectIn("~objects[0]/parts cannot be groups of '" + path + "': " + path +
               ": has no group 'ham'; it has 'hem', 'logo'",
           refusalOf(withParts({groupPart("a", "hem", path), groupPart("b", "ham", path)})));
  expectIn("~objects[0]/parts 'a' and 'b' both have triangle 1",
           refusalOf(withParts({groupPart("a", "hem", path), groupPart("b", "hem", path)})));
  expectIn("~objects[0]/parts cannot be groups of '/nowhere.obj': ",
           refusalOf(withParts({groupPart("a", "hem", "/nowhere.obj")})));
  XmlRpcValue both = part("hem", {range(0, 0)});
  both["group"] = "hem";
  expectIn("group are the ways to make a part: give one", refusalOf(withParts({both})));
  std::remove(path.c_str());
}

TEST(PartParameters, ABoxHasTwoCorners) {
  XmlRpcValue hem;
  hem["name"] = "hem";
  hem["box"]["min"] = listOf({-1, 0.5, 0});
  hem["box"]["max"] = listOf({1, 0.5, 2.5});
  const auto box = parse(withParts({hem})).objects[0].parts[0].box;
  ASSERT_TRUE(box.has_value());
  EXPECT_EQ(box->min, (std::array<double, 3>{-1, 0.5, 0}));
  EXPECT_EQ(box->max, (std::array<double, 3>{1, 0.5, 2.5}));
  hem["box"]["min"] = listOf({-1, 0.75, 0});
  expectIn("~objects[0]/parts[0]/box/min is above max in axis y", refusalOf(withParts({hem})));
  hem["box"]["min"] = listOf({-1, 0.75});
  expectIn("~objects[0]/parts[0]/box/min must be three numbers", refusalOf(withParts({hem})));
}

TEST(PartParameters, TheNameOfWhatIsHeldIsTaken) {
  expectIn(
      "~objects[0]/parts[0]/name is 'held', which is the part that ~attach_object with a radius",
      refusalOf(withParts({part("held", {range(0, 0)})})));
}

TEST(PartParameters, NamesAreChecked) {
  const XmlRpcValue one = range(0, 0), two = range(1, 1);
  expectIn("parts[0]/name is 'a:b', must have no ':' and no '*'",
           refusalOf(withParts({part("a:b", {one})})));
  expectIn("parts[0]/name is '*', must have no ':' and no '*'",
           refusalOf(withParts({part("*", {one})})));
  expectIn("parts[1]/name is 'a', which is another part's name",
           refusalOf(withParts({part("a", {one}), part("a", {two})})));
  XmlRpcValue unnamed;
  unnamed["triangles"] = listOf({one});
  expectIn("parts[0]/name is missing", refusalOf(withParts({unnamed})));
  XmlRpcValue tree = withParts({part("hem", {one})}), other;
  other["name"] = "cloth:hem";
  other["topic"] = "other";
  tree["objects"] = listOf({tree["objects"][0], other});
  expectIn("have 'cloth:hem', which looks like a part of 'cloth'", refusalOf(tree));
}

TEST(PartParameters, APartOfALinksNameIsRefused) {
  const MonitorParameters p = parse(withParts({part("hem", {range(0, 0)})}));
  RobotGeometry robot;
  robot.links.push_back({"cloth:hem", "", TriangleMesh(), ""});
  EXPECT_THROW(checkRobot(robot, p), std::runtime_error);
  robot.links[0].link = "cloth:other";
  EXPECT_NO_THROW(checkRobot(robot, p));
}

TEST(PartParameters, OverlapsAreRefusedByName) {
  expectIn("~objects[0]/parts 'hem' and 'edge' both have triangle 7",
           refusalOf(withParts({part("edge", {range(7, 8)}), part("hem", {range(0, 7)})})));
}

TEST(PartParameters, OneWayToMakeAPart) {
  XmlRpcValue hem;
  hem["name"] = "hem";
  const std::string give_one =
      "parts[0]/triangles, indices_file, box and group are the ways to make a part: give one";
  expectIn(give_one, refusalOf(withParts({hem})));
  hem["triangles"] = listOf({range(0, 1)});
  hem["indices_file"] = "/nowhere";
  expectIn(give_one, refusalOf(withParts({hem})));
  expectIn("parts[0]/triangles[0] is 5, must be in [9, 2147483647]",
           refusalOf(withParts({part("hem", {range(9, 5)})})));
  expectIn("parts[0]/triangles has no range", refusalOf(withParts({part("hem", {})})));
  XmlRpcValue wide = part("hem", {range(0, 1)});
  wide["margin_m"] = 11;
  expectIn("parts[0]/margin_m is 11, must be in [0, 10]", refusalOf(withParts({wide})));
  wide["margin_m"] = 0.5;
  EXPECT_EQ(parse(withParts({wide})).objects[0].parts[0].margin_m, 0.5F);
  EXPECT_EQ(parse(withParts({part("hem", {range(0, 1)})})).objects[0].parts[0].margin_m,
            std::nullopt);
  std::vector<XmlRpcValue> many;
  for (int i = 0; i < 256; ++i) many.push_back(part("p" + std::to_string(i), {range(i, i)}));
  expectIn("~objects[0]/parts are 256, must be at most 255", refusalOf(withParts(many)));
  many.pop_back();
  EXPECT_EQ(parse(withParts(many)).objects[0].parts.size(), 255U);
}

TEST(PartParameters, WhatPartsDoNotWorkWithIsRefused) {
  XmlRpcValue tree = withParts({part("hem", {range(0, 1)})});
  tree["tolerance_m"] = 0.01;
  tree["containment"] = true;
  expectIn("~tolerance_m above 0 is not supported with parts, which 'cloth' has", refusalOf(tree));
  expectIn("~containment: true is not supported with parts, which 'cloth' has", refusalOf(tree));
}

AllowedContact rule(const std::string& a, const std::string& b, bool allowed) {
  AllowedContact rule;
  rule.body_a = a;
  rule.body_b = b;
  rule.allowed = allowed;
  return rule;
}

class PartRules : public ::testing::Test {
 protected:
  PartRules() {
    BodyParts parts;
    parts.names = {"hem", "seam"};
    cloth_.name = "cloth";
    cloth_.kind = BodyKind::kDeformable;
    cloth_.parts = std::make_shared<const BodyParts>(parts);
    hand_.name = "hand";
  }

  // The verdicts about the cloth's own rest, its hem and its seam: 1 is allowed.
  std::string verdicts() const {
    std::string text;
    for (const PartId part : {0, 1, 2}) {
      const bool allowed = rules_.verdict(hand_, cloth_, 0, part).allowed;
      EXPECT_EQ(rules_.verdict(cloth_, hand_, part, 0).allowed, allowed);
      text += allowed ? "1" : "0";
    }
    return text;
  }

  BodyStatus hand_, cloth_;
  ContactRules rules_;
};

// Each line of the table in config/README.md beats those below it, whatever comes last.
TEST_F(PartRules, TheTableOfPrecedence) {
  rules_.allowed.add(rule("*", "*", true));
  EXPECT_EQ(verdicts(), "111");
  rules_.allowed.add(rule("*", "cloth", false));
  EXPECT_EQ(verdicts(), "000");
  rules_.allowed.add(rule("cloth:*", "*", true));
  EXPECT_EQ(verdicts(), "011");
  rules_.allowed.add(rule("*", "cloth:hem", false));
  EXPECT_EQ(verdicts(), "001");
  rules_.allowed.add(rule("*", "cloth", false));
  EXPECT_EQ(verdicts(), "001");
  rules_.attached = {{"cloth", {{"hand"}}}};
  EXPECT_EQ(verdicts(), "111");
  rules_.allowed.add(rule("hand", "cloth", false));
  EXPECT_EQ(verdicts(), "000");
  rules_.allowed.add(rule("cloth:*", "hand", true));
  EXPECT_EQ(verdicts(), "011");
  rules_.allowed.add(rule("hand", "cloth:seam", false));
  EXPECT_EQ(verdicts(), "010");
  rules_.allowed.add(rule("hand", "cloth:*", true));
  rules_.allowed.add(rule("hand", "cloth", true));
  EXPECT_EQ(verdicts(), "110");
}

TEST_F(PartRules, BothSidesCount) {
  BodyStatus rug = cloth_;
  rug.name = "rug";
  rules_.allowed.add(rule("cloth:hem", "rug:*", true));
  rules_.allowed.add(rule("cloth:hem", "rug", false));
  EXPECT_TRUE(rules_.verdict(cloth_, rug, 1, 2).allowed);
  EXPECT_FALSE(rules_.verdict(cloth_, rug, 1, 0).allowed);
  rules_.allowed.add(rule("cloth:*", "rug:seam", false));
  EXPECT_FALSE(rules_.verdict(cloth_, rug, 1, 2).allowed) << "among equals, the last one";
  EXPECT_TRUE(rules_.verdict(cloth_, rug, 1, 1).allowed);
}

// Otherwise a pair whose parts are all allowed would seem to be apart.
TEST_F(PartRules, WherePartsCoverTheObjectTheyDecide) {
  rules_.allowed.add(rule("hand", "cloth:*", true));
  const PairClasses classes{true, false, false, false};
  const auto isAllowed = [&](const std::vector<std::size_t>& triangles, const char* problem) {
    BodyParts parts = *cloth_.parts;
    parts.triangles = triangles;
    parts.problem = problem;
    cloth_.parts = std::make_shared<const BodyParts>(parts);
    return monitoredPairs({hand_, cloth_}, classes, rules_).at(0).allowed;
  };
  EXPECT_TRUE(isAllowed({0, 3, 5}, ""));
  EXPECT_FALSE(isAllowed({1, 3, 5}, ""));
  EXPECT_FALSE(isAllowed({0, 3, 5}, "other triangles"));
  EXPECT_FALSE(isAllowed({0, 0, 0}, "")) << "before the first mesh";
}

TEST_F(PartRules, PairsOfPartsFollowFromThem) {
  const std::vector<BodyStatus> bodies = {hand_, cloth_};
  rules_.allowed.add(rule("hand", "cloth:hem", true));
  const PairClasses classes{true, false, true, false};
  const auto pairs = monitoredPairs(bodies, classes, rules_);
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_FALSE(pairs[0].allowed || pairs[1].allowed);
  std::string text;
  for (const MonitoredPair& pair : monitoredPartPairs(bodies, pairs, rules_)) {
    text += nameOf(bodies[pair.a], pair.part_a) + "/" + nameOf(bodies[pair.b], pair.part_b) +
            (pair.allowed ? " allowed, " : ", ");
  }
  EXPECT_EQ(text, "hand/cloth:hem allowed, hand/cloth:seam, cloth/cloth:hem, cloth/cloth:seam, ");
  EXPECT_EQ(allowedParts(bodies, pairs, rules_), (std::vector<PartPair>{{0, 1, 0, 1}}));
  rules_.allowed.add(rule("hand", "cloth", true));
  rules_.allowed.add(rule("hand", "cloth:*", true));
  EXPECT_TRUE(monitoredPairs(bodies, classes, rules_)[0].allowed);
}

TEST_F(PartRules, InWords) {
  const std::vector<BodyStatus> bodies = {hand_, cloth_};
  Scene scene;
  for (const BodyStatus& body : bodies) scene.addBody(body.name, TriangleMesh());
  rules_.allowed.add(rule("hand", "cloth:hem", true));
  const auto pairs = monitoredPairs(bodies, PairClasses(), rules_);
  const RulesInForce in_force =
      describeRules(bodies, pairs, rules_, scene, monitoredPartPairs(bodies, pairs, rules_));
  EXPECT_EQ(in_force.allowedPairs(), 0U);
  EXPECT_EQ(in_force.bodies[0].second, "margin 0 m, may touch cloth:hem (parameters)");
  EXPECT_EQ(in_force.bodies[1].second, "margin 0 m, may touch hand with hem (parameters)");
  BodyParts parts = *cloth_.parts;
  parts.margins_m = {{1, 0.5F}, {2, 0.25F}};
  cloth_.parts = std::make_shared<const BodyParts>(parts);
  EXPECT_EQ(describeRules({hand_, cloth_}, {}, rules_, scene, {}).bodies[1].second,
            "margin 0 m (hem 0.5 m, seam 0.25 m)");
}

TEST_F(PartRules, UnknownPartsAreNamed) {
  AllowedContacts allowed;
  for (const char* name : {"cloth:hem", "cloth:*", "cloth:hen", "hand:*"}) {
    allowed.add(rule("hand", name, true));
  }
  EXPECT_EQ(
      describeUnknownNames({}, allowed, {hand_, cloth_}),
      (std::vector<std::string>{
          "allowed contacts name 'cloth:hen' (did you mean 'cloth:hem'?), which is no link "
          "or object",
          "allowed contacts name 'hand:*' (did you mean 'hand'?), which is no link or object"}));
}

}  // namespace
}  // namespace deformable_contact_monitor
