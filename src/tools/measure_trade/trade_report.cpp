// Writes tables, JSON, the choice for people, and the node's parameters. README.md says what each
// file holds.
#include "tools/measure_trade/trade_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tools/common/command_line.h"
#include "tools/common/formatted.h"
#include "tools/common/reports.h"
#include "tools/common/sample_statistics.h"

namespace deformable_contact_monitor {
namespace {

constexpr const char* kSettingColumns =
    "backend,predicates,overlap,clusters,fuzzifier,iterations,refresh_period";
constexpr const char* kOnsetColumns = "onset_runs,onset_missed,onset_delay_mean,onset_delay_worst";

// Returns the setting's columns.
std::string settingRow(const Setting& setting) {
  const Options& options = setting.options;
  return csvRow(setting.backend, toString(options.predicates), numberText(options.overlap),
                options.clusters, numberText(options.fuzzifier), options.iterations,
                options.refresh_period);
}

// Returns the mean, the worst frame's recall and its label; empty if there is nothing to count.
std::string recallRow(const RateOverFrames& recall, bool counts, const ExactResults& exact) {
  if (!counts) return ",,";
  return csvRow(numberText(recall.mean()), numberText(recall.worst),
                recall.worst < 1 ? exact.labels.at(recall.worst_frame) : "");
}

// Returns percentiles of all cycles, and the range of the repeats' medians and 95th percentiles.
std::string noiseRow(const Measurement& m) {
  const Worth worth = m.worth();
  return csvRow(numberText(percentile(m.round_trip_ms, 0.1)),
                numberText(percentile(m.round_trip_ms, 0.9)),
                numberText(worth.median_ms - worth.median_noise.below),
                numberText(worth.median_ms + worth.median_noise.above),
                numberText(worth.p95_ms - worth.p95_noise.below),
                numberText(worth.p95_ms + worth.p95_noise.above));
}

// Returns the delays until contacts are found.
std::string onsetRow(const OnsetDelay& onset) {
  return csvRow(onset.runs, onset.missed, numberText(onset.mean()), onset.worst);
}

// Returns the work of a cycle, per cycle or per triangle in the sweep. A ratio of nothing is 0.
std::string workRow(const Measurement& m) {
  const auto ratio = [](std::uint64_t part, std::uint64_t whole) {
    return numberText(whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole));
  };
  const Counters& work = m.work;
  const std::uint64_t swept = work.clustered + work.large;
  const auto cycles = m.round_trip_ms.size();
  return csvRow(ratio(work.undecided, cycles), ratio(work.clusters, cycles),
                ratio(work.candidates, swept), ratio(work.cluster_entries, work.clustered),
                ratio(work.interval_overlaps, swept), ratio(work.exact, work.candidates));
}

const char* flagText(bool flag) { return flag ? "true" : "false"; }

using Json = nlohmann::json;

// Returns a time with two decimals below 10 ms, and with one above.
std::string milliseconds(double ms) {
  return ms < 10 ? formatted("%.2f ms", ms) : formatted("%.1f ms", ms);
}

// Rounds down, so that 100 % means all.
std::string percent(double rate) { return formatted("%.7g %%", std::floor(rate * 1e6) / 1e4); }

// Returns the criteria of a setting in words.
std::string worthText(const TradeResults& results, const Worth& worth) {
  const bool is_whole = results.exact.rejected == 0;
  return "median " + milliseconds(worth.median_ms) + ", p95 " + milliseconds(worth.p95_ms) +
         "; in the worst frame it finds " + percent(worth.recall) + " of the contacts, and " +
         percent(worth.precision) + " of what it finds are contacts; " +
         (!worth.guaranteed ? "not guaranteed"
          : is_whole        ? "guaranteed to miss none"
                            : "guaranteed to miss none of the triangles that took part");
}

Json rangeJson(double figure, const Spread& noise) {
  return {figure - noise.below, figure + noise.above};
}

std::string rangeText(double figure, const Spread& noise) {
  return milliseconds(figure - noise.below) + " to " + milliseconds(figure + noise.above);
}

// Returns the range of the repeats in words.
std::string noiseText(const Measurement& m) {
  const Worth worth = m.worth();
  std::string text = "  p10 " + milliseconds(percentile(m.round_trip_ms, 0.1)) + ", p90 " +
                     milliseconds(percentile(m.round_trip_ms, 0.9)) + "; ";
  if (m.repeats.size() < 2) return text + "a single repeat says nothing about noise\n";
  return text + "in " + std::to_string(m.repeats.size()) + " repeats the median was " +
         rangeText(worth.median_ms, worth.median_noise) + ", the p95 " +
         rangeText(worth.p95_ms, worth.p95_noise) + "\n";
}

// Returns true if the chosen setting keeps the budget only in some repeats.
bool isDoubtful(const TradeArguments& arguments, const Measurement& chosen) {
  return arguments.budget_ms && chosen.worth().p95_ms > *arguments.budget_ms;
}

// Names settings that would also have been chosen if the noise were different.
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

// Describes a setting and what was measured of it.
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

// Returns a value as in JSON, but words without quotes.
std::string shown(const Json& value) {
  if (value.is_string()) return csvField(value.get<std::string>());
  return value.is_number_float() ? numberText(value.get<double>()) : value.dump();
}

Json contactsJson(const ExactResults& exact) {
  Json json = Json::array();
  for (std::size_t frame = 0; frame < exact.labels.size(); ++frame) {
    json.push_back({{"frame", exact.labels[frame]}, {"contacts", exact.contacts[frame].size()}});
  }
  return json;
}

}  // namespace

std::string csvTable(const std::vector<TableRow>& rows) {
  std::string title, lines;
  for (const auto& [name, value] : rows.front()) title += "," + name;
  for (const TableRow& row : rows) {
    std::string line;
    for (const auto& [name, value] : row) line += "," + shown(value);
    lines += line.substr(1) + "\n";
  }
  return title.substr(1) + "\n" + lines;
}

Json jsonTable(const std::vector<TableRow>& rows) {
  Json table = Json::array();
  for (const TableRow& row : rows) {
    table.emplace_back();
    for (const auto& [name, value] : row) table.back()[name] = value;
  }
  return table;
}

double toDecimal(float number) { return std::stod(numberText(number)); }

// The command and the machine let a reader repeat the measurement.
nlohmann::json summaryHead(const TradeArguments& arguments, const FrameSource& frames) {
  nlohmann::json json;
  json["version"] = DCM_VERSION;
  json["command"] = arguments.command;
  json["machine"] = machineJson();
  json["adjacent"] = toString(arguments.base.adjacent);
  json["threads"] = arguments.base.threads;
  json["bodies"] = nlohmann::json::array();
  const Scene& scene = frames.scene();
  for (BodyId body = 0; body < scene.bodyCount(); ++body) {
    json["bodies"].push_back({{"name", scene.body(body).name},
                              {"triangles", scene.body(body).mesh.triangleCount()},
                              {"deformable", frames.isDeformable(body)}});
  }
  return json;
}

std::string settingsCsv(const TradeResults& results) {
  // Columns of a kind of contact that no frame has stay empty.
  bool external = false, self = false;
  for (const BodyPair& bodies : results.exact.bodies) {
    (bodies.first == bodies.second ? self : external) = true;
  }
  std::string text = std::string(kSettingColumns) +
                     ",median_ms,p95_ms,least_ms,p10_ms,p90_ms,median_low_ms,median_high_ms,"
                     "p95_low_ms,p95_high_ms,recall_external_mean,recall_external_worst,"
                     "recall_external_worst_frame,recall_self_mean,recall_self_worst,"
                     "recall_self_worst_frame,precision_mean,precision_worst,undecided,"
                     "clusters_used,candidates_per_triangle,clusters_per_triangle,"
                     "interval_overlaps_per_triangle,exact_share," +
                     kOnsetColumns + ",guaranteed,pareto_front\n";
  for (std::size_t i = 0; i < results.measurements.size(); ++i) {
    const Measurement& m = results.measurements[i];
    text +=
        settingRow(m.setting) + "," +
        csvRow(numberText(median(m.round_trip_ms)), numberText(percentile(m.round_trip_ms, 0.95)),
               numberText(*std::min_element(m.round_trip_ms.begin(), m.round_trip_ms.end()))) +
        "," + noiseRow(m) + "," + recallRow(m.external, external, results.exact) + "," +
        recallRow(m.self, self, results.exact) + "," +
        csvRow(numberText(m.precision.mean()), numberText(m.precision.worst)) + "," + workRow(m) +
        "," + onsetRow(m.onset) + "," + csvRow(flagText(m.guaranteed), flagText(results.front[i])) +
        "\n";
  }
  return text;
}

std::string linksCsv(const TradeResults& results, const FrameSource& frames) {
  std::string text = std::string(kSettingColumns) +
                     ",link,object,recall_mean,recall_worst,recall_worst_frame," + kOnsetColumns +
                     "\n";
  const auto name = [&frames](BodyId body) { return frames.scene().body(body).name; };
  for (const Measurement& m : results.measurements) {
    for (const auto& [bodies, of_bodies] : m.bodies) {
      // Tables name the rigid body first, which is a link of a robot.
      const bool first_deforms = frames.isDeformable(bodies.first);
      text += settingRow(m.setting) + "," +
              csvRow(name(first_deforms ? bodies.second : bodies.first),
                     name(first_deforms ? bodies.first : bodies.second)) +
              "," + recallRow(of_bodies.recall, true, results.exact) + "," +
              onsetRow(of_bodies.onset) + "\n";
    }
  }
  return text;
}

std::string summaryJson(const TradeArguments& arguments, const TradeResults& results,
                        const FrameSource& frames) {
  Json json = summaryHead(arguments, frames);
  json["frames"] = contactsJson(results.exact);
  json["rejected_triangles"] = results.exact.rejected;
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
           ": " + describe(m.setting) + "\n  " + worthText(results, m.worth()) + "\n" +
           noiseText(m) + otherChoices(arguments, results) +
           (isDefault(m.setting) ? "Keep the defaults: this setting is the node's own.\n" : "");
  }
  // Nothing was chosen, so the fastest setting shows how far the budget is away.
  const Measurement& m = results.measurements[results.fastest];
  const std::string why = arguments.budget_ms
                              ? "No setting keeps " + budgetText(*arguments.budget_ms)
                              : "No setting of these is guaranteed";
  return why + ". The fastest: " + describe(m.setting) + "\n  " + worthText(results, m.worth()) +
         "\n" + noiseText(m);
}

// Every line of the comment begins with #, so the file is valid without a chosen setting too.
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
