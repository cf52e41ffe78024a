// A detector that does not fail while another backend is left.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/backend_error.h"
#include "core/detector.h"
#include "core/export.h"
#include "core/steady_time.h"

namespace deformable_contact_monitor {

using DetectorMaker = std::function<std::unique_ptr<Detector>()>;

// Why the first backend is not used, or not for every scene.
struct DCM_EXPORT BackendState {
  std::string problem;  // one line; empty: there is none
  BackendFault fault = BackendFault::kTransient;
  bool tried_again = false;  // it may come back by itself
  bool partly = false;       // it goes on, but without a device of several, for that problem
};

// When a backend that failed is tried again: after `first_s`, then after twice as long each time
// that it fails again, up to `most_s`. It starts over after it worked for as long as it had been
// left alone.
struct RetryTimes {
  double first_s = 5;
  double most_s = 60;
  std::function<SteadyTime()> now = std::chrono::steady_clock::now;
};

// Runs what `first` makes. A cycle for which that fails to be made or to detect, with a
// std::runtime_error, is run by what `second` makes. What happens then goes by
// BackendError::fault(); any other std::runtime_error counts as kTransient.
// kTransient: what was made is thrown away; `first` makes another at the retry time.
// kSticky, kUnavailable: the change is for good.
// kSceneTooLarge: scenes of fewer triangles in bodies that take part go on with the first, others
// only from the retry time on.
// Without retry times, every change is for good.
// `changed` is told of the state when it changes, so also when there is no problem any more, from
// within this call or detect(); it may be empty. backend() is the one that ran last.
DCM_EXPORT std::unique_ptr<Detector> makeFallbackDetector(
    DetectorMaker first, DetectorMaker second, std::function<void(const BackendState&)> changed,
    std::optional<RetryTimes> retry = std::nullopt);

}  // namespace deformable_contact_monitor
