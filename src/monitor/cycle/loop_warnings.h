// What people are told when the detection loop cannot do what they want.
#pragma once

#include <string>
#include <vector>

#include "monitor/cycle/monitor_scene.h"
#include "monitor/cycle_report.h"
#include "monitor/rules/pair_table.h"
#include "monitor/rules/parameters.h"

namespace deformable_contact_monitor {

// Which bodies are UNKNOWN for want of a transform, and why; the first few, one a line.
std::string describeMisses(const TransformReport& transforms);

// A line for each name that is no body's, with the nearest that is: of the rules, and of the
// parameters' link_margin_m. The first few, and how many more.
std::vector<std::string> describeUnknownNames(const MonitorParameters& parameters,
                                              const AllowedContacts& allowed,
                                              const std::vector<BodyStatus>& bodies);

}  // namespace deformable_contact_monitor
