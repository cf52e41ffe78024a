// Tests which links may touch each other according to an SRDF. The SRDFs are small ones, a real
// one, and malformed or hostile ones.
#include "robot/srdf.h"

#include <algorithm>
#include <random>
#include <stdexcept>
#include <utility>

#include "refusal.h"
#include "robot_test_support.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

using Names = std::set<std::pair<std::string, std::string>>;

Names namesOf(const std::vector<Srdf::Pair>& pairs) {
  Names names;
  for (const Srdf::Pair& pair : pairs) names.insert(std::minmax(pair.a, pair.b));
  return names;
}

std::string robot(const std::string& content) {
  return "<robot name='r'>\n" + content + "\n</robot>";
}

TEST(Srdf, ItsRulesAreRead) {
  const Srdf srdf =
      readSrdf(robot("<group name='arm'><disable_collisions link1='inner' link2='one'/></group>"
                     "<disable_collisions link1='b' link2='a' reason='Adjacent'/>"
                     "<disable_collisions link2='d' link1='c'><more/></disable_collisions>"
                     "<enable_collisions link1='e' link2='a' reason='held on'/>"
                     "<disable_default_collisions link='e'/>"
                     "<virtual_joint/>"));
  EXPECT_EQ(srdf.robot, "r");
  ASSERT_EQ(namesOf(srdf.disabled), (Names{{"a", "b"}, {"c", "d"}}));
  EXPECT_EQ(srdf.disabled[0].reason, "Adjacent");
  EXPECT_EQ(srdf.disabled[1].reason, "");
  EXPECT_EQ(namesOf(srdf.enabled), (Names{{"a", "e"}}));
  EXPECT_EQ(srdf.disabled_links, std::set<std::string>{"e"});
}

TEST(Srdf, WithoutRulesIsOne) {
  const Srdf srdf = readSrdf("<robot name='r'/>");
  EXPECT_TRUE(srdf.disabled.empty() && srdf.enabled.empty() && srdf.disabled_links.empty());
}

TEST(Srdf, EveryDifferenceIsOne) {
  const std::string rule = "<disable_collisions link1='a' link2='b' reason='x'/>";
  const Srdf srdf = readSrdf(robot(rule));
  EXPECT_TRUE(srdf == readSrdf(robot(rule)));
  for (const char* other : {"<disable_collisions link1='a' link2='b'/>",
                            "<disable_collisions link1='a' link2='c' reason='x'/>",
                            "<enable_collisions link1='a' link2='b' reason='x'/>",
                            "<disable_default_collisions link='a'/>", ""}) {
    EXPECT_FALSE(srdf == readSrdf(robot(other))) << other;
  }
}

std::string refusalOf(const std::string& xml) {
  return refusal([&] { readSrdf(xml); });
}

TEST(Srdf, WhatIsMalformedIsNamedWithItsLine) {
  EXPECT_EQ(refusalOf(""), "SRDF: is empty");
  EXPECT_EQ(refusalOf("<robot name='r'>\n<group>").find("SRDF, line 2: not well-formed XML: "), 0U);
  EXPECT_EQ(refusalOf("no XML").find("SRDF, line 1: "), 0U);
  EXPECT_EQ(refusalOf("<root/>"), "SRDF, line 1: there is no element 'robot'");
  EXPECT_EQ(refusalOf("<robot/>"), "SRDF, line 1: robot without name");
  EXPECT_EQ(refusalOf(robot("<disable_collisions link1='a'/>")),
            "SRDF, line 2: disable_collisions without link2");
  EXPECT_EQ(refusalOf(robot("\n<enable_collisions link1='' link2='a'/>")),
            "SRDF, line 3: enable_collisions without link1");
  EXPECT_EQ(refusalOf(robot("<disable_default_collisions link1='a'/>")),
            "SRDF, line 2: disable_default_collisions without link");
  EXPECT_EQ(refusalOf(robot("<disable_collisions link1='a\x1b[1m' link2='b'/>")),
            "SRDF, line 2: a control character");
}

TEST(Srdf, SizeAndNumberHaveALimit) {
  std::string rules;
  for (std::size_t i = 0; i < kMostSrdfRules; ++i) {
    rules += "<disable_collisions link1='a' link2='b" + std::to_string(i) + "'/>\n";
  }
  EXPECT_EQ(readSrdf(robot(rules)).disabled.size(), kMostSrdfRules);
  EXPECT_EQ(refusalOf(robot(rules + "<disable_default_collisions link='a'/>")),
            "SRDF, line 100002: more than 100000 rules, which is the most");
  EXPECT_EQ(refusalOf(robot(std::string(kMaxSrdfBytes, ' '))), "SRDF: is larger than 16 MiB");
}

TEST(Srdf, DeepNestingIsRefused) {
  std::string open, close;
  for (int i = 0; i < 100000; ++i) {
    open += "<g>";
    close += "</g>";
  }
  EXPECT_NE(refusalOf(robot(open + close)).find("not well-formed XML"), std::string::npos);
}

// An answer or a refusal by name, whatever became of the bytes.
TEST(Srdf, DamagedTextIsReadOrRefused) {
  const std::string good = robot(
      "<disable_collisions link1='a' link2='b' reason='Never'/>\n<!-- note -->"
      "<enable_collisions link1='a' link2='c'/><disable_default_collisions link='&amp;d'/>");
  std::mt19937 random(7);
  std::size_t refused = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string text = good;
    for (int changes = static_cast<int>(random() % 4); changes >= 0; --changes) {
      text[random() % text.size()] = static_cast<char>(random() % 256);
    }
    const std::string problem = refusalOf(text);
    refused += problem.empty() ? 0 : 1;
    ASSERT_TRUE(problem.empty() || problem.find("SRDF") == 0) << problem;
  }
  EXPECT_GT(refused, 1000U);
}

TEST(Srdf, AFileIsNamed) {
  const TemporaryFolder folder;
  const std::string path = folder.write("r.srdf", robot("<disable_default_collisions link='a'/>"));
  EXPECT_EQ(readSrdfFile(path).disabled_links, std::set<std::string>{"a"});
  const std::string broken = folder.write("broken.srdf", "<robot/>");
  EXPECT_EQ(refusal([&] { readSrdfFile(broken); }), broken + ": SRDF, line 1: robot without name");
  for (const std::string& missing :
       {folder.path().string(), std::string("/dev/zero"), path + "x"}) {
    try {
      readSrdfFile(missing);
      ADD_FAILURE() << missing << " was read";
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(std::string(error.what()).find(missing + ": "), 0U) << error.what();
    }
  }
}

TEST(Srdf, NamesThatTheRobotLacksAreOneWarning) {
  const Srdf srdf = readSrdf(
      robot("<disable_collisions link1='arm' link2='hnad'/><disable_collisions link1='hnad' "
            "link2='hand'/><enable_collisions link1='arm' link2='tool'/>"
            "<disable_default_collisions link='zzzzzzzz'/>"));
  EXPECT_EQ(srdfWarnings(srdf, "r", {"arm", "hand"}),
            (std::vector<std::string>{"the SRDF names links that the robot lacks: 'hnad' (did you "
                                      "mean 'hand'?), 'tool', 'zzzzzzzz'"}));
  EXPECT_TRUE(srdfWarnings(srdf, "", {"arm", "hand", "hnad", "tool", "zzzzzzzz"}).empty());
  EXPECT_EQ(srdfWarnings(srdf, "s", {"arm", "hand", "hnad", "tool", "zzzzzzzz"}),
            std::vector<std::string>{"the SRDF is of robot 'r', but the robot is 's'"});
}

TEST(Srdf, OfManyNamesTheFirstAreListed) {
  Srdf srdf;
  for (int i = 100; i < 200; ++i) srdf.disabled_links.insert("missing" + std::to_string(i));
  const std::vector<std::string> lines = srdfWarnings(srdf, "", {"base"});
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_NE(lines[0].find("'missing119' and 80 more"), std::string::npos) << lines[0];
}

// By text search, as it were by eye.
Names pairsInText(const std::string& text) {
  Names names;
  const auto valueAfter = [&text](const std::string& key, std::size_t from) {
    const std::size_t first = text.find(key + "=\"", from) + key.size() + 2;
    return text.substr(first, text.find('"', first) - first);
  };
  const std::string element = "<disable_collisions ";
  for (std::size_t at = text.find(element); at != std::string::npos;
       at = text.find(element, at + 1)) {
    const std::string a = valueAfter("link1", at), b = valueAfter("link2", at);
    names.insert(std::minmax(a, b));
  }
  return names;
}

TEST(Srdf, ThePandasPairsAreTheFilesAndItsLinksAreKnown) {
  DCM_REQUIRE_TEST_DATA();
  const std::string folder = "robots/panda_description/urdf/";
  const std::string path = testDataFile(folder + "panda.srdf");
  const Srdf srdf = readSrdfFile(path);
  const Names pairs = pairsInText(readText(path));
  EXPECT_EQ(namesOf(srdf.disabled), pairs);
  EXPECT_EQ(pairs.count({"panda_hand", "panda_link7"}), 1U);
  const RobotGeometry robot =
      loadRobotGeometry(readText(testDataFile(folder + "panda.urdf")), {}, testDataResolver());
  EXPECT_EQ(robot.link_names.count("panda_link8"), 1U) << "it has no geometry, but is a link";
  EXPECT_TRUE(srdfWarnings(srdf, robot.robots.at(0).name, robot.link_names).empty());
}

}  // namespace
}  // namespace deformable_contact_monitor
