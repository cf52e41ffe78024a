// Where and how the triangles of a contact touch.
#pragma once

#include <cstdint>

#include "core/predicates/vector3.h"

namespace deformable_contact_monitor {

// Sums of these are PairGeometry::flags, as in ContactGeometry.msg.
enum GeometryFlag : std::uint8_t {
  kCoplanar = 1,
  kNormalUndefined = 2,
  kSeparationUndefined = 4,
  kDegenerate = 8,        // a triangle without area
  kNormalNotUnique = 16,  // one of several that are as short
};

// In the scene frame.
struct PairGeometry {
  // Ends of the intersection segment, of the longest chord where coplanar; where the triangles are
  // apart, the closest points of a and of b [m].
  Vec3f point_a, point_b;
  // Unit vector from a to b: b moves along it to get clear. Zero where undefined.
  Vec3f normal;
  // > 0: distance; <= 0: minus the length of the shortest translation that parts them [m].
  float separation_m = 0;
  std::uint8_t flags = 0;
};

}  // namespace deformable_contact_monitor
