// The detector that programs use: it keeps a warm detector for each set of enabled pairs, falls
// back to the CPU when a device fails, and bounds distances where exact contacts take too long.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "core/backend_choice.h"
#include "core/detector.h"
#include "core/export.h"
#include "core/steady_time.h"
#include "core/tiling_cache.h"

namespace deformable_contact_monitor {

using DetectorMaker = std::function<std::unique_ptr<Detector>()>;

// When a device that failed is tried again: after `first_s`, and after twice as long each time that
// it fails again, up to `most_s`. The wait starts over at `first_s` once the device has worked for
// as long as the last wait.
struct RetryTimes {
  double first_s = 5;
  double most_s = 60;
  std::function<SteadyTime()> now = std::chrono::steady_clock::now;
};

// The backends of a pool, and what happens when the device fails.
struct PoolSettings {
  // Makes detectors on a device such as a GPU. Empty: the CPU does everything.
  DetectorMaker device;
  // Makes detectors on the CPU; cpuDetectorMaker() (core/cpu_detector.h) makes them share their
  // arrays. Empty: what `device` and its detectors throw goes to the caller.
  // At least one of the two makers must be there.
  DetectorMaker cpu;

  // Is called with the device's state when that changes, also when it works again, from within
  // makeDetectorPool() or detect(). May be empty.
  std::function<void(const BackendState&)> changed;
  // When a device that failed is tried again. Empty: never.
  std::optional<RetryTimes> retry;

  // A new set of pairs has no detector of its own once there are `most_detectors`, or once all of
  // the backend's detectors together use `memory_bytes` (DetectionResult::detector_bytes, which is
  // 0 on the CPU). It then takes over the detector that has been idle longest.
  std::size_t most_detectors = 128;
  std::uint64_t memory_bytes = std::uint64_t{4} << 30;

  // Tilings of bodies for detection within bounds on the CPU. Null: it is always exact there.
  std::shared_ptr<TilingCache> tilings;
};

// Makes a pool. All of its detectors live as long as it does.
//
// Sets of pairs. Each set of enabled pairs, in each kind of motion, runs on a detector of its own,
// because what a detector keeps from cycle to cycle (prototypes, arrays, the scene on a device) is
// useful to the same pairs alone. The first detector is made at once, so that a maker that fails
// does so here. Others are made when their set first comes.
//
// Failures. If the device's maker or detector throws a std::runtime_error and there is a CPU maker,
// the CPU runs that same cycle. What follows depends on BackendError::fault(); any other
// std::runtime_error counts as kTransient.
// - kTransient: the device's detectors are destroyed, and made again at the retry time. Without a
//   CPU maker, the next detect() makes a new one in the place of the one that failed.
// - kSticky, kUnavailable: the device is never used again.
// - kSceneTooLarge: the device still runs scenes with fewer triangles in bodies that take part, and
//   larger ones from the retry time on.
// std::invalid_argument goes to the caller and changes nothing.
//
// Bounds. With `tilings`, the CPU decides pairs of two bodies by bounds of their tiles
// (core/tiling.h) and sets DetectionResult::distances, for decide() (core/body_distance.h), if
// motion is instant and
// - options.tolerance_m is above 0: each pair is refined until it is decided. Only contacts that
//   were found on the way are listed, so `guaranteed` is false.
// - or options.limits.deadline is set: pairs take turns, the most doubtful tiles first. With
//   tolerance 0 their contacts are listed afterwards, as long as there is time. If the deadline
//   comes first, the result is cut off, and each pair has what is certain by then.
// With options.nearest, the same search goes on until the nearest pair is exact, or with a
// tolerance until the pair is decided. DetectionResult::nearest has the pairs that are exact.
// Contacts are those that touch, unless options.near_pairs is set. With a tolerance, which pairs
// are exact may depend on earlier cycles. A body with itself is always detected exactly, and so are
// pairs of bodies whose tiling is not made yet or whose vertices are on a device. They get the time
// that the other pairs leave. Bounds are exact whatever options.predicates and options.overlap are.
// Without a deadline the result does not depend on the number of threads. The cache is used by one
// thread at a time, the one in detect().
//
// Forks. A forked process may use and destroy the pool. It detects on one thread of the CPU (see
// makeCpuDetector()), and makes tilings of its own. A pool that another thread was using at the
// fork throws BackendError (kUnavailable) there.
//
// backend() names the one that ran last. vertexMemory() is the device's while there is one.
DCM_EXPORT std::unique_ptr<Detector> makeDetectorPool(PoolSettings settings);

}  // namespace deformable_contact_monitor
