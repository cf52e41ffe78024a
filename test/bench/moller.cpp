#include "moller.h"

#include <algorithm>
#include <cmath>

namespace deformable_contact_monitor {
namespace {

constexpr float kTolerance = 1e-6F;

Vec3f crossed(const Vec3f& u, const Vec3f& v) {
  return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}

// Distances from the plane of t, times the length of its normal; small ones count as zero.
Vec3f distancesFrom(const Triangle& t, const Triangle& points, Vec3f* normal) {
  *normal = crossed(t.v[1] - t.v[0], t.v[2] - t.v[0]);
  const float offset = -dot(*normal, t.v[0]);
  const auto distance = [&](int i) {
    const float d = dot(*normal, points.v[i]) + offset;
    return std::fabs(d) < kTolerance ? 0.0F : d;
  };
  return {distance(0), distance(1), distance(2)};
}

bool onOneSide(const Vec3f& d) { return d.x * d.y > 0 && d.x * d.z > 0; }

struct Span {
  float low, high;
};

// Returns where the triangle with projections p and distances d crosses the common line.
Span spanOn(const Vec3f& p, const Vec3f& d) {
  const auto cut = [](float p0, float p1, float d0, float d1) {
    return p0 + (p1 - p0) * d0 / (d0 - d1);
  };
  float first, second;
  if (d.x * d.y > 0) {  // z is alone
    first = cut(p.z, p.x, d.z, d.x);
    second = cut(p.z, p.y, d.z, d.y);
  } else if (d.x * d.z > 0) {  // y is
    first = cut(p.y, p.x, d.y, d.x);
    second = cut(p.y, p.z, d.y, d.z);
  } else if (d.y * d.z > 0 || d.x != 0) {  // x is
    first = cut(p.x, p.y, d.x, d.y);
    second = cut(p.x, p.z, d.x, d.z);
  } else if (d.y != 0) {
    first = cut(p.y, p.x, d.y, d.x);
    second = cut(p.y, p.z, d.y, d.z);
  } else {
    first = cut(p.z, p.x, d.z, d.x);
    second = cut(p.z, p.y, d.z, d.y);
  }
  return {std::min(first, second), std::max(first, second)};
}

struct Point2 {
  float x, y;
};

float turn(const Point2& a, const Point2& b, const Point2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

bool edgesCross(const Point2& p, const Point2& q, const Point2& a, const Point2& b) {
  return turn(p, q, a) * turn(p, q, b) <= 0 && turn(a, b, p) * turn(a, b, q) <= 0;
}

bool inside(const Point2& p, const Point2 t[3]) {
  const float a = turn(t[0], t[1], p), b = turn(t[1], t[2], p), c = turn(t[2], t[0], p);
  return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
}

bool coplanarIntersect(const Vec3f& normal, const Triangle& a, const Triangle& b) {
  const float x = std::fabs(normal.x), y = std::fabs(normal.y), z = std::fabs(normal.z);
  const int dropped = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
  Point2 p[3], q[3];
  for (int i = 0; i < 3; ++i) {
    p[i] = {a.v[i][dropped == 0 ? 1 : 0], a.v[i][dropped == 2 ? 1 : 2]};
    q[i] = {b.v[i][dropped == 0 ? 1 : 0], b.v[i][dropped == 2 ? 1 : 2]};
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (edgesCross(p[i], p[(i + 1) % 3], q[j], q[(j + 1) % 3])) return true;
    }
  }
  return inside(p[0], q) || inside(q[0], p);
}

}  // namespace

bool mollerIntersects(const Triangle& a, const Triangle& b) {
  Vec3f normal_a, normal_b;
  const Vec3f of_a = distancesFrom(b, a, &normal_b);
  if (onOneSide(of_a)) return false;
  const Vec3f of_b = distancesFrom(a, b, &normal_a);
  if (onOneSide(of_b)) return false;
  if (of_a == Vec3f{}) return coplanarIntersect(normal_a, a, b);
  if (of_b == Vec3f{}) return coplanarIntersect(normal_b, a, b);
  const Vec3f line = crossed(normal_a, normal_b);
  const float x = std::fabs(line.x), y = std::fabs(line.y), z = std::fabs(line.z);
  const int axis = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
  const Span s = spanOn({a.v[0][axis], a.v[1][axis], a.v[2][axis]}, of_a);
  const Span t = spanOn({b.v[0][axis], b.v[1][axis], b.v[2][axis]}, of_b);
  return !(s.high < t.low || t.high < s.low);
}

}  // namespace deformable_contact_monitor
