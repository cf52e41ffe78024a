// Distance of two triangles by exact rationals: parameters of nearest points, not determinants.
#include "exact_distance.h"

#include <algorithm>
#include <cmath>

#include "exact_triangles.h"

namespace deformable_contact_monitor {
namespace {

using exact::Point;
using exact::Rational;
using exact::toPoint;
using exact::Vector;

Rational toSegment(const Point& p, const Point& q, const Point& r) {
  const Vector along = r - q;
  if (along == CGAL::NULL_VECTOR) return (p - q).squared_length();
  Rational s = ((p - q) * along) / along.squared_length();
  s = std::min(std::max(s, Rational(0)), Rational(1));
  return (p - (q + s * along)).squared_length();
}

// The nearest points of two lines, if they are on both segments; else `none`.
Rational betweenInteriors(const Point& p, const Point& p_end, const Point& q, const Point& q_end,
                          const Rational& none) {
  const Vector u = p_end - p, v = q_end - q, r = p - q;
  const Rational a = u * u, b = u * v, e = v * v, c = u * r, f = v * r;
  const Rational denominator = a * e - b * b;
  if (denominator == 0) return none;
  const Rational s = (b * f - c * e) / denominator, t = (a * f - b * c) / denominator;
  if (s < 0 || s > 1 || t < 0 || t > 1) return none;
  return ((p + s * u) - (q + t * v)).squared_length();
}

Rational toInterior(const Point& p, const exact::Corners& t, const Rational& none) {
  const Vector u = t[1] - t[0], v = t[2] - t[0], w = p - t[0];
  const Rational uu = u * u, uv = u * v, vv = v * v, wu = w * u, wv = w * v;
  const Rational denominator = uu * vv - uv * uv;
  if (denominator == 0) return none;
  const Rational beta = (vv * wu - uv * wv) / denominator,
                 gamma = (uu * wv - uv * wu) / denominator;
  if (beta < 0 || gamma < 0 || beta + gamma > 1) return none;
  return (w - beta * u - gamma * v).squared_length();
}

}  // namespace

namespace exact {

Rational squaredDistance(const Corners& p, const Corners& q) {
  Rational least = (p[0] - q[0]).squared_length();
  for (int i = 0; i < 3; ++i) {
    const Point& p_end = p[(i + 1) % 3];
    least = std::min(least, toInterior(p[i], q, least));
    least = std::min(least, toInterior(q[i], p, least));
    for (int j = 0; j < 3; ++j) {
      const Point& q_end = q[(j + 1) % 3];
      least = std::min(least, toSegment(p[i], q[j], q_end));
      least = std::min(least, toSegment(q[j], p[i], p_end));
      least = std::min(least, betweenInteriors(p[i], p_end, q[j], q_end, least));
    }
  }
  return least;
}

}  // namespace exact

double exactDistance(const Triangle& a, const Triangle& b) {
  const exact::Corners p{toPoint(a.v[0]), toPoint(a.v[1]), toPoint(a.v[2])};
  const exact::Corners q{toPoint(b.v[0]), toPoint(b.v[1]), toPoint(b.v[2])};
  return std::sqrt(CGAL::to_double(exact::squaredDistance(p, q).exact()));
}

}  // namespace deformable_contact_monitor
