// Writes the results of measure_trade --tolerance and --margins, and chooses a setting.
#include "tools/measure_trade/bound_report.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "tools/common/command_line.h"
#include "tools/common/formatted.h"
#include "tools/common/reports.h"
#include "tools/common/sample_statistics.h"
#include "tools/measure_trade/trade_grid.h"
#include "tools/measure_trade/trade_report.h"

namespace deformable_contact_monitor {
namespace {

using Json = nlohmann::json;

TableRow row(const TradeArguments& arguments, const BoundMeasurement& m,
             const BoundMeasurement& exact) {
  return {{"backend", m.setting.backend},
          {"threads", arguments.base.threads},
          {"overlap", toDecimal(m.setting.overlap)},
          {"tolerance_m", toDecimal(m.setting.tolerance_m)},
          {"budget_ms", m.setting.budget_ms},
          {"cycles", m.ms.size()},
          {"median_ms", median(m.ms)},
          {"p95_ms", percentile(m.ms, 0.95)},
          {"p99_ms", percentile(m.ms, 0.99)},
          {"time_of_exact", median(m.ms) / median(exact.ms)},
          {"pairs", m.pairs},
          {"decided_share", m.decidedShare()},
          {"contacts", m.contacts.truth},
          {"recall", m.contacts.recall()},
          {"precision", m.contacts.precision()},
          {"missed", m.missed},
          {"largest_claim_m", m.largest_claim_m},
          {"p99_over_budget", m.p99OverBudget()}};
}

// Returns whether the setting claims contacts, and none of them is true: its tolerance is too large
// for the scene.
bool claimsOnlyFalsely(const BoundMeasurement& m) {
  return m.contacts.found > 0 && m.contacts.common == 0;
}

// Returns the line of a setting for people.
std::string line(const BoundMeasurement& m, const BoundMeasurement& exact) {
  return formatted(
      "  %-34s median %8.3f ms (%.2f of exact), p99 %8.3f ms, %6.2f %% decided, recall %.4g %%, "
      "precision %.4g %%, contacts up to %.3g m apart\n",
      describe(m.setting).c_str(), median(m.ms), median(m.ms) / median(exact.ms),
      percentile(m.ms, 0.99), 100 * m.decidedShare(), 100 * m.contacts.recall(),
      100 * m.contacts.precision(), m.largest_claim_m);
}

// Returns the mean over all cycles.
double perCycle(std::uint64_t sum, const MarginMeasurement& m) {
  return m.ms.empty() ? 0 : static_cast<double>(sum) / static_cast<double>(m.ms.size());
}

TableRow row(const TradeArguments& arguments, const MarginMeasurement& m) {
  return {{"backend", m.setting.backend},
          {"threads", arguments.base.threads},
          {"margin_m", toDecimal(m.setting.margin_m)},
          {"use", toString(m.setting.use)},
          {"cycles", m.ms.size()},
          {"median_ms", median(m.ms)},
          {"p95_ms", percentile(m.ms, 0.95)},
          {"p99_ms", percentile(m.ms, 0.99)},
          {"body_pairs", perCycle(m.body_pairs, m)},
          {"triangle_pairs", perCycle(m.triangle_pairs, m)}};
}

std::vector<TableRow> rows(const TradeArguments& arguments,
                           const std::vector<BoundMeasurement>& all) {
  std::vector<TableRow> rows;
  rows.reserve(all.size());
  for (const BoundMeasurement& m : all) rows.push_back(row(arguments, m, all.front()));
  return rows;
}

std::vector<TableRow> rows(const TradeArguments& arguments,
                           const std::vector<MarginMeasurement>& all) {
  std::vector<TableRow> rows;
  rows.reserve(all.size());
  for (const MarginMeasurement& m : all) rows.push_back(row(arguments, m));
  return rows;
}

// Returns how the lines for people begin that say how many threads there were.
std::string threadsText(const TradeArguments& arguments) {
  const int threads = arguments.base.threads;
  return "on " + std::to_string(threads) + (threads == 1 ? " thread:\n" : " threads (0: all):\n");
}

// Returns the beginning of summary.json, with the broken promises and the settings.
template <class Measurement>
Json promisesJson(const TradeArguments& arguments, const std::vector<Measurement>& all,
                  const FrameSource& frames) {
  Json json = summaryHead(arguments, frames);
  json["broken_promises"] = Json::array();
  for (const Measurement& m : all) {
    if (!m.broken.empty()) json["broken_promises"].push_back(m.broken);
  }
  json["rejected_triangles"] = all.front().rejected;
  json["settings"] = jsonTable(rows(arguments, all));
  return json;
}

}  // namespace

std::string boundsCsv(const TradeArguments& arguments, const std::vector<BoundMeasurement>& all) {
  return csvTable(rows(arguments, all));
}

std::string boundsJson(const TradeArguments& arguments, const std::vector<BoundMeasurement>& all,
                       const FrameSource& frames) {
  Json json = promisesJson(arguments, all, frames);
  json["budget_ms"] = arguments.budget_ms ? Json(*arguments.budget_ms) : Json();
  const std::optional<std::size_t> chosen = chooseBounds(arguments, all);
  json["chosen"] = chosen ? Json(describe(all[*chosen].setting)) : Json();
  return jsonText(json);
}

// With a budget, less tolerance is better, then less time. Without one, only the time counts. Of
// settings that decide every pair, a budget changes no result, so it is not chosen where another
// setting does without.
std::optional<std::size_t> chooseBounds(const TradeArguments& arguments,
                                        const std::vector<BoundMeasurement>& all) {
  std::optional<std::size_t> best;
  const auto rank = [&](const BoundMeasurement& m) {
    return std::make_pair(arguments.budget_ms ? m.setting.tolerance_m : 0.F, median(m.ms));
  };
  const auto is_allowed = [&](const BoundMeasurement& m) {
    const bool is_late = arguments.budget_ms && percentile(m.ms, 0.95) > *arguments.budget_ms;
    return m.broken.empty() && m.setting.overlap == 1 && m.decided == m.pairs &&
           !claimsOnlyFalsely(m) && !is_late;
  };
  const auto does_without_budget = [&](const BoundMeasurement& m) {
    return std::any_of(all.begin(), all.end(), [&](const BoundMeasurement& other) {
      return m.setting.budget_ms > 0 && other.setting.budget_ms == 0 &&
             other.setting.tolerance_m == m.setting.tolerance_m &&
             other.setting.backend == m.setting.backend && is_allowed(other);
    });
  };
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!is_allowed(all[i]) || does_without_budget(all[i])) continue;
    if (!best || rank(all[i]) < rank(all[*best])) best = i;
  }
  return best;
}

std::string boundsText(const TradeArguments& arguments, const std::vector<BoundMeasurement>& all) {
  std::string text = "Of pairs of two bodies, " + threadsText(arguments);
  for (const BoundMeasurement& m : all) text += line(m, all.front());
  const std::optional<std::size_t> chosen = chooseBounds(arguments, all);
  const std::string budget =
      arguments.budget_ms ? " within " + numberText(*arguments.budget_ms) + " ms" : "";
  if (chosen && all[*chosen].setting.overlap == 1 && !all[*chosen].setting.isBounded()) {
    text += "Keep the defaults: exact detection, without tolerance and budget\n";
  }
  return text +
         (chosen ? "Chosen" + budget + ": " + describe(all[*chosen].setting)
                 : "No setting decides all pairs" + budget) +
         "\n";
}

// Without a choice, the largest tolerance of which some claim is true is written, because it is the
// most likely to keep the budget.
std::string boundsYaml(const TradeArguments& arguments, const std::vector<BoundMeasurement>& all,
                       const FrameSource& frames) {
  const std::optional<std::size_t> chosen = chooseBounds(arguments, all);
  const auto tolerance = [](const BoundMeasurement& m) {
    return claimsOnlyFalsely(m) ? -1.F : m.setting.tolerance_m;
  };
  const auto larger = [&](const BoundMeasurement& a, const BoundMeasurement& b) {
    return tolerance(a) < tolerance(b);
  };
  const BoundMeasurement& m =
      chosen ? all[*chosen] : *std::max_element(all.begin(), all.end(), larger);
  std::string text = "# Written by " + arguments.command + "\n# on " + thisMachine().cpu + ":\n";
  std::istringstream lines(boundsText(arguments, all));
  for (std::string words; std::getline(lines, words);) text += "# " + words + "\n";
  text += "backend: " + m.setting.backend + "\nthreads: " + std::to_string(arguments.base.threads) +
          "\ntolerance_m: " + numberText(m.setting.tolerance_m) + "\n";
  if (arguments.writes_budget) text += "budget_ms: " + numberText(*arguments.budget_ms) + "\n";
  text += "pair_classes: [" + joined(frames.pairClasses(), ", ") + "]\n";
  return text;
}

std::string marginsCsv(const TradeArguments& arguments, const std::vector<MarginMeasurement>& all) {
  return csvTable(rows(arguments, all));
}

std::string marginsJson(const TradeArguments& arguments, const std::vector<MarginMeasurement>& all,
                        const FrameSource& frames) {
  return jsonText(promisesJson(arguments, all, frames));
}

std::string marginsText(const TradeArguments& arguments,
                        const std::vector<MarginMeasurement>& all) {
  std::string text = "Means of a cycle, " + threadsText(arguments);
  for (const MarginMeasurement& m : all) {
    text += formatted(
        "  %-34s median %9.3f ms, p99 %9.3f ms, %8.1f pairs of bodies, %10.1f of triangles\n",
        describe(m.setting).c_str(), median(m.ms), percentile(m.ms, 0.99),
        perCycle(m.body_pairs, m), perCycle(m.triangle_pairs, m));
  }
  return text;
}

}  // namespace deformable_contact_monitor
