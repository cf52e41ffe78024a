// Writes the results of measure_trade --margins. The columns of margins.csv and the keys of
// summary.json come from the same list.
#include "tools/measure_trade/margin_report.h"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "tools/common/reports.h"
#include "tools/common/sample_statistics.h"
#include "tools/measure_trade/trade_grid.h"
#include "tools/measure_trade/trade_report.h"

namespace deformable_contact_monitor {
namespace {

using Json = nlohmann::json;

// Returns the mean over all cycles.
double perCycle(std::uint64_t sum, const MarginMeasurement& m) {
  return m.ms.empty() ? 0 : static_cast<double>(sum) / static_cast<double>(m.ms.size());
}

// Returns the numbers of a row, in the order of the columns.
std::vector<std::pair<std::string, double>> row(const MarginMeasurement& m) {
  return {{"cycles", static_cast<double>(m.ms.size())},
          {"median_ms", median(m.ms)},
          {"p95_ms", percentile(m.ms, 0.95)},
          {"p99_ms", percentile(m.ms, 0.99)},
          {"body_pairs", perCycle(m.body_pairs, m)},
          {"triangle_pairs", perCycle(m.triangle_pairs, m)}};
}

}  // namespace

std::string marginsCsv(const TradeArguments& arguments, const std::vector<MarginMeasurement>& all) {
  std::string text = "backend,threads,margin_m,use";
  for (const auto& [name, value] : row(all.front())) text += "," + name;
  for (const MarginMeasurement& m : all) {
    text += "\n" + m.setting.backend + "," + std::to_string(arguments.base.threads) + "," +
            numberText(m.setting.margin_m) + "," + toString(m.setting.use);
    for (const auto& [name, value] : row(m)) text += "," + numberText(value);
  }
  return text + "\n";
}

std::string marginsJson(const TradeArguments& arguments, const std::vector<MarginMeasurement>& all,
                        const FrameSource& frames) {
  Json json = summaryHead(arguments, frames);
  json["broken_promises"] = Json::array();
  json["settings"] = Json::array();
  for (const MarginMeasurement& m : all) {
    if (!m.broken.empty()) json["broken_promises"].push_back(m.broken);
    Json of_setting = {{"backend", m.setting.backend},
                       {"margin_m", m.setting.margin_m},
                       {"use", toString(m.setting.use)}};
    for (const auto& [name, value] : row(m)) of_setting[name] = value;
    json["settings"].push_back(of_setting);
  }
  return jsonText(json);
}

std::string marginsText(const TradeArguments& arguments,
                        const std::vector<MarginMeasurement>& all) {
  std::string text = "Means of a cycle, on " + std::to_string(arguments.base.threads) +
                     (arguments.base.threads == 1 ? " thread:\n" : " threads (0: all):\n");
  for (const MarginMeasurement& m : all) {
    char line[240];
    std::snprintf(line, sizeof line,
                  "  %-34s median %9.3f ms, p99 %9.3f ms, %8.1f pairs of bodies, %10.1f of "
                  "triangles\n",
                  describe(m.setting).c_str(), median(m.ms), percentile(m.ms, 0.99),
                  perCycle(m.body_pairs, m), perCycle(m.triangle_pairs, m));
    text += line;
  }
  return text;
}

}  // namespace deformable_contact_monitor
