// The parameters that may change while the monitor runs.
#pragma once

#include <cstddef>
#include <vector>

#include "core/options.h"
#include "monitor/rules/pair_table.h"
#include "monitor/rules/parameters.h"

namespace deformable_contact_monitor {

// Each as in MonitorParameters.
struct LiveParameters {
  double margin_m = 0;  // of every body that has no margin of its own
  double max_rate_hz = 100, robot_rate_hz = 30, marker_rate_hz = 10;
  PairClasses pair_classes;
  Predicates predicates = Predicates::kExact;
  double overlap = 1;
  int clusters = 0, iterations = 1, refresh_period = 1;
};

// What the monitor starts with. A float32 is the decimal number that people wrote: 0.01, and not
// 0.00999999978, which would go back to the parameter server.
LiveParameters startValues(const MonitorParameters& parameters);

// Of so many objects, in their order, and of the robot [Hz].
std::vector<double> maxRatesHz(const LiveParameters& live, std::size_t objects);

// Sets those that are the detector's.
void setOptions(const LiveParameters& live, Options* options);

}  // namespace deformable_contact_monitor
