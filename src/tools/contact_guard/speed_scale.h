// The rules by which a distance and a closing speed become a speed scale. They need no ROS.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "tools/contact_guard/closing_speed.h"
#include "tools/contact_guard/guard_parameters.h"

namespace deformable_contact_monitor {

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
