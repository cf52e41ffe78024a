// What each of measure_trade's summaries begins with.
#pragma once

#include <nlohmann/json.hpp>

#include "tools/measure_trade/frame_source.h"
#include "tools/measure_trade/trade_arguments.h"

namespace deformable_contact_monitor {

// Version, command, machine, bodies, neighbours, threads.
nlohmann::json summaryHead(const TradeArguments& arguments, const FrameSource& frames);

}  // namespace deformable_contact_monitor
