// Where and how the triangles of a contact touch.
#pragma once

#include <cstdint>

#include "core/vector3.h"

namespace deformable_contact_monitor {

// Sums of these are PairGeometry::flags, as in ContactGeometry.msg.
enum GeometryFlag : std::uint8_t {
  kCoplanar = 1,             // they intersect, and lie in one plane or on one line
  kNormalUndefined = 2,      // they lie on one line: every direction across it is as good
  kSeparationUndefined = 4,  // it is beyond the largest float32, which stands for it
  kDegenerate = 8,           // a triangle without area
  kNormalNotUnique = 16,     // one of several that are as short, within a part in 2^22
};

// In the scene frame; all numbers are finite. The same bits on every backend; with a and b swapped
// the normal is negated, the closest points are swapped, and the rest is the same.
struct PairGeometry {
  // Of triangles that intersect: ends of all that they have in common, or of its longest chord
  // where they are coplanar; equal where they touch at a point. Within 2^-22 of their own largest
  // coordinate (2^-148 m where that is less) on both triangles. Of triangles that are apart: the
  // closest points of a and of b, within as much and a part in 2^24 of the smaller triangle's
  // longest edge [m].
  Vec3f point_a, point_b;
  // Unit vector from a to b: b moves along it to get clear. Either side where coplanar. Zero where
  // undefined.
  Vec3f normal;
  // > 0: distance, to the bit the contact's in DetectionResult::separations_m; <= 0: minus the
  // length of the shortest translation that parts them, right to a part in 2^23; 0 where coplanar
  // [m]. Never > 0 for a contact of exact predicates at separation 0; what other predicates list
  // although it is apart has its true distance here.
  float separation_m = 0;
  std::uint8_t flags = 0;
};

}  // namespace deformable_contact_monitor
