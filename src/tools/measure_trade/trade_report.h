// Writes the results of measure_trade: tables, JSON, and the chosen setting for the node and for
// people.
//
// The functions only return text. measure_trade.cpp opens the files before it measures.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tools/measure_trade/frame_source.h"
#include "tools/measure_trade/trade_arguments.h"
#include "tools/measure_trade/trade_measurement.h"

namespace deformable_contact_monitor {

// Everything that was measured, and what follows from it.
struct TradeResults {
  ExactResults exact;
  std::vector<Measurement> measurements;  // at least one
  std::vector<bool> front;                // whether each measurement is on the Pareto front
  std::optional<std::size_t> chosen;      // index; nothing: no setting keeps the budget
  std::size_t fastest = 0;                // index
  std::vector<std::size_t> as_fast;       // others whose time is within noise of the chosen one's
};

// A row of a table: its columns' names and values, in order.
using TableRow = std::vector<std::pair<std::string, nlohmann::json>>;

// Returns a table of rows, which have the same columns, with a title. There must be a row.
std::string csvTable(const std::vector<TableRow>& rows);

// Returns the same as a list of objects.
nlohmann::json jsonTable(const std::vector<TableRow>& rows);

// Returns the number with the fewest digits that is this float32 when rounded.
double toDecimal(float number);

// Returns what each summary.json begins with: version, command, machine, adjacent pairs, threads
// and bodies.
nlohmann::json summaryHead(const TradeArguments& arguments, const FrameSource& frames);

// Returns a table with a row for each setting. A rate without anything to count, such as the recall
// of self-contacts if there are none, is empty. So is the worst frame if no frame is below 1.
std::string settingsCsv(const TradeResults& results);

// Returns a table with a row for each setting and pair of bodies with a contact in some frame.
// `link` is the rigid body, if one is rigid. If both are the same body, the row is about
// self-contacts.
std::string linksCsv(const TradeResults& results, const FrameSource& frames);

// Returns the content of summary.json.
std::string summaryJson(const TradeArguments& arguments, const TradeResults& results,
                        const FrameSource& frames);

// Returns some lines: which setting was chosen or that none keeps the budget, how noise affects
// that, and whether these are the defaults.
std::string choiceText(const TradeArguments& arguments, const TradeResults& results);

// Returns the chosen setting as parameters of contact_monitor, with a comment that says what was
// measured. If nothing was chosen, returns only the comment.
std::string configYaml(const TradeArguments& arguments, const TradeResults& results,
                       const FrameSource& frames);

}  // namespace deformable_contact_monitor
