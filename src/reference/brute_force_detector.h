// A detector that compares every pair of triangles with the same predicates and margins. It is slow
// and simple; tests compare the backends with it.
#pragma once

#include <memory>

#include "core/detector.h"

namespace deformable_contact_monitor {

// Returns a detector for discrete and continuous detection, with margins and pads. It ignores
// `tolerance_m`. It uses one thread, and its time grows with the product of the triangle counts.
// The vertices of bodies must be on the host.
std::unique_ptr<Detector> makeBruteForceDetector();

}  // namespace deformable_contact_monitor
