// Tests that the node reads what measure_trade writes.
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

#include "monitor/rules/parameters.h"
#include "tools/measure_trade/bound_report.h"
#include "tools/measure_trade/trade_report.h"

namespace deformable_contact_monitor {
namespace {

// A flat map of scalars, typed as rosparam types them (integers, numbers, else text), and of lists
// of text.
XmlRpc::XmlRpcValue parameterTree(const std::string& yaml) {
  XmlRpc::XmlRpcValue tree;
  for (const auto& entry : YAML::Load(yaml)) {
    const auto name = entry.first.as<std::string>();
    int integer;
    double number;
    if (entry.second.IsSequence()) {
      for (int i = 0; i < static_cast<int>(entry.second.size()); ++i) {
        tree[name][i] = entry.second[i].as<std::string>();
      }
    } else if (YAML::convert<int>::decode(entry.second, integer)) {
      tree[name] = integer;
    } else if (YAML::convert<double>::decode(entry.second, number)) {
      tree[name] = number;
    } else {
      tree[name] = entry.second.as<std::string>();
    }
  }
  return tree;
}

TradeResults chosen(const Setting& setting) {
  TradeResults results;
  results.measurements.resize(1);
  results.measurements[0].setting = setting;
  results.measurements[0].round_trip_ms = {1, 2, 3};
  results.chosen = 0;
  return results;
}

class NoFrames : public FrameSource {
 public:
  bool next() override { return false; }
  bool isDeformable(BodyId /*body*/) const override { return false; }
  std::vector<std::string> pairClasses() const override { return {"deformable_self"}; }
  std::string label() const override { return ""; }
};

// The corners of the ranges, and what is not exact in binary.
TEST(TradeConfig, TheNodesParserReadsEverySettingBack) {
  std::size_t read = 0;
  for (const char* backend : {"cpu", "cuda"}) {
    for (const Predicates predicates : {Predicates::kExact, Predicates::kConservative}) {
      for (const float overlap : {0.0F, 1e-6F, 0.3F, 1.0F}) {
        for (const float fuzzifier : {1.05F, 2.0F, 4.0F}) {
          Setting setting{backend, Options()};
          setting.options.predicates = predicates;
          setting.options.overlap = overlap;
          setting.options.fuzzifier = fuzzifier;
          setting.options.clusters = overlap == 1 ? 0 : kMaxClusters;
          setting.options.iterations = 100;
          setting.options.refresh_period = 7;
          const std::string yaml = configYaml(TradeArguments(), chosen(setting), NoFrames());
          std::vector<std::string> warnings;
          const MonitorParameters p = parseParameters(parameterTree(yaml), &warnings);
          EXPECT_TRUE(warnings.empty()) << warnings.front();
          EXPECT_EQ(p.backend == BackendChoice::kCuda, setting.backend == "cuda");
          EXPECT_EQ(p.backend == BackendChoice::kCpu, setting.backend == "cpu");
          EXPECT_EQ(p.detector.predicates, predicates);
          EXPECT_EQ(p.detector.overlap, overlap);
          EXPECT_EQ(p.detector.fuzzifier, fuzzifier);
          EXPECT_EQ(p.detector.clusters, setting.options.clusters);
          EXPECT_EQ(p.detector.iterations, 100);
          EXPECT_EQ(p.detector.refresh_period, 7);
          EXPECT_TRUE(p.pair_classes.deformable_self);
          EXPECT_FALSE(p.pair_classes.robot_deformable);
          ++read;
        }
      }
    }
  }
  EXPECT_EQ(read, 48U);
}

// The first setting is exact, and takes as long as the others.
std::string boundsOf(const std::vector<BoundSetting>& settings, double budget_ms, double takes_ms) {
  std::vector<BoundMeasurement> all;
  for (const BoundSetting& setting : settings) {
    all.emplace_back();
    all.back().setting = setting;
    all.back().ms = {takes_ms};
  }
  TradeArguments arguments;
  arguments.base.threads = 2;
  arguments.budget_ms = budget_ms;
  arguments.writes_budget = true;
  return boundsYaml(arguments, all, NoFrames());
}

TEST(TradeConfig, TheNodesParserReadsTolerancesAndBudgetsBack) {
  const std::vector<BoundSetting> settings = {{0, 0}, {0.001F, 0}, {0.3F, 0}};
  for (const bool keeps : {true, false}) {
    std::vector<std::string> warnings;
    const std::string yaml = boundsOf(settings, 2.5, keeps ? 2 : 3);
    const MonitorParameters p = parseParameters(parameterTree(yaml), &warnings);
    EXPECT_TRUE(warnings.empty()) << warnings.front();
    EXPECT_EQ(p.detector.tolerance_m, keeps ? 0 : 0.3F) << "the least that keeps it";
    EXPECT_EQ(p.budget_ms, 2.5);
    EXPECT_EQ(p.detector.threads, 2);
    EXPECT_EQ(p.backend, BackendChoice::kCpu);
    EXPECT_TRUE(p.pair_classes.deformable_self);
  }
}

TEST(TradeConfig, WithoutAChoiceThereIsACommentAlone) {
  TradeResults results = chosen({"cpu", Options()});
  results.chosen.reset();
  EXPECT_TRUE(YAML::Load(configYaml(TradeArguments(), results, NoFrames())).IsNull());
}

}  // namespace
}  // namespace deformable_contact_monitor
