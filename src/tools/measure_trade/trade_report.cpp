// What measure_trade writes in words: JSON, the choice, the node's parameters.
#include "tools/measure_trade/trade_report.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tools/common/json_text.h"
#include "tools/common/machine.h"
#include "tools/common/option_value.h"
#include "tools/common/sample_statistics.h"
#include "tools/measure_trade/summary_head.h"

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

Json rangeJson(double figure, const Spread& noise) {
  return {figure - noise.below, figure + noise.above};
}

std::string rangeText(double figure, const Spread& noise) {
  return milliseconds(figure - noise.below) + " to " + milliseconds(figure + noise.above);
}

std::string noiseText(const Measurement& m) {
  const Worth worth = m.worth();
  std::string text = "  p10 " + milliseconds(percentile(m.round_trip_ms, 0.1)) + ", p90 " +
                     milliseconds(percentile(m.round_trip_ms, 0.9)) + "; ";
  if (m.repeats.size() < 2) return text + "a single repeat says nothing about noise\n";
  return text + "in " + std::to_string(m.repeats.size()) + " repeats the median was " +
         rangeText(worth.median_ms, worth.median_noise) + ", the p95 " +
         rangeText(worth.p95_ms, worth.p95_noise) + "\n";
}

bool isDoubtful(const TradeArguments& arguments, const Measurement& chosen) {
  return arguments.budget_ms && chosen.worth().p95_ms > *arguments.budget_ms;
}

// What else it might have been, but for noise.
std::string otherChoices(const TradeArguments& arguments, const TradeResults& results) {
  const Measurement& chosen = results.measurements[*results.chosen];
  std::string text;
  if (!results.as_fast.empty()) {
    const Measurement& other = results.measurements[results.as_fast.front()];
    text += "  " + std::to_string(results.as_fast.size()) + " of the " +
            std::to_string(results.measurements.size() - 1) +
            " other settings cannot be told from it in time, such as " + describe(other.setting) +
            "; the more exact goes first\n";
  }
  if (isDoubtful(arguments, chosen)) {
    text +=
        "  within noise of the budget: its p95 was over it, but not in every repeat, and cannot "
        "be told from that of a less exact setting that keeps it\n";
  }
  return text;
}

std::string budgetText(double budget_ms) { return "a budget of " + numberText(budget_ms) + " ms"; }

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
          {"p10_ms", percentile(m.round_trip_ms, 0.1)},
          {"p90_ms", percentile(m.round_trip_ms, 0.9)},
          {"median_of_repeats_ms", rangeJson(worth.median_ms, worth.median_noise)},
          {"p95_of_repeats_ms", rangeJson(worth.p95_ms, worth.p95_noise)},
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
  Json json = summaryHead(arguments, frames);
  json["frames"] = contactsJson(results.exact);
  json["warm_up"] = arguments.warm_up;
  json["repeats"] = results.measurements.front().repeats.size();
  json["cycles"] = results.measurements.front().round_trip_ms.size();
  json["settings"] = results.measurements.size();
  json["broken_guarantees"] = Json::array();
  for (const Measurement& m : results.measurements) {
    if (!m.broken.empty()) json["broken_guarantees"].push_back(m.broken);
  }
  json["budget_ms"] = arguments.budget_ms ? Json(*arguments.budget_ms) : Json();
  json["chosen"] = results.chosen ? settingJson(results.measurements[*results.chosen]) : Json();
  json["within_noise_of_chosen"] = Json::array();
  for (const std::size_t i : results.as_fast) {
    json["within_noise_of_chosen"].push_back(describe(results.measurements[i].setting));
  }
  json["budget_within_noise"] =
      results.chosen && isDoubtful(arguments, results.measurements[*results.chosen]);
  json["fastest"] = settingJson(results.measurements[results.fastest]);
  return jsonText(json);
}

std::string choiceText(const TradeArguments& arguments, const TradeResults& results) {
  if (results.chosen) {
    const Measurement& m = results.measurements[*results.chosen];
    return "Chosen " +
           (arguments.budget_ms ? "for " + budgetText(*arguments.budget_ms) : "without a budget") +
           ": " + describe(m.setting) + "\n  " + worthText(m.worth()) + "\n" + noiseText(m) +
           otherChoices(arguments, results);
  }
  const Measurement& m = results.measurements[results.fastest];
  const std::string why = arguments.budget_ms
                              ? "No setting keeps " + budgetText(*arguments.budget_ms)
                              : "No setting of these is guaranteed";
  return why + ". The fastest: " + describe(m.setting) + "\n  " + worthText(m.worth()) + "\n" +
         noiseText(m);
}

std::string configYaml(const TradeArguments& arguments, const TradeResults& results,
                       const FrameSource& frames) {
  const Machine machine = thisMachine();
  std::string text = "# Written by " + arguments.command + "\n# on " + machine.cpu;
  for (const std::string& gpu : machine.gpus) text += ", " + gpu;
  text += ":\n";
  std::istringstream choice(choiceText(arguments, results));
  for (std::string line; std::getline(choice, line);) text += "# " + line + "\n";
  if (!results.chosen) return text;
  const Setting& setting = results.measurements[*results.chosen].setting;
  const Options& options = setting.options;
  return text + "backend: " + setting.backend + "\npredicates: " + toString(options.predicates) +
         "\noverlap: " + numberText(options.overlap) +
         "\nclusters: " + std::to_string(options.clusters) +
         "\nfuzzifier: " + numberText(options.fuzzifier) +
         "\niterations: " + std::to_string(options.iterations) +
         "\nrefresh_period: " + std::to_string(options.refresh_period) + "\npair_classes: [" +
         joined(frames.pairClasses(), ", ") + "]\n";
}

}  // namespace deformable_contact_monitor
