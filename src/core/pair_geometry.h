// The geometry of a contact: where and how its triangles touch.
#pragma once

#include <cstdint>

#include "core/host_device.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// Sums of these are PairGeometry::flags, as in ContactGeometry.msg.
enum GeometryFlag : std::uint8_t {
  kCoplanar = 1,             // the triangles intersect, and lie in one plane or on one line
  kNormalUndefined = 2,      // they lie on one line, so no direction across it is preferred
  kSeparationUndefined = 4,  // the separation exceeds the largest float32, and is set to that
  kDegenerate = 8,           // one of the triangles has no area
  kNormalNotUnique = 16,     // another normal would part them as well, within a part in 2^22
};

// The geometry of one contact in the scene frame. All numbers are finite, and have the same bits on
// every backend. If a and b are swapped, the normal changes its sign, the closest points are
// swapped, and everything else stays the same. Only for triangles with the same coordinates in the
// same order the normal stays the same too, because they cannot be told apart.
struct PairGeometry {
  // Leaves the members uninitialised, so that resizing a list that will be filled costs nothing.
  DCM_HD PairGeometry() {}
  DCM_HD PairGeometry(const Vec3f& in_point_a, const Vec3f& in_point_b, const Vec3f& in_normal,
                      float in_separation_m, std::uint8_t in_flags)
      : point_a(in_point_a),
        point_b(in_point_b),
        normal(in_normal),
        separation_m(in_separation_m),
        flags(in_flags) {}

  // For triangles that intersect: the ends of their intersection segment, or of the longest chord
  // of their intersection if they are coplanar; equal if they touch in a point. The points lie on
  // both triangles within 2^-22 of their largest coordinate (or 2^-148 m, if that is more). For
  // triangles that are apart: the closest points of a and of b, with the same error, or 2^-50 of
  // their distance if that is more, plus 2^-24 of the smaller triangle's longest edge [m].
  union {  // keeps Vec3f's constructor from setting zeros
    Vec3f point_a;
  };
  union {
    Vec3f point_b;
  };
  // Unit vector from a to b: moving b along it separates the triangles. It points to either side if
  // they are coplanar, and is zero if it is undefined.
  union {
    Vec3f normal;
  };
  // Above 0, the distance [m], with the same bits as in DetectionResult::separations_m. Otherwise
  // minus the length of the shortest translation that separates the triangles, with a relative
  // error of 2^-23; 0 if they are coplanar. With exact predicates it is never above 0 for a contact
  // whose separation is 0. Other predicates may list triangles that are apart; these have their
  // true distance here.
  float separation_m;
  std::uint8_t flags;
};

}  // namespace deformable_contact_monitor
