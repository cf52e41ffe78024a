// Distance between triangles that do not intersect, for margins. In double; not exact.
#pragma once

#include <cmath>

#include "core/predicates/host_device.h"
#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

namespace detail {

DCM_HD inline double clamp01(double x) { return fmin(fmax(x, 0.0), 1.0); }

// Squared distance of two segments, degenerate ones included (Ericson, "Real-Time Collision
// Detection", 5.1.9).
DCM_HD inline double squaredSegmentDistance(const Vec3d& p, const Vec3d& p_end, const Vec3d& q,
                                            const Vec3d& q_end) {
  const Vec3d u = p_end - p, v = q_end - q, r = p - q;
  const double a = dot(u, u), e = dot(v, v), f = dot(v, r), c = dot(u, r), b = dot(u, v);
  double s = 0, t = 0;
  if (a > 0) {
    const double denominator = a * e - b * b;
    s = denominator > 0 ? clamp01((b * f - c * e) / denominator) : 0;
    t = e > 0 ? (b * s + f) / e : 0;
    if (t < 0 || t > 1 || e == 0) {
      t = clamp01(t);
      s = clamp01((b * t - c) / a);
    }
  } else if (e > 0) {
    t = clamp01(f / e);
  }
  const Vec3d d = (p + u * s) - (q + v * t);
  return dot(d, d);
}

// Squared distance of a point to the interior of a triangle, or infinity where the nearest point is
// on an edge.
DCM_HD inline double squaredInteriorDistance(const Vec3d& p, const Vec3d t[3]) {
  const Vec3d u = t[1] - t[0], v = t[2] - t[0], w = p - t[0];
  const Vec3d n = cross(u, v);
  const double nn = dot(n, n);
  if (!(nn > 0)) return INFINITY;
  const double beta = dot(cross(w, v), n) / nn, gamma = dot(cross(u, w), n) / nn;
  if (beta < 0 || gamma < 0 || beta + gamma > 1) return INFINITY;
  const double height = dot(w, n);
  return height * height / nn;
}

}  // namespace detail

// [m], for triangles known not to intersect: then the nearest points are on two edges, or on a
// vertex and a face.
DCM_HD inline double separation(const Triangle& a, const Triangle& b) {
  // Relative to a vertex, and scaled by a power of two, so that no square overflows or vanishes.
  double largest = 0;
  const Vec3d o = toDouble(a.v[0]);
  Vec3d p[3], q[3];
  for (int i = 0; i < 3; ++i) {
    p[i] = toDouble(a.v[i]) - o;
    q[i] = toDouble(b.v[i]) - o;
    largest = fmax(largest, fmax(fmax(fabs(p[i].x), fabs(p[i].y)), fabs(p[i].z)));
    largest = fmax(largest, fmax(fmax(fabs(q[i].x), fabs(q[i].y)), fabs(q[i].z)));
  }
  if (largest == 0) return 0;
  const double scale = ldexp(1.0, -ilogb(largest));
  for (int i = 0; i < 3; ++i) {
    p[i] = p[i] * scale;
    q[i] = q[i] * scale;
  }
  double least = INFINITY;
  for (int i = 0; i < 3; ++i) {
    least = fmin(least, fmin(detail::squaredInteriorDistance(p[i], q),
                             detail::squaredInteriorDistance(q[i], p)));
    for (int j = 0; j < 3; ++j) {
      least =
          fmin(least, detail::squaredSegmentDistance(p[i], p[(i + 1) % 3], q[j], q[(j + 1) % 3]));
    }
  }
  return sqrt(least) / scale;
}

}  // namespace deformable_contact_monitor
