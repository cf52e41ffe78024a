// Deadlines for who ends late.
#pragma once

#include <algorithm>
#include <chrono>

#include "core/steady_time.h"

namespace deformable_contact_monitor {

// Of one detector: it gives up some time after its deadline, about as long in each cycle. One thread
// at a time.
class LateEnds {
 public:
  // What to tell it, so that it ends by `deadline`.
  SteadyTime earlier(SteadyTime deadline) const {
    return deadline == SteadyTime::max() ? deadline : deadline - late_;
  }

  // It was told `deadline`, and has just ended.
  void ended(SteadyTime deadline) {
    constexpr double kForget = 0.995;  // so that it is tried again, once in some hundred cycles
    late_ = std::chrono::duration_cast<SteadyTime::duration>(late_ * kForget);
    if (deadline == SteadyTime::max()) return;
    late_ = std::max(late_, std::chrono::steady_clock::now() - deadline);
  }

 private:
  SteadyTime::duration late_{0};
};

}  // namespace deformable_contact_monitor
