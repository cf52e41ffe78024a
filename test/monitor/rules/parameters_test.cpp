// Tests the defaults and values of parameters, and that all bad ones are listed together.
#include "monitor/rules/parameters.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "parameter_trees.h"

namespace deformable_contact_monitor {
namespace {

TEST(Parameters, NothingSetGivesTheDefaults) {
  const MonitorParameters p = parse(XmlRpcValue());
  EXPECT_EQ(p.reference_frame, "base_link");
  EXPECT_EQ(p.robot_source, RobotSourceKind::kUrdf);
  EXPECT_EQ(p.srdf, kSrdfAuto);
  EXPECT_EQ(p.geometry.kind, GeometryKind::kCollision);
  EXPECT_TRUE(p.pair_classes.robot_deformable);
  EXPECT_FALSE(p.pair_classes.deformable_self);
  EXPECT_EQ(p.detector.overlap, 1.0F);
  EXPECT_FALSE(p.detector.geometry);
  EXPECT_FALSE(p.detector.near_pairs);
  EXPECT_EQ(p.detector.predicates, Predicates::kExact);
  EXPECT_EQ(p.detector.adjacent, AdjacentPairs::kBeyondShared);
  EXPECT_EQ(p.backend, BackendChoice::kAuto);
  EXPECT_EQ(p.max_rate_hz, 100);
  EXPECT_FALSE(p.containment);
  EXPECT_TRUE(p.objects.empty());
}

// PyYAML, and so rosparam, reads these numbers as texts.
TEST(Parameters, ANumberWithAnExponentMayBeAText) {
  XmlRpcValue tree, cable = object("cable"), margins;
  for (const auto& [text, number] : std::vector<std::pair<const char*, float>>{
           {"1e-3", 1e-3F}, {"1E0", 1}, {"+.5e1", 5}, {"2.e-1", 0.2F}, {"0.01e+2", 1}}) {
    tree["margin_m"] = cable["margin_m"] = margins["hand"] = text;
    tree["objects"] = list(cable);
    tree["link_margin_m"] = margins;
    const MonitorParameters p = parse(tree);
    EXPECT_EQ(p.margin_m, number) << text;
    EXPECT_EQ(p.objects[0].margin_m, number) << text;
    EXPECT_EQ(static_cast<float>(p.link_margin_m.at("hand")), number) << text;
  }
  for (const char* text : {"1", "0.5", "e3", "1e", "1e-3m", " 1e-3", "0x1e3", "1e-3\n", "."}) {
    tree["margin_m"] = text;
    expectIn("must be a number", refusalOf(tree));
  }
  for (const char* text : {"-1e-3", "1e999", "2e1"}) {
    tree["margin_m"] = text;
    expectIn("must be in [0, 10]", refusalOf(tree));
  }
}

// Controllers read margins from the parameter server, and know numbers only.
TEST(Parameters, MarginsThatAreTextsBecomeNumbers) {
  XmlRpcValue tree;
  EXPECT_EQ(writeMarginsAsNumbers(&tree), std::vector<std::string>());
  XmlRpcValue rope = object("1e3"), cable = object("cable"), margins;
  rope["margin_m"] = "2e-3";
  cable["margin_m"] = 0.25;
  margins["hand"] = "1e-1";
  margins["arm"] = 2;
  tree["objects"] = list(cable, object("cloth"));
  EXPECT_EQ(writeMarginsAsNumbers(&tree), std::vector<std::string>());
  tree["objects"] = list(cable, rope);
  EXPECT_EQ(writeMarginsAsNumbers(&tree), std::vector<std::string>{"objects"});
  EXPECT_EQ(static_cast<double>(tree["objects"][1]["margin_m"]), 0.002);
  EXPECT_EQ(static_cast<std::string>(tree["objects"][1]["name"]), "1e3");
  EXPECT_EQ(static_cast<double>(tree["objects"][0]["margin_m"]), 0.25);
  tree["link_margin_m"] = margins;
  EXPECT_EQ(writeMarginsAsNumbers(&tree), std::vector<std::string>{"link_margin_m"});
  EXPECT_EQ(static_cast<double>(tree["link_margin_m"]["hand"]), 0.1);
  EXPECT_EQ(static_cast<int>(tree["link_margin_m"]["arm"]), 2);
}

TEST(Parameters, ARadiusGoesWithExactStatesOfOneMoment) {
  XmlRpcValue tree, rope = object("rope");
  rope["radius_m"] = 0.004;
  tree["objects"] = list(rope, object("cloth"));
  EXPECT_EQ(parse(tree).objects[0].radius_m, 0.004F);
  EXPECT_EQ(parse(tree).objects[1].radius_m, 0.0F);
  tree["tolerance_m"] = 0.01;
  expectIn("~tolerance_m above 0 is not supported with radius_m, which 'rope' has above 0",
           refusalOf(tree));
  tree["tolerance_m"] = 0.0;
  tree["motion"] = "swept";
  expectIn("~motion: swept is not supported with radius_m, which 'rope' has above 0",
           refusalOf(tree));
  tree["motion"] = "instant";
  for (const double radius_m : {-0.001, 1.001}) {
    tree["objects"][0]["radius_m"] = radius_m;
    expectIn("radius_m", refusalOf(tree));
  }
}

TEST(Parameters, FramePrefix) {
  XmlRpcValue tree;
  EXPECT_EQ(parse(tree).frameOf("hand"), "hand");
  tree["frame_prefix"] = "";
  EXPECT_EQ(parse(tree).frameOf("hand"), "hand");
  tree["frame_prefix"] = "left/";
  EXPECT_EQ(parse(tree).frameOf("hand"), "left/hand");
  tree["frame_prefix"] = "/left/";
  expectIn("~frame_prefix is '/left/', must not begin with '/'", refusalOf(tree));
  tree["frame_prefix"] = 7;
  expectIn("~frame_prefix is 7, must be text", refusalOf(tree));
}

// The parameter server divides names at their slashes.
TEST(Parameters, MarginsOfLinksWithAPrefix) {
  XmlRpcValue tree;
  tree["link_margin_m"]["left"]["arm"]["hand"] = "1e-3";
  tree["link_margin_m"]["left"]["hand"] = 0.5;
  tree["link_margin_m"]["right/hand"] = 0.25;
  EXPECT_EQ(parse(tree).link_margin_m,
            (std::map<std::string, double>{
                {"left/arm/hand", 1e-3}, {"left/hand", 0.5}, {"right/hand", 0.25}}));
  EXPECT_EQ(writeMarginsAsNumbers(&tree), std::vector<std::string>{"link_margin_m"});
  EXPECT_EQ(static_cast<double>(tree["link_margin_m"]["left"]["arm"]["hand"]), 1e-3);
  tree["link_margin_m"]["left"]["hand"] = -1;
  expectIn("~link_margin_m/left/hand is -1", refusalOf(tree));
}

TEST(Parameters, RobotsAreAListOrOne) {
  XmlRpcValue tree, left, right;
  tree["robot_description"] = "arm";
  ASSERT_EQ(parse(tree).allRobots().size(), 1U);
  EXPECT_EQ(parse(tree).allRobots()[0].description, "arm");
  tree["frame_prefix"] = "left/";
  EXPECT_EQ(parse(tree).allRobots()[0].link_prefix, "") << "a single robot's links have no prefix";
  left["description"] = right["description"] = "arm";
  left["frame_prefix"] = "left/";
  right["srdf"] = "none";
  tree["robots"] = list(left, right);
  expectIn("~robot_description is 'arm', which has no place beside robots", refusalOf(tree));
  expectIn("~frame_prefix is 'left/', which has no place beside robots", refusalOf(tree));
  tree["robot_description"] = "robot_description";  // as in config/contact_monitor.yaml
  tree["frame_prefix"] = "";
  tree["srdf"] = "/robot.srdf";
  expectIn("~srdf is '/robot.srdf', which has no place beside robots", refusalOf(tree));
  tree["srdf"] = "auto";
  const MonitorParameters p = parse(tree);
  ASSERT_EQ(p.allRobots().size(), 2U);
  EXPECT_EQ(p.allRobots()[0].link_prefix, "left/");
  EXPECT_EQ(p.allRobots()[0].srdf, kSrdfAuto);
  EXPECT_EQ(p.allRobots()[1].link_prefix, "");
  EXPECT_EQ(p.allRobots()[1].srdf, kSrdfNone);
  EXPECT_EQ(p.frameOf("left/hand"), "left/hand") << "the names have the prefix already";
  tree["robots"][0]["frame_prefix"] = "/left";
  expectIn("~robots[0]/frame_prefix is '/left', must not begin with '/'", refusalOf(tree));
  tree["robots"][1] = XmlRpcValue();
  tree["robots"][1]["srdf"] = "none";
  expectIn("~robots[1]/description is missing", refusalOf(tree));
}

TEST(Parameters, ObjectsHaveTopicsOfTheirOwn) {
  const std::vector<ObjectParameters> objects = {{"cloth", "/a"}, {"b", "/b"}, {"c", "a"}};
  EXPECT_NO_THROW(requireOwnTopics(objects, [](const auto& object) { return object.topic; }));
  try {
    requireOwnTopics(objects, [](const auto& object) {
      return "/" + object.topic.substr(object.topic.size() - 1);
    });
    ADD_FAILURE() << "was not refused";
  } catch (const ParameterError& error) {
    expectIn("objects 'cloth' and 'c' have one topic, /a", error.what());
  }
}

TEST(Parameters, ToleranceAndBudget) {
  EXPECT_FALSE(tradesAccuracy(parse(XmlRpcValue())));
  XmlRpcValue tree;
  tree["tolerance_m"] = 0.005;
  MonitorParameters p = parse(tree);
  EXPECT_EQ(p.detector.tolerance_m, 0.005F);
  EXPECT_EQ(p.budget_ms, 0);
  EXPECT_TRUE(tradesAccuracy(p));
  tree["tolerance_m"] = 0.0;
  tree["budget_ms"] = 20;
  p = parse(tree);
  EXPECT_EQ(p.budget_ms, 20);
  EXPECT_TRUE(tradesAccuracy(p));
  tree["tolerance_m"] = 1.5;
  tree["budget_ms"] = -1;
  const std::string problems = refusalOf(tree);
  expectIn("~tolerance_m is 1.5, must be in [0, 1]", problems);
  expectIn("~budget_ms is -1, must be in [0, 60000]", problems);
  XmlRpcValue swept;
  swept["motion"] = "swept";
  swept["tolerance_m"] = 0.005;
  expectIn("~tolerance_m is above 0, which is not supported with motion: swept", refusalOf(swept));
}

// Each by its name and value, in the order of the configuration file's parts.
TEST(Parameters, WhatIsNotAtItsDefaultIsListed) {
  EXPECT_TRUE(parse(XmlRpcValue()).changed.empty());
  XmlRpcValue tree, none;
  none.begin();  // an empty map
  tree["reference_frame"] = "base_link";
  tree["margin_m"] = 0;
  tree["link_margin_m"] = none;
  tree["objects"] = list();
  tree["pair_classes"] = list("robot_deformable");
  tree["overlap"] = 1.0;
  tree["swept_tolerance_m"] = 1e-4;
  tree["containment"] = false;
  tree["max_contacts"] = 0;
  EXPECT_TRUE(parse(tree).changed.empty()) << parse(tree).changed.front();
  tree["margin_m"] = 0.25;
  tree["link_margin_m"]["hand"] = 0.5;
  tree["geometry"] = "visual";
  tree["objects"] = list(object(std::string(1000, 'c')));
  tree["max_contacts"] = 7;
  tree["containment"] = true;
  const std::vector<std::string> changed = parse(tree).changed;
  ASSERT_EQ(changed.size(), 6U);
  EXPECT_EQ(changed[0], "geometry: visual");
  EXPECT_EQ(changed[1], "margin_m: 0.25");
  EXPECT_EQ(changed[2], "link_margin_m: {hand:0.5}");
  EXPECT_EQ(changed[3].substr(0, 18), "objects: [{name:cc");
  EXPECT_LT(changed[3].size(), 120U);
  EXPECT_EQ(changed[4], "containment: true");
  EXPECT_EQ(changed[5], "max_contacts: 7");
}

TEST(Parameters, ValuesArrive) {
  XmlRpcValue tree, cable = object("cable"), rule, margins;
  cable["topic"] = "/camera/cable";
  cable["margin_m"] = 0.25;
  cable["required"] = false;
  margins["hand"] = 0.5;
  rule["body_a"] = "hand";
  rule["body_b"] = "*";
  tree["objects"] = list(object("cloth"), cable);
  tree["allowed_contacts"] = list(rule);
  tree["link_margin_m"] = margins;
  tree["margin_m"] = 1;  // a whole number is a number
  tree["pair_classes"] = list("deformable_self", "robot_self");
  tree["robot_source"] = "topic";
  tree["srdf"] = "/robot.srdf";
  tree["geometry"] = "visual";
  tree["backend"] = "cpu";
  tree["device"] = 2;
  tree["devices"] = list(0, 3);
  tree["memory_limit_mib"] = 8192;
  tree["max_mesh_mib"] = 4095;
  tree["predicates"] = "conservative";
  tree["adjacent_pairs"] = "skip";
  tree["links"] = list("hand", "arm");
  tree["max_contacts"] = 7;
  tree["contact_geometry"] = true;
  tree["containment"] = true;
  const MonitorParameters p = parse(tree);
  ASSERT_EQ(p.objects.size(), 2U);
  EXPECT_EQ(p.objects[0].margin_m, 1.0F) << "an object without a margin has the general one";
  EXPECT_TRUE(p.objects[0].required);
  EXPECT_EQ(p.objects[1].topic, "/camera/cable");
  EXPECT_TRUE(p.objects[0].shares_margin);
  EXPECT_EQ(p.objects[1].margin_m, 0.25F);
  EXPECT_FALSE(p.objects[1].shares_margin);
  EXPECT_EQ(p.srdf, "/robot.srdf");
  EXPECT_FALSE(p.objects[1].required);
  EXPECT_TRUE(p.allowed_contacts.allows("hand", "cloth"));
  EXPECT_EQ(p.link_margin_m.at("hand"), 0.5);
  EXPECT_FALSE(p.pair_classes.robot_deformable);
  EXPECT_TRUE(p.pair_classes.deformable_self && p.pair_classes.robot_self);
  EXPECT_EQ(p.robot_source, RobotSourceKind::kTopic);
  EXPECT_EQ(p.geometry.kind, GeometryKind::kVisual);
  EXPECT_EQ(p.geometry.links, (std::vector<std::string>{"hand", "arm"}));
  EXPECT_EQ(p.backend, BackendChoice::kCpu);
  EXPECT_EQ(p.cuda.device, 2);
  EXPECT_EQ(p.cuda.devices, (std::vector<int>{0, 3}));
  EXPECT_EQ(p.cuda.memory_limit_bytes, std::uint64_t{8192} << 20);
  EXPECT_EQ(p.max_mesh_bytes, std::size_t{4095} << 20);
  EXPECT_EQ(p.detector.predicates, Predicates::kConservative);
  EXPECT_EQ(p.detector.adjacent, AdjacentPairs::kSkip);
  EXPECT_EQ(p.max_contacts, 7U);
  EXPECT_TRUE(p.containment);
  EXPECT_TRUE(p.detector.geometry);
}

TEST(Parameters, Motion) {
  XmlRpcValue tree;
  tree["objects"] = list(object("cloth"));
  EXPECT_EQ(parse(tree).motion, Motion::kInstant);
  EXPECT_EQ(parse(tree).swept_tolerance_m, 1e-4);
  tree["motion"] = "swept";
  tree["swept_tolerance_m"] = 0;
  EXPECT_EQ(parse(tree).motion, Motion::kSwept);
  EXPECT_EQ(parse(tree).swept_tolerance_m, 0);
  EXPECT_EQ(parse(tree).detector.motion, Motion::kInstant) << "a cycle looks at its stamp first";
  tree["motion"] = "continuous";
  tree["swept_tolerance_m"] = -1e-4;
  const std::string all = refusalOf(tree);
  expectIn("~motion is 'continuous', must be one of: instant, swept", all);
  expectIn("~swept_tolerance_m", all);
}

TEST(Parameters, AllProblemsAreListedTogether) {
  XmlRpcValue tree;
  tree["max_rate_hz"] = -1;
  tree["tf_timeout_s"] = std::numeric_limits<double>::quiet_NaN();
  tree["max_mesh_age_s"] = std::numeric_limits<double>::infinity();
  tree["backend"] = "gpu";
  tree["device"] = -1;
  tree["devices"] = list(0, 1024, "first");
  tree["memory_limit_mib"] = 0;
  tree["max_mesh_mib"] = 4096;
  tree["predicates"] = "fast";
  tree["overlap"] = 1.5;
  tree["iterations"] = 101;
  tree["debounce_on_cycles"] = 0;
  tree["strict_geometry"] = "yes";
  tree["links"] = "hand arm";
  tree["reference_frame"] = "/base";
  tree["pair_classes"] = list("robot_cloth");
  tree["objects"] =
      list(object("cloth"), object("cloth"), object("*"), object("a b"), XmlRpcValue(3));
  const std::string all = refusalOf(tree);
  for (const char* name : {"~max_rate_hz is -1",
                           "~tf_timeout_s is nan",
                           "~max_mesh_age_s is inf",
                           "~backend is 'gpu', must be one of: auto, cuda, cpu",
                           "~predicates is 'fast', must be one of: exact, conservative",
                           "~overlap is 1.5",
                           "~device is -1",
                           "~devices[1] is 1024",
                           "~devices[2] is first",
                           "~memory_limit_mib is 0",
                           "~max_mesh_mib is 4096",
                           "~iterations is 101",
                           "~debounce_on_cycles is 0",
                           "~strict_geometry",
                           "~links",
                           "~reference_frame is '/base'",
                           "robot_cloth",
                           "~objects[1]/name is 'cloth'",
                           "~objects[2]/name is '*'",
                           "~objects[3]/topic",
                           "~objects[4]/ must be a map"}) {
    expectIn(name, all);
  }
}

TEST(Parameters, EndsOfRangesAreIn) {
  XmlRpcValue tree;
  tree["overlap"] = 0;
  tree["tf_timeout_s"] = 1;
  tree["max_rate_hz"] = 0;
  tree["clusters"] = kMaxClusters;
  tree["max_marker_triangles"] = 5000000;
  EXPECT_NO_THROW(parse(tree));
  tree["clusters"] = kMaxClusters + 1;
  tree["max_marker_triangles"] = 5000001;
  expectIn("clusters is 65536", refusalOf(tree));
  expectIn("max_marker_triangles is 5000001", refusalOf(tree));
}

TEST(Parameters, UnknownNamesAreWarningsAtEveryLevel) {
  XmlRpcValue tree, cloth = object("cloth");
  cloth["margin"] = 0.1;
  tree["objects"] = list(cloth);
  tree["max_rate"] = 10;
  std::vector<std::string> warnings;
  parse(tree, &warnings);
  ASSERT_EQ(warnings.size(), 2U);
  expectIn("~objects[0]/margin ", warnings[0] + warnings[1]);
  expectIn("~objects[0]/margin (did you mean 'margin_m'?)", warnings[0] + warnings[1]);
  expectIn("~max_rate (did you mean 'max_rate_hz'?)", warnings[0] + warnings[1]);
  tree["max_rate_hz"] = -1;
  const std::string all = refusalOf(tree);
  for (const char* name : {"~max_rate_hz is -1", "~objects[0]/margin ", "~max_rate "}) {
    expectIn(name, all);
  }
}

TEST(Parameters, WhatDynamicReconfigureLeftThereIsNoNewsUnlessItDiffers) {
  XmlRpcValue tree;
  tree["robot_deformable"] = true;
  tree["robot_self"] = false;
  std::vector<std::string> warnings;
  parse(tree, &warnings);
  EXPECT_TRUE(warnings.empty());
  tree["pair_classes"] = list("deformable_self");
  tree["deformable_self"] = true;
  const MonitorParameters p = parse(tree, &warnings);
  EXPECT_TRUE(p.pair_classes == (PairClasses{false, false, true, false}));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0], "~robot_deformable has no effect at start, where ~pair_classes decides");
}

TEST(Parameters, ATreeThatIsNoMapIsRefused) {
  expectIn("must be a map", refusalOf(XmlRpcValue(1)));
}

}  // namespace
}  // namespace deformable_contact_monitor
