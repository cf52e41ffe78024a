// Deadlines for who ends late.
#pragma once

#include <chrono>

#include "core/bounds/usual_time.h"
#include "core/steady_time.h"

namespace deformable_contact_monitor {

// Of one detector, which gives up some time after its deadline, about as long in each cycle. One
// thread at a time.
class LateEnds {
 public:
  // What to tell it now, so that it ends by `deadline`.
  SteadyTime earlier(SteadyTime deadline) { return told_ = late_.earlier(deadline); }

  // It was told that, began at `begin` and has just ended.
  void ended(SteadyTime begin) {
    if (told_ == SteadyTime::max()) return;
    const SteadyTime now = std::chrono::steady_clock::now();
    if (begin < told_ && now > told_) {
      late_.took(now - told_);
    } else {
      // It had no time at all, or enough: so that it is tried again, once in some hundred cycles.
      late_.forget(0.005);
    }
  }

 private:
  SteadyTime told_ = SteadyTime::max();
  UsualTime late_;
};

}  // namespace deformable_contact_monitor
