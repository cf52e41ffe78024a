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

// Returns whether some vertex of a has the same place as one of b. Then they intersect, whatever
// their shape, because a closed triangle contains its vertices.
DCM_HD inline bool haveEqualVertices(const Triangle& a, const Triangle& b) {
  bool equal = false;
  for (int i = 0; i < 3; ++i) {
    equal = equal || a.v[i] == b.v[0] || a.v[i] == b.v[1] || a.v[i] == b.v[2];
  }
  return equal;
}

// Returns whether both triangles lie in one plane across coordinate axis `axis` (0, 1, 2).
DCM_HD inline bool areLevel(const Triangle& a, const Triangle& b, int axis) {
  const float level = a.v[0][axis];
  bool same = true;
  for (int i = 0; i < 3; ++i) same = same && a.v[i][axis] == level && b.v[i][axis] == level;
  return same;
}

// Returns the right-handed normal of a triangle, whose length is twice the triangle's area [m^2].
inline Vec3d doubleAreaNormal(const Triangle& t) {
  const Vec3d origin = toDouble(t.v[0]);
  return cross(toDouble(t.v[1]) - origin, toDouble(t.v[2]) - origin);
}

// Returns the mean of three vertices, rounded. It is used for clustering, never for verdicts.
DCM_HD inline Vec3f centroidOf(const Vec3f v[3]) { return (v[0] + v[1] + v[2]) * (1.0F / 3); }

}  // namespace deformable_contact_monitor
