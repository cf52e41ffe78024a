// Limits that end a detection cycle early.
#pragma once

#include <atomic>

#include "core/steady_time.h"

namespace deformable_contact_monitor {

// The reason for a cycle that ended early because of its deadline
// (DetectionResult::cut_off_because).
constexpr const char* kNoTime = "no time";

// By default a cycle has no limit, and results are the same from run to run. When a limit is
// reached, the detector gives up within some 10 ms (up to 60 ms at two million triangles) and sets
// DetectionResult::cut_off.
struct Limits {
  SteadyTime deadline = SteadyTime::max();  // max(): there is none
  // The cycle ends once this is true. Any thread may set it. It must outlive the detection. Null:
  // there is none.
  const std::atomic<bool>* stop = nullptr;

  bool any() const { return stop != nullptr || deadline != SteadyTime::max(); }
};

}  // namespace deformable_contact_monitor
