// A cycle of the CPU backend held against brute force.
#pragma once

#include "core/detector.h"

namespace deformable_contact_monitor {

// Detects with `detector` and, if the scene is small, with brute force; a result that its options
// do not allow is a finding. Exact: pairs, separations and counts equal brute force's, bit by bit;
// with an overlap below 1 or a stop, they are some of them. Conservative: all of them, and what is
// more is counted as undecided.
// Returns the detector's result; what detect() throws comes through.
const DetectionResult& detectChecked(Detector* detector, const Scene& scene,
                                     const Options& options);

}  // namespace deformable_contact_monitor
