// Estimates how fast two bodies approach each other, from their distances at several times.
//
// The distance of two bodies changes by the relative velocity of their nearest points along the
// normal between them, also while the nearest points jump from one place to another. So the slope
// of the distance over time is the closing speed at the nearest points.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

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
  // and the newest distance is not below an earlier one by more than the scatter of the others. So
  // a pair that turns back counts as leaving no longer at the first state that shows it.
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

}  // namespace deformable_contact_monitor
