// Estimates how fast two bodies approach each other, from their distances at several times, and
// makes a speed scale of a distance and a closing speed.
//
// The distance of two bodies changes by the relative velocity of their nearest points along the
// normal between them, also while the nearest points jump from one place to another. So the slope
// of the distance over time is the closing speed at the nearest points.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "tools/contact_guard/guard_parameters.h"

namespace deformable_contact_monitor {

// What is known of the motion of a pair. Speeds are of the distance [m/s].
struct ClosingEstimate {
  double speed_mps = 0;  // approach; negative: the distance grows
  double error_mps = 0;  // what noise may add to or take from it, from the scatter of the distances

  // Returns the approach that noise allows at most.
  double mostMps() const { return speed_mps + error_mps; }
};

// Holds the distances of one pair within a window of time.
//
// The slope is the median of the slopes between all two samples (Theil and Sen), so a single wrong
// distance hardly changes it. It lags behind a changed speed by half of the window.
class ClosingSpeed {
 public:
  // Adds the distance [m] at a stamp [ns]. A stamp that is not newer than the last one adds nothing
  // if it is equal, and starts anew if it is older. Distances that are not finite start anew.
  // Samples older than `window_s` are dropped, down to the three newest, and all samples that are
  // older than `most_age_s`.
  void add(std::int64_t stamp_ns, double distance_m, double window_s, double most_age_s);

  void clear() { samples_.clear(); }

  // Returns nothing with fewer than three samples.
  std::optional<ClosingEstimate> estimate() const;

  // Returns whether the distance certainly grows: no approach is left when noise is allowed for,
  // and no distance in the window is larger than the newest. So a pair that turns back counts as
  // leaving no longer at the first state that shows it.
  bool isLeaving() const;

  // Return the time from the oldest to the newest sample; both 0 without samples.
  std::int64_t oldestNs() const { return samples_.empty() ? 0 : samples_.front().stamp_ns; }
  std::int64_t newestNs() const { return samples_.empty() ? 0 : samples_.back().stamp_ns; }

 private:
  struct Sample {
    std::int64_t stamp_ns;
    double distance_m;
  };
  struct Line {
    double slope_mps, scatter_m;
  };

  std::optional<Line> line() const;

  std::deque<Sample> samples_;  // ascending by stamp
};

// Returns the scale in [0, 1] that a distance [m] allows: 1 from slow_distance_m on, and
// `least_scale` at stop_distance_m, where the guard stops anyway. It never falls with the distance.
double scaleByDistance(double distance_m, const GuardParameters& parameters);

// Returns the scale in [0, 1] with which the pair would be at stop_distance_m after
// time_to_contact_s, if it approaches at `closing_mps` at full speed; at least `least_scale`. It
// never falls with the distance, and never rises with the closing speed. 1 if time_to_contact_s
// is 0.
double scaleByTime(double distance_m, double closing_mps, const GuardParameters& parameters);

// Returns the closing speed that the pair would have at full speed [m/s]. What is measured has been
// scaled already, by `scale` on average, so it is divided by that. fastest_closing_mps if nothing
// was measured or the robot hardly moved; otherwise at most that, or what was measured.
double closingAtFullSpeed(const std::optional<ClosingEstimate>& measured, double scale,
                          const GuardParameters& parameters);

// The scales that were published, by their time. Before the first one the scale was 0: controllers
// do not move without a guard.
class ScaleHistory {
 public:
  // Adds a scale that holds from this time on [ns]. Times ascend; an older time starts anew.
  void add(std::int64_t time_ns, double scale);

  // Returns the mean over this time [ns]. `to_ns` must not be before `from_ns`.
  double mean(std::int64_t from_ns, std::int64_t to_ns) const;

  // Forgets what ended before this time [ns].
  void dropBefore(std::int64_t time_ns);

 private:
  struct Entry {
    std::int64_t time_ns;
    double scale;
  };

  std::deque<Entry> entries_;
};

}  // namespace deformable_contact_monitor
