// The parameters that may change while the monitor runs.
#include "node/live_parameters.h"

namespace deformable_contact_monitor {

LiveParameters startValues(const MonitorParameters& parameters) {
  LiveParameters live;
  live.margin_m = parameters.margin_m;
  live.max_rate_hz = parameters.max_rate_hz;
  live.robot_rate_hz = parameters.robot_rate_hz;
  live.marker_rate_hz = parameters.marker_rate_hz;
  live.pair_classes = parameters.pair_classes;
  live.predicates = parameters.detector.predicates;
  live.overlap = parameters.detector.overlap;
  live.clusters = parameters.detector.clusters;
  live.iterations = parameters.detector.iterations;
  live.refresh_period = parameters.detector.refresh_period;
  return live;
}

std::vector<double> maxRatesHz(const LiveParameters& live, std::size_t objects) {
  std::vector<double> rates_hz(objects, live.max_rate_hz);
  rates_hz.push_back(live.robot_rate_hz);
  return rates_hz;
}

void setOptions(const LiveParameters& live, Options* options) {
  options->predicates = live.predicates;
  options->overlap = live.overlap;
  options->clusters = live.clusters;
  options->iterations = live.iterations;
  options->refresh_period = live.refresh_period;
}

}  // namespace deformable_contact_monitor
