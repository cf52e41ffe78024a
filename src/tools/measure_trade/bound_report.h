// Writes the results of measure_trade --tolerance and --margins: tables, JSON, the node's
// parameters, and a few lines for people.
//
// The first setting of --tolerance is exact detection on the CPU; the others are compared with it.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "tools/measure_trade/bound_measurement.h"
#include "tools/measure_trade/frame_source.h"
#include "tools/measure_trade/margin_measurement.h"
#include "tools/measure_trade/trade_arguments.h"

namespace deformable_contact_monitor {

// Returns a table with a row for each setting. The first setting is exact.
std::string boundsCsv(const TradeArguments& arguments, const std::vector<BoundMeasurement>& all);

// Returns the content of summary.json.
std::string boundsJson(const TradeArguments& arguments, const std::vector<BoundMeasurement>& all,
                       const FrameSource& frames);

// Returns the index of the chosen setting: the smallest tolerance that decided every pair and whose
// 95th percentile keeps the budget of the arguments. Without a budget, it is the fastest setting
// that decided every pair. A setting of which no claim is true is not chosen, and one with a budget
// of its own only if none without it has the same tolerance. Returns nothing if there is none.
std::optional<std::size_t> chooseBounds(const TradeArguments& arguments,
                                        const std::vector<BoundMeasurement>& all);

// Returns a line for each setting, and the choice.
std::string boundsText(const TradeArguments& arguments, const std::vector<BoundMeasurement>& all);

// Returns the node's parameters. If no setting was chosen, they have the largest tolerance of which
// some claim is true. They have a budget_ms, that of the arguments, only if the arguments ask for
// it.
std::string boundsYaml(const TradeArguments& arguments, const std::vector<BoundMeasurement>& all,
                       const FrameSource& frames);

// The same of --margins.
std::string marginsCsv(const TradeArguments& arguments, const std::vector<MarginMeasurement>& all);
std::string marginsJson(const TradeArguments& arguments, const std::vector<MarginMeasurement>& all,
                        const FrameSource& frames);
std::string marginsText(const TradeArguments& arguments, const std::vector<MarginMeasurement>& all);

}  // namespace deformable_contact_monitor
