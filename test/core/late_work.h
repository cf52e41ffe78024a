// What a detector does after its deadline.
#pragma once

#include <gtest/gtest.h>
#include <time.h>

#include <chrono>
#include <future>
#include <string>
#include <thread>

#include "core/cpu_detector.h"
#include "core/detector.h"
#include "core/scene.h"
#include "scenes.h"

namespace deformable_contact_monitor {

// The clock for a backend: processor time of this process, which other programs on the machine
// hardly change, or on CUDA, whose kernels take none, elapsed time.
inline double timeOnMs(const std::string& backend) {
  using Milliseconds = std::chrono::duration<double, std::milli>;
  using Clock = std::chrono::steady_clock;
  if (backend == "cuda") return Milliseconds(Clock::now().time_since_epoch()).count();
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

// Detects, and sets `late_ms` to what was done after the deadline, by timeOnMs(). If there is none,
// to what was done at all.
inline const DetectionResult& detectLate(Detector& detector, const Scene& scene,
                                         const Options& options, double* late_ms) {
  double at_deadline = timeOnMs(detector.backend());
  std::promise<void> done;
  std::thread watch;
  if (options.limits.deadline != SteadyTime::max()) {
    watch = std::thread([&, is_done = done.get_future()] {
      is_done.wait_until(options.limits.deadline);
      at_deadline = timeOnMs(detector.backend());
    });
  }
  const DetectionResult& result = detector.detect(scene, options);
  const double at_end = timeOnMs(detector.backend());
  done.set_value();
  if (watch.joinable()) watch.join();
  *late_ms = at_end - at_deadline;
  return result;
}

// Says whether that is little. Without limits the scenes of these tests take many seconds. A build
// may be slow, and so may a busy machine; then a cloth of 720 000 triangles takes more than half a
// second, too, and that is the measure.
inline testing::AssertionResult isLittle(double late_ms) {
  constexpr double kLittleMs = 500;
  if (late_ms < kLittleMs) return testing::AssertionSuccess();
  const Scene cloth = selfScene(clothGrid(600, 1, 0, 0));
  const double start = timeOnMs("cpu");
  makeCpuDetector()->detect(cloth, Options());
  const double cloth_ms = timeOnMs("cpu") - start;
  if (late_ms < cloth_ms) return testing::AssertionSuccess();
  return testing::AssertionFailure()
         << late_ms << " ms after the deadline, where a cloth takes " << cloth_ms << " ms";
}

}  // namespace deformable_contact_monitor
