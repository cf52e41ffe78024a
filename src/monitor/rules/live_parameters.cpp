// The parameters that may change while the monitor runs.
#include "monitor/rules/live_parameters.h"

#include <cstdio>
#include <cstdlib>

namespace deformable_contact_monitor {
namespace {

// The shortest that is this float32.
double toDecimal(float number) {
  double decimal = number;
  for (int digits = 6; digits <= 9; ++digits) {
    char text[32];
    std::snprintf(text, sizeof(text), "%.*g", digits, static_cast<double>(number));
    decimal = std::strtod(text, nullptr);
    if (static_cast<float>(decimal) == number) break;
  }
  return decimal;
}

}  // namespace

LiveParameters startValues(const MonitorParameters& parameters) {
  LiveParameters live;
  live.margin_m = toDecimal(parameters.margin_m);
  live.max_rate_hz = parameters.max_rate_hz;
  live.robot_rate_hz = parameters.robot_rate_hz;
  live.marker_rate_hz = parameters.marker_rate_hz;
  live.pair_classes = parameters.pair_classes;
  live.predicates = parameters.detector.predicates;
  live.overlap = toDecimal(parameters.detector.overlap);
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
  options->overlap = static_cast<float>(live.overlap);
  options->clusters = live.clusters;
  options->iterations = live.iterations;
  options->refresh_period = live.refresh_period;
}

}  // namespace deformable_contact_monitor
