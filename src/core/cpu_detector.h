// The CPU backend: the detector's stages on threads.
#pragma once

#include <cstdint>
#include <memory>

#include "core/detector.h"
#include "core/export.h"

namespace deformable_contact_monitor {

struct CpuSettings {
  // Upper bound of the memory that the lists of contacts may take [bytes]. Beyond it contacts are
  // counted, and left out of the result's list.
  std::uint64_t memory_limit_bytes = std::uint64_t{4} << 30;
};

// On threads of its own arena of TBB: see Options::threads.
DCM_EXPORT std::unique_ptr<Detector> makeCpuDetector(const CpuSettings& settings = CpuSettings());

}  // namespace deformable_contact_monitor
