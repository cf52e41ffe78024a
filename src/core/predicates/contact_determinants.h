// Determinants of the vertices of two triangles that intersect, with the same bits as those of
// triangle_distance.h.
//
// Triangles that intersect often share vertices or lie in one plane, as in layers of cloth. There
// double arithmetic does not suffice, and exact sums of doubles take long. So equal vertices are
// recognised, and the others are computed by integers where these suffice.
//
// These functions are apart from those for distances because they take more registers.
#pragma once

#include "core/host_device.h"
#include "core/predicates/exact_integers.h"
#include "core/predicates/orientation.h"
#include "core/predicates/triangle.h"
#include "core/predicates/triangle_distance.h"

namespace deformable_contact_monitor {

namespace detail {

DCM_HD inline bool isVertexOf(const Triangle& t, const Vec3f& p) {
  return p == t.v[0] || p == t.v[1] || p == t.v[2];
}

// Returns det[q1 - p1; q2 - p2; q3 - p3] as Expansion::value() does, by integers. Returns false if
// these do not suffice.
DCM_HD DCM_RARE inline bool determinantByIntegers(const Vec3f& p1, const Vec3f& q1, const Vec3f& p2,
                                                  const Vec3f& q2, const Vec3f& p3, const Vec3f& q3,
                                                  double& value) {
#if DCM_INT128
  const float x[18] = {p1.x, p1.y, p1.z, q1.x, q1.y, q1.z, p2.x, p2.y, p2.z,
                       q2.x, q2.y, q2.z, p3.x, p3.y, p3.z, q3.x, q3.y, q3.z};
  return determinantAsExpansion(x, value);
#else
  return false;
#endif
}

// Computes det[b - a; c - a; d - a] in double. Returns false if it is not right to 2^-29 of itself.
DCM_HD inline bool certainVolume(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& d,
                                 double& volume) {
  double permanent;
  volume = orient3dDouble(a, b, c, d, permanent);
  return fabs(volume) >= kEnough * permanent;
}

// Returns volumeOf(a, b, c, d).
DCM_HD inline double contactVolume(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& d) {
  double volume;
  if (certainVolume(a, b, c, d, volume)) return volume;
  if (a == c || a == d || b == c || b == d || c == d || a == b) return 0;
  return determinantByIntegers(a, b, a, c, a, d, volume) ? volume : exactVolume(a, b, c, d);
}

// Computes (b - a) x (d - c) in double. Returns false if a component is not right to 2^-29 of
// itself.
DCM_HD inline bool certainCross(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& d,
                                Vec3d& normal) {
  const Vec3d u = toDouble(b) - toDouble(a), v = toDouble(d) - toDouble(c);
  const double m1 = u.y * v.z, m2 = u.z * v.y, m3 = u.z * v.x;
  const double m4 = u.x * v.z, m5 = u.x * v.y, m6 = u.y * v.x;
  normal = {m1 - m2, m3 - m4, m5 - m6};
  return (fabs(normal.x) >= kEnough * (fabs(m1) + fabs(m2))) &
         (fabs(normal.y) >= kEnough * (fabs(m3) + fabs(m4))) &
         (fabs(normal.z) >= kEnough * (fabs(m5) + fabs(m6)));
}

// Returns crossOf(a, b, c, d).
DCM_HD inline Vec3d contactCross(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& d) {
  Vec3d normal;
  if (certainCross(a, b, c, d, normal)) return normal;
  const bool is_one_edge = (a == c && b == d) || (a == d && b == c);
  return is_one_edge ? Vec3d() : exactCross(a, b, c, d);
}

}  // namespace detail

}  // namespace deformable_contact_monitor
