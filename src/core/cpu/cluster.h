// Stage `cluster`: the prototypes follow the scene.
#pragma once

#include <vector>

#include "core/common/cycle_limit.h"
#include "core/cpu/prototypes.h"
#include "core/cpu/size_split.h"
#include "core/cpu/transform.h"
#include "core/options.h"
#include "core/rules/sampling.h"

namespace deformable_contact_monitor {

// Centroids of the regular triangles that the sampling of their list asks for, in its order
// [scaled]; of what moves, halfway.
template <class Hull = Triangle>
std::vector<Vec3f> sampleCentroids(const WorkingSet& set, const SizeSplit& split,
                                   const Sampling& sampling);

// Keeps the prototypes from cycle to cycle.
class PrototypeTracker {
 public:
  // The next cycle starts cold.
  void clear() { prototypes_.clear(); }

  // Fuzzy c-means on a sample of the centroids, from last cycle's prototypes if there are as many
  // as wanted; between refreshes the prototypes stay where they are in the scene. Where the limit
  // was over, they stay too, and `searchable` is of no use. Whether it started from nothing.
  // Hull: as in hull.h.
  template <class Hull>
  bool update(const WorkingSet& set, const SizeSplit& split, const Options& options,
              const CycleLimit& limit, Prototypes& searchable);

 private:
  std::vector<Vec3d> prototypes_;  // scene frame [m], as at the end of the step
  int cycles_since_refresh_ = 0;
};

}  // namespace deformable_contact_monitor
