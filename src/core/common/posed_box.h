// Boxes of bodies in the scene frame, from boxes of them as received.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/predicates/aabb.h"
#include "core/rigid_transform.h"

namespace deformable_contact_monitor {

// A box in the scene frame that holds every posed float32 vertex whose received one is in
// `received`; finite only if all of them certainly are. Empty if that is.
inline Aabb posedBox(const Aabb& received, const RigidTransform& pose, bool is_identity) {
  if (received.empty() || is_identity) return received;
  const double lo[3] = {received.min.x, received.min.y, received.min.z};
  const double hi[3] = {received.max.x, received.max.y, received.max.z};
  float min[3], max[3];
  for (int i = 0; i < 3; ++i) {
    double centre = pose.translation[i], extent = 0, size = std::fabs(pose.translation[i]);
    for (int j = 0; j < 3; ++j) {
      const double r = pose.rotation[3 * i + j];
      centre += r * (lo[j] + hi[j]) / 2;
      extent += std::fabs(r) * (hi[j] - lo[j]) / 2;
      size += std::fabs(r) * std::max(std::fabs(lo[j]), std::fabs(hi[j]));
    }
    // float32 rounding of the vertices (2^-24 of their size) and of the box itself.
    const double reach = extent + size * 2.5e-7 + 1e-44;
    min[i] = static_cast<float>(centre - reach);
    max[i] = static_cast<float>(centre + reach);
  }
  return {{min[0], min[1], min[2]}, {max[0], max[1], max[2]}};
}

}  // namespace deformable_contact_monitor
