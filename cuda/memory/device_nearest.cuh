// Says on the device which nearest pairs of bodies a cycle searches, and brings them to the result.
#pragma once

#include <vector>

#include "core/detector.h"
#include "core/scene.h"
#include "cuda/memory/cycle_arrays.cuh"
#include "cuda/memory/device_buffer.cuh"
#include "cuda/memory/host_copy.cuh"
#include "cuda/memory/scene_tables.cuh"

namespace deformable_contact_monitor {

// Belongs to one detector. A cycle calls layOut(), grows the arrays, and calls send(); after the
// stream was waited for, it calls addTo(). All arguments of the constructor must outlive this.
class DeviceNearest {
 public:
  DeviceNearest(CycleSizes& sizes, NearestArrays& arrays) : sizes_(sizes), arrays_(arrays) {}

  // Lists the pairs of two bodies of the scene, which has been laid out as `tables`, and raises the
  // sizes. `by_part`: pairs of parts are listed too. If the cycle does not search, the list is
  // empty. Throws CudaError if the scene is too large.
  void layOut(const Scene& scene, const SceneTables& tables, bool searches, bool by_part);

  // Adds what has changed on the device to `copies`.
  void send(HostCopies& copies);
  // Makes the next cycle send everything, because earlier copies may not have arrived.
  void forgetSent() { sent_ = false; }

  // Writes what the last cycle found to result.nearest and nearest_parts. Returns whether the
  // search was complete; otherwise pairs are missing.
  bool addTo(const Scene& scene, const SceneTables& tables, DetectionResult& result) const;

 private:
  CycleSizes& sizes_;
  NearestArrays& arrays_;
  std::vector<NearestBodies> pairs_;
  std::vector<TileRegion> regions_;
  PinnedBuffer<NearestBodies> staged_pairs_;
  PinnedBuffer<TileRegion> staged_regions_;
  bool sent_ = false;  // both lists are on the device
  PinnedBuffer<NearestFound> found_;
};

}  // namespace deformable_contact_monitor
