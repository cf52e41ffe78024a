// Tests of reader/contact_reader.h, by the table of cases that the Python module is tested by, too.
#include "reader/contact_reader.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "reader/rival_monitors.h"

namespace deformable_contact_monitor {
namespace {

using Json = nlohmann::json;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Json table(const char* name) {
  std::ifstream file(CASES);
  return Json::parse(file).at(name);
}

double numberOf(const Json& value) {
  if (!value.is_string()) return value.get<double>();
  return value == "inf" ? kInfinity : kNaN;
}

geometry_msgs::Point32 pointOf(const Json& given) {
  geometry_msgs::Point32 point;
  point.x = given.at(0);
  point.y = given.at(1);
  point.z = given.at(2);
  return point;
}

ContactState stateOf(const Json& given, const ContactStates& message) {
  static const std::map<std::string, std::uint8_t> states = {
      {"NONE", ContactState::NONE},       {"NEAR", ContactState::NEAR},
      {"CONTACT", ContactState::CONTACT}, {"ALLOWED", ContactState::ALLOWED},
      {"UNKNOWN", ContactState::UNKNOWN}, {"PASSED", ContactState::PASSED}};
  const Json& name = given.at("is");
  ContactState state;
  state.state = name.is_string() ? states.at(name) : name.get<std::uint8_t>();
  const std::string pair = given.at("pair");
  state.body_a = pair.substr(0, pair.find(' '));
  state.body_b = pair.substr(pair.find(' ') + 1);
  state.stamp =
      given.contains("stamp") ? ros::Time(given["stamp"].get<double>()) : message.header.stamp;
  const double usual = name == "NONE"                          ? kInfinity
                       : name == "CONTACT" || name == "PASSED" ? 0
                                                               : kNaN;
  state.min_separation = static_cast<float>(given.contains("m") ? numberOf(given["m"]) : usual);
  state.distance_low = static_cast<float>(given.contains("low") ? numberOf(given["low"]) : 0);
  state.reason = given.value("why", "");
  if (given.contains("a")) state.point_a = pointOf(given["a"]);
  if (given.contains("b")) state.point_b = pointOf(given["b"]);
  if (given.contains("n")) state.normal = pointOf(given["n"]);
  return state;
}

ReaderRules rulesOf(const Json& given) {
  ReaderRules rules;
  rules.max_age_s = given.value("max_age_s", rules.max_age_s);
  rules.clearance_m = given.value("clearance_m", rules.clearance_m);
  rules.unlisted_may_move = given.value("unlisted_may_move", rules.unlisted_may_move);
  return rules;
}

// Returns parameters as the parameter server returns them.
XmlRpc::XmlRpcValue treeOf(const Json& given) {
  XmlRpc::XmlRpcValue tree;
  if (given.is_object()) {
    tree.begin();  // makes it a map, which may be empty
    for (const auto& [name, value] : given.items()) tree[name] = treeOf(value);
  } else if (given.is_array()) {
    tree.setSize(static_cast<int>(given.size()));
    for (std::size_t i = 0; i < given.size(); ++i) tree[static_cast<int>(i)] = treeOf(given[i]);
  } else if (given.is_number_integer()) {
    tree = given.get<int>();
  } else if (given.is_number()) {
    tree = given.get<double>();
  } else {
    tree = given.get<std::string>();
  }
  return tree;
}

// Compares with the bodies, the points and the normal that are expected, as far as there are any.
void expectNearest(const NearestAnswer& answer, const Json& expected) {
  EXPECT_EQ(answer.body, expected.empty() ? "" : expected[0].get<std::string>());
  EXPECT_EQ(answer.other, expected.empty() ? "" : expected[1].get<std::string>());
  EXPECT_EQ(answer.has_points, expected.size() > 2);
  const Json zero = {0, 0, 0};
  EXPECT_EQ(answer.point, pointOf(answer.has_points ? expected[2] : zero));
  EXPECT_EQ(answer.other_point, pointOf(answer.has_points ? expected[3] : zero));
  EXPECT_EQ(answer.normal, pointOf(answer.has_points ? expected[4] : zero));
}

void expectAnswers(const ContactReader& reader, const Json& step) {
  const ros::Time now(step.at("now").get<double>());
  const std::string body = step.at("body");
  const MoveAnswer answer = reader.mayMove(body, now);
  EXPECT_EQ(answer.because, step.at("because").get<std::string>());
  EXPECT_EQ(static_cast<bool>(answer), step.at("because").get<std::string>().empty());
  const NearestAnswer nearest = reader.nearest(body, now);
  EXPECT_EQ(nearest.distance_m, numberOf(step.at("nearest")));
  EXPECT_EQ(nearest.is_known, nearest.because.empty());
  EXPECT_TRUE(nearest.is_known || nearest.because == answer.because);
  if (step.contains("at")) expectNearest(nearest, step["at"]);
  std::vector<std::string> pairs;
  for (const ContactState& state : reader.contacts(body, now)) {
    pairs.push_back(state.body_a + " " + state.body_b);
  }
  EXPECT_EQ(pairs, step.at("contacts").get<std::vector<std::string>>());
  if (!step.contains("text")) return;
  std::optional<MonitorMargins> margins;
  if (step.contains("monitor")) margins = marginsOf(treeOf(step["monitor"]));
  EXPECT_EQ(reader.nearestText(body, now, margins), step["text"].get<std::string>());
}

TEST(ContactReaderTest, answersAsTheTableSays) {
  const Json all = table("cases");
  ASSERT_GT(all.size(), 30U);
  for (const Json& one : all) {
    ContactReader reader(rulesOf(one.value("rules", Json::object())));
    std::uint64_t cycle = 0;
    for (const Json& step : one.at("steps")) {
      SCOPED_TRACE(one.at("name").get<std::string>() + ": " + step.dump());
      if (step.contains("forget")) {
        reader.forget(step["forget"]);
      } else if (step.contains("store")) {
        cycle = step.value("cycle", cycle + 1);
        ContactStates message;
        message.cycle = cycle;
        message.tolerance = step.value("tolerance", 0.0F);
        message.header.stamp = ros::Time(step.value("stamp", step.at("now").get<double>()));
        for (const Json& given : step["store"]) message.states.push_back(stateOf(given, message));
        reader.store(message, ros::Time(step.at("now").get<double>()));
      } else {
        expectAnswers(reader, step);
      }
    }
  }
}

TEST(ContactReaderTest, distancesAreCertainAsTheTableSays) {
  for (const Json& given : table("distances")) {
    const double tolerance_m = numberOf(given.value("tolerance", Json(0.0)));
    const double distance = certainDistance(stateOf(given, {}), tolerance_m);
    EXPECT_EQ(distance, numberOf(given.at("distance"))) << given.dump();
  }
}

TEST(RivalMonitors, oneThatIsStartedAgainIsNone) {
  RivalMonitors rivals("/states");
  const RivalMonitors::Time start;
  const auto at = [&](int ms) { return start + std::chrono::milliseconds(ms); };
  EXPECT_EQ(rivals.look("/a", at(0)), "");
  EXPECT_EQ(rivals.look("/a", at(9000)), "") << "after a silence, under the same name";
  const std::string both = "two nodes publish /states: /a and /b; stop one of them";
  EXPECT_EQ(rivals.look("/b", at(9100)), both);
  EXPECT_EQ(rivals.look("/a", at(9200)), both);
  EXPECT_EQ(rivals.look("/b", at(11200)), both);
  EXPECT_EQ(rivals.look("/b", at(11201)), "") << "/a is gone";
}

TEST(ContactReaderTest, badRulesAreRefused) {
  for (const double max_age_s : {0.0, -1.0, kNaN}) {
    EXPECT_THROW(ContactReader({max_age_s, 0, false}), std::invalid_argument);
  }
  for (const double clearance_m : {-1.0, kNaN}) {
    EXPECT_THROW(ContactReader({1, clearance_m, false}), std::invalid_argument);
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
