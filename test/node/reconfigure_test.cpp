// Tests that dynamic_reconfigure offers and accepts the values and ranges of the parameters.
#include "node/reconfigure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "monitor/rules/parameters.h"

namespace deformable_contact_monitor {
namespace {

using Config = ContactMonitorConfig;
using Strings = std::vector<std::string>;

LiveParameters unusual() {
  LiveParameters live;
  live.margin_m = 0.5;
  live.near_pairs = true;
  live.max_rate_hz = 7;
  live.robot_rate_hz = 8;
  live.marker_rate_hz = 9;
  live.pair_classes = {false, true, false, true, true, false};
  live.predicates = Predicates::kConservative;
  live.overlap = 0.75;
  live.clusters = 3;
  live.iterations = 4;
  live.refresh_period = 5;
  return live;
}

void expectSame(const LiveParameters& a, const LiveParameters& b) {
  EXPECT_EQ(a.margin_m, b.margin_m);
  EXPECT_EQ(a.near_pairs, b.near_pairs);
  EXPECT_EQ(a.max_rate_hz, b.max_rate_hz);
  EXPECT_EQ(a.robot_rate_hz, b.robot_rate_hz);
  EXPECT_EQ(a.marker_rate_hz, b.marker_rate_hz);
  EXPECT_TRUE(a.pair_classes == b.pair_classes);
  EXPECT_EQ(a.predicates, b.predicates);
  EXPECT_EQ(a.overlap, b.overlap);
  EXPECT_EQ(a.clusters, b.clusters);
  EXPECT_EQ(a.iterations, b.iterations);
  EXPECT_EQ(a.refresh_period, b.refresh_period);
}

LiveParameters parse(const XmlRpc::XmlRpcValue& tree) {
  Strings warnings;
  return startValues(parseParameters(tree, &warnings));
}

TEST(Reconfigure, ValuesComeAndGoUnchanged) {
  Config config;
  fill(unusual(), &config);
  Strings rejected;
  expectSame(fromConfig(config, LiveParameters(), true, &rejected), unusual());
  EXPECT_TRUE(rejected.empty());
}

TEST(Reconfigure, DefaultsAreTheParameters) {
  Strings rejected;
  expectSame(fromConfig(Config::__getDefault__(), unusual(), true, &rejected),
             parse(XmlRpc::XmlRpcValue()));
  EXPECT_TRUE(rejected.empty());
}

// People look at these numbers on the parameter server.
TEST(Reconfigure, StartValuesAreTheNumbersThatWereWritten) {
  XmlRpc::XmlRpcValue tree;
  for (const double number : {0.01, 0.05, 0.123456, 0.9, 1.0, 1.0 / 3}) {
    tree["margin_m"] = tree["overlap"] = number;
    const LiveParameters live = parse(tree);
    EXPECT_EQ(live.margin_m, live.overlap);
    EXPECT_EQ(static_cast<float>(live.margin_m), static_cast<float>(number));
    EXPECT_TRUE(live.margin_m == number || number == 1.0 / 3) << live.margin_m;
  }
}

// Checks for every number that the ends of its range are good parameters, and that numbers beyond
// are not.
TEST(Reconfigure, RangesAreTheParameters) {
  const auto accepted = [](const std::string& name, const XmlRpc::XmlRpcValue& value) {
    XmlRpc::XmlRpcValue tree;
    tree[name] = value;
    try {
      parse(tree);
    } catch (const ParameterError&) {
      return false;
    }
    return true;
  };
  std::size_t numbers = 0;
  for (const auto& parameter : Config::__getParamDescriptions__()) {
    boost::any low, high;
    parameter->getValue(Config::__getMin__(), low);
    parameter->getValue(Config::__getMax__(), high);
    const std::string& name = parameter->name;
    if (parameter->type == "double") {
      const double least = boost::any_cast<double>(low), most = boost::any_cast<double>(high);
      EXPECT_TRUE(accepted(name, least) && accepted(name, most)) << name;
      EXPECT_FALSE(accepted(name, std::nextafter(least, -1e9))) << name;
      EXPECT_FALSE(accepted(name, std::nextafter(most, 1e9))) << name;
      ++numbers;
    } else if (parameter->type == "int") {
      const int least = boost::any_cast<int>(low), most = boost::any_cast<int>(high);
      EXPECT_TRUE(accepted(name, least) && accepted(name, most)) << name;
      EXPECT_FALSE(accepted(name, least - 1)) << name;
      EXPECT_FALSE(accepted(name, most + 1)) << name;
      ++numbers;
    }
  }
  EXPECT_EQ(numbers, 8U);
}

TEST(Reconfigure, WhatCannotBeUsedStaysAsItIs) {
  Config config;
  fill(LiveParameters(), &config);
  config.margin_m = std::numeric_limits<double>::quiet_NaN();
  config.overlap = std::numeric_limits<double>::infinity();
  config.predicates = "sloppy";
  config.clusters = 12;
  Strings rejected;
  const LiveParameters live = fromConfig(config, unusual(), true, &rejected);
  EXPECT_EQ(live.margin_m, 0.5);
  EXPECT_EQ(live.overlap, 0.75);
  EXPECT_EQ(live.predicates, Predicates::kConservative);
  EXPECT_EQ(live.clusters, 12) << "the others go on";
  EXPECT_EQ(rejected, (Strings{"margin_m must be finite", "overlap must be finite",
                               "predicates 'sloppy' is none of exact, conservative"}));
}

TEST(Reconfigure, AClassOfTheRobotNeedsTheRobotThatWasReadAtStart) {
  Config config;
  fill(unusual(), &config);
  LiveParameters in_force = unusual();
  in_force.pair_classes = {false, true, true, false};
  Strings rejected;
  EXPECT_TRUE(fromConfig(config, in_force, false, &rejected).pair_classes == in_force.pair_classes);
  EXPECT_EQ(rejected.size(), 1U);
  config.robot_self = false;
  rejected.clear();
  config.robot_rigid = true;
  EXPECT_TRUE(fromConfig(config, in_force, false, &rejected).pair_classes == in_force.pair_classes);
  EXPECT_EQ(rejected.size(), 1U);
  config.robot_rigid = false;
  rejected.clear();
  EXPECT_TRUE(fromConfig(config, in_force, false, &rejected).pair_classes ==
              (PairClasses{false, true, false, false, true}));
  EXPECT_TRUE(rejected.empty());
}

}  // namespace
}  // namespace deformable_contact_monitor
