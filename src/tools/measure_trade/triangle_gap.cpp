// How far apart two triangles are: a check on what a detector claims, and none of its code.
#include "tools/measure_trade/triangle_gap.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace deformable_contact_monitor {
namespace {

using Corners = std::array<Vec3d, 3>;

Corners cornersOf(const Triangle& t) {
  return {toDouble(t.v[0]), toDouble(t.v[1]), toDouble(t.v[2])};
}

double length(const Vec3d& v) { return std::sqrt(dot(v, v)); }

double toPoint(const Vec3d& p, const Vec3d& from, const Vec3d& to) {
  const Vec3d way = to - from;
  const double square = dot(way, way);
  const double at = square > 0 ? std::clamp(dot(p - from, way) / square, 0.0, 1.0) : 0.0;
  return length(p - (from + way * at));
}

// The ends are looked at as points, too: so this may miss what is nearest there.
double betweenInner(const Vec3d& p, const Vec3d& p_to, const Vec3d& q, const Vec3d& q_to) {
  const Vec3d u = p_to - p, v = q_to - q, w = p - q, n = cross(u, v);
  const double square = dot(n, n);
  if (square == 0) return INFINITY;
  const double s = dot(cross(v, w), n) / square, t = dot(cross(u, w), n) / square;
  if (s < 0 || s > 1 || t < 0 || t > 1) return INFINITY;
  return length((p + u * s) - (q + v * t));
}

// Whether the point's foot lies on the triangle; a point beside it is nearer to an edge.
bool isOver(const Vec3d& p, const Corners& t, const Vec3d& n) {
  for (int k = 0; k < 3; ++k) {
    if (dot(cross(t[(k + 1) % 3] - t[k], p - t[k]), n) < 0) return false;
  }
  return true;
}

// What `a`'s corners and edges have to do with the inside of `b`.
double toInside(const Corners& a, const Corners& b) {
  const Vec3d n = cross(b[1] - b[0], b[2] - b[0]);
  const double size = length(n);
  if (size == 0) return INFINITY;
  double gap = INFINITY;
  std::array<double, 3> height;
  for (int k = 0; k < 3; ++k) {
    height[k] = dot(a[k] - b[0], n) / size;
    if (isOver(a[k], b, n)) gap = std::min(gap, std::abs(height[k]));
  }
  for (int k = 0; k < 3; ++k) {
    const double from = height[k], to = height[(k + 1) % 3];
    if (from == to || (from > 0) == (to > 0)) continue;
    if (isOver(a[k] + (a[(k + 1) % 3] - a[k]) * (from / (from - to)), b, n)) return 0;
  }
  return gap;
}

}  // namespace

double triangleGapM(const Triangle& a, const Triangle& b) {
  const Corners p = cornersOf(a), q = cornersOf(b);
  double gap = std::min(toInside(p, q), toInside(q, p));
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      const Vec3d &p_to = p[(i + 1) % 3], &q_to = q[(k + 1) % 3];
      gap = std::min({gap, toPoint(p[i], q[k], q_to), toPoint(q[k], p[i], p_to),
                      betweenInner(p[i], p_to, q[k], q_to)});
    }
  }
  return gap;
}

}  // namespace deformable_contact_monitor
