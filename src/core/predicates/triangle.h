// Triangles, as closed convex hulls of three points [m]. Segments and points are degenerate
// triangles.
#pragma once

#include "core/host_device.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

struct Triangle {
  Vec3f v[3];
};

DCM_HD inline bool isFinite(const Triangle& t) {
  return isFinite(t.v[0]) && isFinite(t.v[1]) && isFinite(t.v[2]);
}

// Returns the right-handed normal of a triangle, whose length is twice the triangle's area [m^2].
inline Vec3d doubleAreaNormal(const Triangle& t) {
  const Vec3d origin = toDouble(t.v[0]);
  return cross(toDouble(t.v[1]) - origin, toDouble(t.v[2]) - origin);
}

// Returns the mean of three vertices, rounded. It is used for clustering, never for verdicts.
DCM_HD inline Vec3f centroidOf(const Vec3f v[3]) { return (v[0] + v[1] + v[2]) * (1.0F / 3); }

}  // namespace deformable_contact_monitor
