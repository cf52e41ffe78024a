// From what each of several devices found in its share to the result of the cycle.
#pragma once

#include <vector>

#include "core/detector.h"

namespace deformable_contact_monitor {

// Into `whole`, which has begun its cycle: the union of the lists, which have no contact in common,
// in their order. Work adds up, and triangles that reach into several shares count in each; times
// are those of the device that took longest.
void mergeShares(const std::vector<const DetectionResult*>& shares, DetectionResult& whole);

}  // namespace deformable_contact_monitor
