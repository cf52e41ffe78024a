// Measures wall time.
#pragma once

#include <chrono>

namespace deformable_contact_monitor {

// Runs from its construction. One thread at a time.
class Stopwatch {
 public:
  // Returns the time since the construction or the last lap [ms].
  double elapsedMs() const { return milliseconds(Clock::now() - start_); }

  // Returns the same, and starts a new lap.
  double lapMs() {
    const Clock::time_point now = Clock::now();
    const double ms = milliseconds(now - start_);
    start_ = now;
    return ms;
  }

 private:
  using Clock = std::chrono::steady_clock;

  static double milliseconds(Clock::duration d) {
    return std::chrono::duration<double, std::milli>(d).count();
  }

  Clock::time_point start_ = Clock::now();
};

}  // namespace deformable_contact_monitor
