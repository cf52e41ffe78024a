#include "tools/contact_guard/closing_speed.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "tools/common/sample_statistics.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kLeastSamples = 3;
constexpr std::size_t kMostSamples = 32;  // bounds the work at high rates
constexpr double kNanosecond = 1e-9;

}  // namespace

void ClosingSpeed::add(std::int64_t stamp_ns, double distance_m, double window_s,
                       double most_age_s) {
  if (!std::isfinite(distance_m)) return clear();
  if (!samples_.empty()) {
    if (stamp_ns == newestNs()) return;
    if (stamp_ns < newestNs()) clear();
  }
  samples_.push_back({stamp_ns, distance_m});
  const auto age_s = [&] { return static_cast<double>(stamp_ns - oldestNs()) * kNanosecond; };
  while (samples_.size() > kMostSamples ||
         (samples_.size() > kLeastSamples && age_s() > window_s) || age_s() > most_age_s) {
    samples_.pop_front();
  }
}

// Fits a line. The scatter is twice the median distance of the samples from it.
std::optional<ClosingSpeed::Line> ClosingSpeed::line() const {
  if (samples_.size() < kLeastSamples) return std::nullopt;
  const auto timeOf = [this](const Sample& sample) {
    return static_cast<double>(sample.stamp_ns - oldestNs()) * kNanosecond;
  };
  std::vector<double> values;
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    for (std::size_t j = i + 1; j < samples_.size(); ++j) {
      const double change_m = samples_[j].distance_m - samples_[i].distance_m;
      values.push_back(change_m / (timeOf(samples_[j]) - timeOf(samples_[i])));
    }
  }
  Line line{median(values), 0};
  values.clear();
  for (const Sample& sample : samples_) {
    values.push_back(sample.distance_m - line.slope_mps * timeOf(sample));
  }
  const double start_m = median(values);
  for (double& value : values) value = std::abs(value - start_m);
  line.scatter_m = 2 * median(values);
  return line;
}

// Noise that is spread evenly changes the slope by less than this in about 95 of 100 windows of
// seven samples.
std::optional<ClosingEstimate> ClosingSpeed::estimate() const {
  const std::optional<Line> fit = line();
  if (!fit) return std::nullopt;
  const double span_s = static_cast<double>(newestNs() - oldestNs()) * kNanosecond;
  return ClosingEstimate{-fit->slope_mps, 3 * fit->scatter_m / span_s};
}

bool ClosingSpeed::isLeaving() const {
  const std::optional<ClosingEstimate> found = estimate();
  if (!found || found->mostMps() >= 0) return false;
  // A turn bends the distances, which looks like scatter; so none is allowed for here.
  return std::all_of(samples_.begin(), samples_.end(), [this](const Sample& sample) {
    return sample.distance_m <= samples_.back().distance_m;
  });
}

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
