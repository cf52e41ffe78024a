// What of one body of a pair lies within the other.
#pragma once

#include <cstdint>

#include "core/vector3.h"
#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

struct InsideParts {
  std::uint8_t which = 0;  // ContactState::inside; parts of both within the other: 1
  Vec3d centroid;          // mean of the parts' own [m]; zero where there is none

  bool any() const { return which != 0; }
};

// None where it was not looked for.
InsideParts insidePartsOf(const CycleReport& report, const MonitoredPair& pair);

}  // namespace deformable_contact_monitor
