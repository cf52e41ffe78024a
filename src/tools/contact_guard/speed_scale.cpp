#include "tools/contact_guard/speed_scale.h"

#include <algorithm>
#include <cstddef>

namespace deformable_contact_monitor {

double scaleByDistance(double distance_m, const GuardParameters& parameters) {
  if (!(distance_m < parameters.slow_distance_m)) return 1;
  if (distance_m <= parameters.stop_distance_m) return parameters.least_scale;
  const double range_m = parameters.slow_distance_m - parameters.stop_distance_m;
  const double share = (distance_m - parameters.stop_distance_m) / range_m;
  return std::min(1.0, parameters.least_scale + (1 - parameters.least_scale) * share);
}

double scaleByTime(double distance_m, double closing_mps, const GuardParameters& parameters) {
  if (parameters.time_to_contact_s == 0) return 1;
  const double left_m = std::max(0.0, distance_m - parameters.stop_distance_m);
  const double way_m = closing_mps * parameters.time_to_contact_s;
  if (!(way_m > left_m)) return 1;
  return std::max(parameters.least_scale, left_m / way_m);
}

double closingAtFullSpeed(const std::optional<ClosingEstimate>& measured, double scale,
                          const GuardParameters& parameters) {
  constexpr double kHardlyMoves = 0.05;
  const double fastest_mps = parameters.fastest_closing_mps;
  if (!measured) return fastest_mps;
  const double most_mps = measured->mostMps();
  if (most_mps <= 0) return most_mps;
  if (scale < kHardlyMoves) return std::max(most_mps, fastest_mps);
  return std::max(most_mps, std::min(most_mps / scale, fastest_mps));
}

void ScaleHistory::add(std::int64_t time_ns, double scale) {
  if (!entries_.empty() && time_ns < entries_.back().time_ns) entries_.clear();
  if (!entries_.empty() && entries_.back().scale == scale) return;
  entries_.push_back({time_ns, scale});
}

double ScaleHistory::mean(std::int64_t from_ns, std::int64_t to_ns) const {
  double sum = 0;
  double at_end = 0;
  for (std::size_t i = 0; i < entries_.size() && entries_[i].time_ns <= to_ns; ++i) {
    at_end = entries_[i].scale;
    const bool is_last = i + 1 == entries_.size();
    const std::int64_t begin_ns = std::max(entries_[i].time_ns, from_ns);
    const std::int64_t end_ns = is_last ? to_ns : std::min(entries_[i + 1].time_ns, to_ns);
    if (end_ns > begin_ns) sum += static_cast<double>(end_ns - begin_ns) * entries_[i].scale;
  }
  return to_ns > from_ns ? sum / static_cast<double>(to_ns - from_ns) : at_end;
}

void ScaleHistory::dropBefore(std::int64_t time_ns) {
  while (entries_.size() > 1 && entries_[1].time_ns <= time_ns) entries_.pop_front();
}

}  // namespace deformable_contact_monitor
