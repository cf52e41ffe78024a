// What measure_trade writes in words: JSON, the choice, the node's parameters.
#include "tools/measure_trade/trade_report.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "tools/common/json_text.h"
#include "tools/common/machine.h"
#include "tools/common/sample_statistics.h"

namespace deformable_contact_monitor {
namespace {

using Json = nlohmann::json;

std::string milliseconds(double ms) {
  char text[40];
  std::snprintf(text, sizeof text, ms < 10 ? "%.2f ms" : "%.1f ms", ms);
  return text;
}

// Rounded down, so that 100 % is all.
std::string percent(double rate) {
  char text[40];
  std::snprintf(text, sizeof text, "%.7g %%", std::floor(rate * 1e6) / 1e4);
  return text;
}

std::string worthText(const Worth& worth) {
  return "median " + milliseconds(worth.median_ms) + ", p95 " + milliseconds(worth.p95_ms) +
         "; in the worst frame it finds " + percent(worth.recall) + " of the contacts, and " +
         percent(worth.precision) + " of what it finds are contacts; " +
         (worth.guaranteed ? "guaranteed to miss none" : "not guaranteed");
}

std::string budgetText(double budget_ms) { return "a budget of " + numberText(budget_ms) + " ms"; }

Json bodiesJson(const FrameSource& frames) {
  Json json = Json::array();
  const Scene& scene = frames.scene();
  for (BodyId body = 0; body < scene.bodyCount(); ++body) {
    json.push_back({{"name", scene.body(body).name},
                    {"triangles", scene.body(body).mesh.triangleCount()},
                    {"deformable", frames.isDeformable(body)}});
  }
  return json;
}

Json settingJson(const Measurement& m) {
  const Options& options = m.setting.options;
  const Worth worth = m.worth();
  return {{"backend", m.setting.backend},
          {"predicates", toString(options.predicates)},
          {"overlap", options.overlap},
          {"clusters", options.clusters},
          {"fuzzifier", options.fuzzifier},
          {"iterations", options.iterations},
          {"refresh_period", options.refresh_period},
          {"median_ms", worth.median_ms},
          {"p95_ms", worth.p95_ms},
          {"recall_worst", worth.recall},
          {"precision_worst", worth.precision},
          {"guaranteed", worth.guaranteed}};
}

Json contactsJson(const ExactResults& exact) {
  Json json = Json::array();
  for (std::size_t frame = 0; frame < exact.labels.size(); ++frame) {
    json.push_back({{"frame", exact.labels[frame]}, {"contacts", exact.contacts[frame].size()}});
  }
  return json;
}

}  // namespace

std::string summaryJson(const TradeArguments& arguments, const TradeResults& results,
                        const FrameSource& frames) {
  Json json;
  json["version"] = DCM_VERSION;
  json["command"] = arguments.command;
  json["machine"] = machineJson();
  json["bodies"] = bodiesJson(frames);
  json["frames"] = contactsJson(results.exact);
  json["adjacent"] = toString(arguments.base.adjacent);
  json["threads"] = arguments.base.threads;
  json["warm_up"] = arguments.warm_up;
  json["cycles"] = results.measurements.front().round_trip_ms.size();
  json["settings"] = results.measurements.size();
  json["broken_guarantees"] = Json::array();
  for (const Measurement& m : results.measurements) {
    if (!m.broken.empty()) json["broken_guarantees"].push_back(m.broken);
  }
  json["budget_ms"] = arguments.budget_ms ? Json(*arguments.budget_ms) : Json();
  json["chosen"] = results.chosen ? settingJson(results.measurements[*results.chosen]) : Json();
  json["fastest"] = settingJson(results.measurements[results.fastest]);
  return jsonText(json);
}

std::string choiceText(const TradeArguments& arguments, const TradeResults& results) {
  if (results.chosen) {
    const Measurement& m = results.measurements[*results.chosen];
    return "Chosen " +
           (arguments.budget_ms ? "for " + budgetText(*arguments.budget_ms) : "without a budget") +
           ": " + describe(m.setting) + "\n  " + worthText(m.worth()) + "\n";
  }
  const Measurement& m = results.measurements[results.fastest];
  const std::string why = arguments.budget_ms
                              ? "No setting keeps " + budgetText(*arguments.budget_ms)
                              : "No setting of these is guaranteed";
  return why + ". The fastest: " + describe(m.setting) + "\n  " + worthText(m.worth()) + "\n";
}

std::string configYaml(const TradeArguments& arguments, const TradeResults& results) {
  const Machine machine = thisMachine();
  std::string text = "# Written by " + arguments.command + "\n# on " + machine.cpu;
  for (const std::string& gpu : machine.gpus) text += ", " + gpu;
  const std::string choice = choiceText(arguments, results);
  text +=
      ":\n# " + choice.substr(0, choice.find('\n')) + "\n#" + choice.substr(choice.find('\n') + 1);
  if (!results.chosen) return text;
  const Setting& setting = results.measurements[*results.chosen].setting;
  const Options& options = setting.options;
  return text + "backend: " + setting.backend + "\npredicates: " + toString(options.predicates) +
         "\noverlap: " + numberText(options.overlap) +
         "\nclusters: " + std::to_string(options.clusters) +
         "\nfuzzifier: " + numberText(options.fuzzifier) +
         "\niterations: " + std::to_string(options.iterations) +
         "\nrefresh_period: " + std::to_string(options.refresh_period) + "\n";
}

}  // namespace deformable_contact_monitor
