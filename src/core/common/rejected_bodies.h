// Tells of which bodies a cycle left out triangles, so that nobody takes what is unknown of such a
// body for certain.
#pragma once

#include <cstdint>
#include <vector>

#include "core/common/scene_queries.h"
#include "core/detector.h"
#include "core/options.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// The bodies of a scene with rejected triangles: a vertex is not finite, so nobody knows where such
// a triangle is. Holds no reference to the scene.
class RejectedBodies {
 public:
  // `rejected` is Counters::rejected of the cycle. If it is not 0, this reads every vertex of the
  // scene.
  RejectedBodies(const Scene& scene, Motion motion, std::uint64_t rejected) {
    if (rejected == 0) return;
    // Vertices on a device cannot be read here, so any body may have them.
    for (BodyId id = 0; id < scene.bodyCount(); ++id) {
      if (scene.takesPart(id) && scene.body(id).device_vertices) any_on_device_ = true;
    }
    if (!any_on_device_) counts_ = rejectedTriangles(scene, motion);
  }

  // Returns whether triangles of the body were rejected, or may have been.
  bool has(BodyId body) const {
    return any_on_device_ || (!counts_.empty() && counts_[body].count > 0);
  }
  // Returns whether triangles of one of the two bodies were rejected, or may have been.
  bool hasOneOf(BodyId a, BodyId b) const { return has(a) || has(b); }

  // Returns what is certain of two bodies whatever their rejected triangles are: only that other
  // triangles are near, or touch. decide() then says kContact or kOpen.
  BodyDistance certain(BodyDistance distance) const {
    if (!hasOneOf(distance.body_a, distance.body_b)) return distance;
    distance.low_m = 0;
    distance.is_exact = distance.is_listed = false;
    return distance;
  }

  // Returns one entry per body of the scene. It is empty if the cycle rejected no triangle, or if
  // some body has its vertices on a device.
  const std::vector<RejectedTriangles>& counts() const { return counts_; }

 private:
  bool any_on_device_ = false;
  std::vector<RejectedTriangles> counts_;
};

}  // namespace deformable_contact_monitor
