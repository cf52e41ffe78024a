// Contacts within a stated distance error, and within a stated time.
#pragma once

#include <memory>

#include "core/detector.h"
#include "core/export.h"

namespace deformable_contact_monitor {

// Where options.tolerance_m is above 0, decides pairs of two bodies by bounds of their tiles
// (tiling.h), as far down as it takes, and gives DetectionResult::distances; bodies with themselves,
// and bodies whose tiling is not made yet, go to `exact`. Where limits.deadline is set, the pairs
// take turns, the most doubtful tiles first, until it has come. Else as `exact` does it.
// Swept motion goes to `exact`.
DCM_EXPORT std::unique_ptr<Detector> makeBoundedDetector(std::unique_ptr<Detector> exact);

}  // namespace deformable_contact_monitor
