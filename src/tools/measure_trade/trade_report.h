// What measure_trade writes: tables, JSON, the chosen setting for the node and for people.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/measure_trade/frame_source.h"
#include "tools/measure_trade/trade_arguments.h"
#include "tools/measure_trade/trade_measurement.h"

namespace deformable_contact_monitor {

// Everything that was measured, and what follows from it.
struct TradeResults {
  ExactResults exact;
  std::vector<Measurement> measurements;  // at least one
  std::vector<bool> front;                // Pareto's, per measurement
  std::optional<std::size_t> chosen;      // of the measurements; none: none keeps the budget
  std::size_t fastest = 0;                // of the measurements
  std::vector<std::size_t> as_fast;       // the others that cannot be told from the chosen one
};

// A row for each setting. A rate without anything to count, such as recall of self-contacts where
// there are none, is left empty, and so is a worst frame where no frame is below 1.
std::string settingsCsv(const TradeResults& results);

// A row for each setting and pair of bodies with a contact in some frame: `link` is the one that
// does not deform, if one does not; where both are one body, contacts with itself.
std::string linksCsv(const TradeResults& results, const FrameSource& frames);

std::string summaryJson(const TradeArguments& arguments, const TradeResults& results,
                        const FrameSource& frames);

// What was chosen, or that nothing keeps the budget, and what noise does to that; some lines.
std::string choiceText(const TradeArguments& arguments, const TradeResults& results);

// The chosen setting as parameters of contact_monitor, with a comment of what was measured; the
// comment alone where nothing was chosen.
std::string configYaml(const TradeArguments& arguments, const TradeResults& results,
                       const FrameSource& frames);

}  // namespace deformable_contact_monitor
