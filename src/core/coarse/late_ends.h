// Deadlines for who ends late.
#pragma once

#include <algorithm>
#include <chrono>

#include "core/steady_time.h"

namespace deformable_contact_monitor {

// Of one detector, which gives up some time after its deadline, about as long in each cycle. One
// thread at a time.
class LateEnds {
 public:
  // What to tell it now, so that it ends by `deadline`.
  SteadyTime earlier(SteadyTime deadline) {
    if (deadline == SteadyTime::max()) return told_ = deadline;
    return told_ = deadline - std::min(late_[0], late_[1]);
  }

  // It was told that, began at `begin` and has just ended.
  void ended(SteadyTime begin) {
    if (told_ == SteadyTime::max()) return;
    const SteadyTime now = std::chrono::steady_clock::now();
    if (begin < told_ && now > told_) {
      late_[0] = late_[1];
      late_[1] = now - told_;
      return;
    }
    // It had no time at all, or enough: so that it is tried again, once in some hundred cycles.
    constexpr double kForget = 0.995;
    for (SteadyTime::duration& late : late_) {
      late = std::chrono::duration_cast<SteadyTime::duration>(late * kForget);
    }
  }

 private:
  SteadyTime told_ = SteadyTime::max();
  // The last two times. The less counts: one alone may be the machine's.
  SteadyTime::duration late_[2] = {SteadyTime::duration(0), SteadyTime::duration(0)};
};

}  // namespace deformable_contact_monitor
