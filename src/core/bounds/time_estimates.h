// Estimates, from earlier cycles, of how early a step of a cycle must begin or end so that the
// cycle keeps its deadline. One thread at a time uses each of them.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <functional>

#include "core/steady_time.h"

namespace deformable_contact_monitor {

// Estimates the time of something that is done in every cycle, from its last hundred times.
class UsualTime {
 public:
  // Returns when to begin it so that it is done by `deadline`. Returns SteadyTime::max() if that is
  // the deadline.
  SteadyTime earlier(SteadyTime deadline) const {
    if (deadline == SteadyTime::max()) return deadline;
    // Takes the second longest: the longest may be the fault of the operating system.
    std::array<SteadyTime::duration, 2> longest;
    std::partial_sort_copy(last_.begin(), last_.end(), longest.begin(), longest.end(),
                           std::greater<>());
    return deadline - longest[1];
  }

  // Records how long it took this time.
  void took(SteadyTime::duration time) {
    last_[next_] = time;
    next_ = (next_ + 1) % last_.size();
  }

  // Shortens all recorded times by a part of themselves, in [0, 1].
  void shorten(double part) {
    for (SteadyTime::duration& time : last_) {
      time -= std::chrono::duration_cast<SteadyTime::duration>(time * part);
    }
  }

 private:
  std::array<SteadyTime::duration, 100> last_{};
  std::size_t next_ = 0;
};

// Estimates how late a detector ends: it notices its deadline some time after that has passed,
// about as long in each cycle.
class LateEnds {
 public:
  // Returns the deadline to give to the detector now, so that it ends by `deadline`.
  SteadyTime earlier(SteadyTime deadline) { return given_ = lateness_.earlier(deadline); }

  // Records that the detector, which had that deadline and began at `begin`, has just ended.
  void ended(SteadyTime begin) {
    if (given_ == SteadyTime::max()) return;
    const SteadyTime now = std::chrono::steady_clock::now();
    if (begin < given_ && now > given_) {
      lateness_.took(now - given_);
    } else {
      // The detector had no time at all, or enough. So the estimate shrinks, and a detector that
      // got no time is given some again after a few hundred cycles.
      lateness_.shorten(0.005);
    }
  }

 private:
  SteadyTime given_ = SteadyTime::max();
  UsualTime lateness_;
};

}  // namespace deformable_contact_monitor
