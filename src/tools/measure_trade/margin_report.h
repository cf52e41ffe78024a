// Writes the results of measure_trade --margins: a table, JSON, and a few lines for people.
#pragma once

#include <string>
#include <vector>

#include "tools/measure_trade/frame_source.h"
#include "tools/measure_trade/margin_measurement.h"
#include "tools/measure_trade/trade_arguments.h"

namespace deformable_contact_monitor {

// Returns a table with a row for each setting.
std::string marginsCsv(const TradeArguments& arguments, const std::vector<MarginMeasurement>& all);

// Returns the content of summary.json.
std::string marginsJson(const TradeArguments& arguments, const std::vector<MarginMeasurement>& all,
                        const FrameSource& frames);

// Returns a line for each setting.
std::string marginsText(const TradeArguments& arguments, const std::vector<MarginMeasurement>& all);

}  // namespace deformable_contact_monitor
