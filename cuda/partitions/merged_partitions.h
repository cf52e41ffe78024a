// Merges the results of several devices, each of one partition, into the result of the cycle.
#pragma once

#include <vector>

#include "core/detector.h"

namespace deformable_contact_monitor {

// Merges `partitions` into `whole`, for which DetectionResult::begin() was called. The lists of the
// partitions must be sorted and have no contact in common; the merged list is sorted too. Counters
// of work add up, so a triangle that reaches into several partitions counts in each of them. Times
// are those of the device that took longest [ms].
void mergePartitions(const std::vector<const DetectionResult*>& partitions, DetectionResult& whole);

}  // namespace deformable_contact_monitor
