// The rule by which the nearest triangles of two bodies are chosen.
#pragma once

#include <cfloat>
#include <cstdint>

#include "core/host_device.h"
#include "core/predicates/triangle_distance.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// Returns separation() of two triangles as the float32 by which pairs are compared [m]. It is never
// 0, which is for triangles that intersect, and never infinite.
DCM_HD inline float comparedDistance(double separation_m) {
  constexpr float kLeast = 1.4e-45F;
  return most(kLeast, toFloat(least<double>(separation_m, FLT_MAX)));
}

// Two triangles of two bodies, and how far they are apart.
struct PairDistance {
  float distance_m;  // comparedDistance(), or 0 if they intersect
  std::uint32_t triangle_a, triangle_b;

  // Returns whether this pair is nearer, or as near and its triangles come first.
  DCM_HD bool precedes(const PairDistance& o) const {
    if (distance_m != o.distance_m) return distance_m < o.distance_m;
    return triangle_a != o.triangle_a ? triangle_a < o.triangle_a : triangle_b < o.triangle_b;
  }
};

}  // namespace deformable_contact_monitor
