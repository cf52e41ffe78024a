// What people are told when the detection loop cannot do what they want.
#pragma once

#include <string>
#include <vector>

#include "node/cycle_report.h"
#include "node/monitor_scene.h"
#include "node/pair_table.h"

namespace deformable_contact_monitor {

// Which bodies are UNKNOWN for want of a transform, and why; the first few, one a line.
std::string describeMisses(const TransformReport& transforms);

// Names in rules that are no body's, as often as they stand there, in the order of the rules.
std::vector<std::string> unknownNames(const AllowedContacts& allowed,
                                      const std::vector<BodyStatus>& bodies);

}  // namespace deformable_contact_monitor
