// A detector that stays warm while scenes with different enabled pairs take turns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

#include "core/detector.h"
#include "core/export.h"

namespace deformable_contact_monitor {

// Up to where a new set of pairs has a new detector.
struct PairSetLimits {
  std::size_t detectors = 128;
  std::uint64_t memory_bytes = std::uint64_t{4} << 30;  // DetectionResult::memory_bytes, together
};

// Runs each set of enabled pairs, in each kind of motion, on a detector of its own, for what one
// left for its next cycle (prototypes, arrays, the scene on a device) is of no use to another. The
// first is made at once, others when their set first comes; beyond the limits a new set takes over
// the detector whose last cycle is the longest ago. What `make` and the detectors throw goes to the
// caller.
DCM_EXPORT std::unique_ptr<Detector> makePairSetDetector(
    std::function<std::unique_ptr<Detector>()> make, const PairSetLimits& limits = PairSetLimits());

}  // namespace deformable_contact_monitor
