// When a cycle is to end early.
#pragma once

#include <atomic>

#include "core/steady_time.h"

namespace deformable_contact_monitor {

// Why a cycle ended early (DetectionResult::cut_off_because): its deadline had come.
constexpr const char* kNoTime = "no time";

// By default never: then results are the same from run to run. Else the detector gives up within
// some 10 ms and says so in its result (DetectionResult::cut_off).
struct Limits {
  SteadyTime deadline = SteadyTime::max();  // max(): none
  // The cycle ends once it is true, which any thread may set; it outlives the detection. Null:
  // none.
  const std::atomic<bool>* stop = nullptr;

  bool any() const { return stop != nullptr || deadline != SteadyTime::max(); }
};

}  // namespace deformable_contact_monitor
