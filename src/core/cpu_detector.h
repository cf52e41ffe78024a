// The CPU backend, which runs the stages of detection on threads.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "core/detector.h"
#include "core/export.h"
#include "core/tiling_cache.h"

namespace deformable_contact_monitor {

// What a detector on the CPU may use, and what it shares with others.
struct CpuSettings {
  // Upper bound of the memory for lists of contacts [bytes]. Contacts beyond it are counted
  // (DetectionResult::left_out), but not listed.
  std::uint64_t memory_limit_bytes = std::uint64_t{4} << 30;
  // Tilings of bodies, for Options::nearest. Detectors may share them if one thread at a time runs
  // one of these. Null: the detector makes its own.
  std::shared_ptr<TilingCache> tilings = nullptr;
};

// Makes a detector that runs on threads of its own TBB arena (see Options::threads). A process that
// was forked after detectors had run uses one thread. There, a detector that another thread was
// using at the fork throws BackendError (kUnavailable) in each detect(); the others go on.
DCM_EXPORT std::unique_ptr<Detector> makeCpuDetector(const CpuSettings& settings = CpuSettings());

// Returns a maker of such detectors for a pool (core/detector_pool.h). They share their arrays, so
// that each one after the first takes little memory: some 8 bytes for each vertex. Only one thread
// at a time may use any of them, and a result is valid until one of them runs again.
DCM_EXPORT std::function<std::unique_ptr<Detector>()> cpuDetectorMaker(
    const CpuSettings& settings = CpuSettings());

}  // namespace deformable_contact_monitor
