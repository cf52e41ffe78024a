// How long something takes that is done in every cycle.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <functional>

#include "core/steady_time.h"

namespace deformable_contact_monitor {

// By the last hundred times. One thread at a time.
class UsualTime {
 public:
  // When to begin with it, so that it is done by `deadline`; max() stays.
  SteadyTime earlier(SteadyTime deadline) const {
    if (deadline == SteadyTime::max()) return deadline;
    // The longest alone may be the machine's.
    std::array<SteadyTime::duration, 2> longest;
    std::partial_sort_copy(last_.begin(), last_.end(), longest.begin(), longest.end(),
                           std::greater<>());
    return deadline - longest[1];
  }

  void took(SteadyTime::duration time) {
    last_[next_] = time;
    next_ = (next_ + 1) % last_.size();
  }

  void forget(double share) {
    for (SteadyTime::duration& time : last_) {
      time -= std::chrono::duration_cast<SteadyTime::duration>(time * share);
    }
  }

 private:
  std::array<SteadyTime::duration, 100> last_{};
  std::size_t next_ = 0;
};

}  // namespace deformable_contact_monitor
