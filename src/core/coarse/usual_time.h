// How long something takes that is done in every cycle.
#pragma once

#include <algorithm>
#include <chrono>

#include "core/steady_time.h"

namespace deformable_contact_monitor {

// One thread at a time.
class UsualTime {
 public:
  // When to begin with it, so that it is done by `deadline`; max() stays.
  SteadyTime earlier(SteadyTime deadline) const {
    return deadline == SteadyTime::max() ? deadline : deadline - std::min(last_[0], last_[1]);
  }

  void took(SteadyTime::duration time) {
    last_[0] = last_[1];
    last_[1] = time;
  }

  void forget(double share) {
    for (SteadyTime::duration& time : last_) {
      time -= std::chrono::duration_cast<SteadyTime::duration>(time * share);
    }
  }

 private:
  // The less counts: one alone may be the machine's.
  SteadyTime::duration last_[2] = {SteadyTime::duration(0), SteadyTime::duration(0)};
};

}  // namespace deformable_contact_monitor
