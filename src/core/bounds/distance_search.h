// Finds how far the bodies of a scene are from each other, and where they are nearest.
#pragma once

#include "core/common/cycle_limit.h"
#include "core/detector.h"
#include "core/options.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// One per detector; one thread at a time calls it, and it uses the threads of the TBB arena in
// which it is called.
class DistanceSearch {
 public:
  // Fills result.nearest if options.nearest is set, and adds to result.counters. The contacts of
  // the cycle must be in the result. Once the limit is over, pairs may be missing. The vertices of
  // the scene must be on the host.
  void find(const Scene& scene, const Options& options, const CycleLimit& limit,
            DetectionResult& result);
};

}  // namespace deformable_contact_monitor
