// When a cycle is to end early.
#pragma once

#include <atomic>
#include <chrono>

namespace deformable_contact_monitor {

// By default never: then results are the same from run to run. Else the detector gives up within
// some 10 ms and says so in its result (DetectionResult::cut_off).
struct Limits {
  std::chrono::steady_clock::time_point deadline =
      std::chrono::steady_clock::time_point::max();  // max(): none
  // The cycle ends once it is true, which any thread may set; it outlives the detection. Null:
  // none.
  const std::atomic<bool>* stop = nullptr;

  bool any() const {
    return stop != nullptr || deadline != std::chrono::steady_clock::time_point::max();
  }
};

}  // namespace deformable_contact_monitor
