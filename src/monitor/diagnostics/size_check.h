// Deformable bodies whose size or distance cannot be meant: a mesh in millimetres, say.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/steady_time.h"
#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

// One thread at a time. Reads no clock.
class SizeCheck {
 public:
  // An object's name, and what is odd about it; empty: nothing.
  using Finding = std::pair<std::string, std::string>;

  // Looks at the objects whose cycle it is, each once a second at most, beside the links that were
  // posed for it: odd is what is 100 times the robot, or so far away from it. Without a posed link
  // there is nothing to compare with, and no finding.
  std::vector<Finding> look(const CycleReport& report, SteadyTime now);

 private:
  std::map<std::string, SteadyTime> due_;  // by object
};

}  // namespace deformable_contact_monitor
