// What measure_trade --tolerance writes: a table, JSON, the node's parameters, a few lines for
// people.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "tools/measure_trade/bound_measurement.h"
#include "tools/measure_trade/frame_source.h"
#include "tools/measure_trade/trade_arguments.h"

namespace deformable_contact_monitor {

// A row for each setting; the first is exact.
std::string boundsCsv(const TradeArguments& arguments, const std::vector<BoundMeasurement>& all);

std::string boundsJson(const TradeArguments& arguments, const std::vector<BoundMeasurement>& all,
                       const FrameSource& frames);

// The least tolerance with which every pair was decided, in 95 of 100 cycles within arguments'
// budget; without one, the fastest of those. Nothing: there is none.
std::optional<std::size_t> chooseBounds(const TradeArguments& arguments,
                                        const std::vector<BoundMeasurement>& all);

std::string boundsText(const TradeArguments& arguments, const std::vector<BoundMeasurement>& all);

// Where none was chosen, the largest tolerance; budget_ms is the arguments'.
std::string boundsYaml(const TradeArguments& arguments, const std::vector<BoundMeasurement>& all,
                       const FrameSource& frames);

}  // namespace deformable_contact_monitor
