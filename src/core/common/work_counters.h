// Sums of a cycle's counters over its parts: over intervals of a motion, or partitions of a scene.
#pragma once

#include <algorithm>

#include "core/detector.h"

namespace deformable_contact_monitor {

// Adds to `sum` what a part counted of its own work. The counters that depend on how the parts
// overlap (rejected, posed, culled, clusters) are left to the caller.
inline void addWork(const Counters& part, Counters& sum) {
  sum.clustered += part.clustered;
  sum.large += part.large;
  sum.cluster_entries += part.cluster_entries;
  sum.largest_cluster = std::max(sum.largest_cluster, part.largest_cluster);
  sum.interval_overlaps += part.interval_overlaps;
  sum.candidates += part.candidates;
  sum.exact += part.exact;
  sum.undecided += part.undecided;
}

}  // namespace deformable_contact_monitor
