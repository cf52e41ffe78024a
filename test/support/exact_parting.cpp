// The shortest translation that parts two triangles: every direction that can have it is tried on
// all vertices.
#include "exact_parting.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "exact_points.h"

namespace deformable_contact_monitor {
namespace {

using exact::Point;
using exact::Rational;
using exact::toPoint;
using exact::Vector;

struct Points {
  Point p[3];

  explicit Points(const Triangle& t) : p{toPoint(t.v[0]), toPoint(t.v[1]), toPoint(t.v[2])} {}
  Vector edge(int i) const { return p[(i + 1) % 3] - p[i]; }
  Vector normal() const { return CGAL::cross_product(edge(0), edge(1)); }
};

// Returns how far b must move along `direction` until it is past a, times the length of
// `direction`.
Rational reachAlong(const Points& a, const Points& b, const Vector& direction) {
  const Point origin(0, 0, 0);
  Rational high = direction * (a.p[0] - origin), low = direction * (b.p[0] - origin);
  for (int i = 1; i < 3; ++i) {
    high = std::max(high, Rational(direction * (a.p[i] - origin)));
    low = std::min(low, Rational(direction * (b.p[i] - origin)));
  }
  return high - low;
}

}  // namespace

double exactPartingAlong(const Triangle& a, const Triangle& b, const Vec3f& direction) {
  const Vector d = toPoint(direction) - Point(0, 0, 0);
  const Rational reach = reachAlong(Points(a), Points(b), d);
  const Rational squared = reach * reach / d.squared_length();
  return (reach < 0 ? -1 : 1) * std::sqrt(CGAL::to_double(squared.exact()));
}

double exactParting(const Triangle& a, const Triangle& b) {
  const Points of_a(a), of_b(b);
  std::vector<Vector> directions = {of_a.normal(), of_b.normal()};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      directions.push_back(CGAL::cross_product(of_a.edge(i), of_b.edge(j)));
    }
  }
  bool any = false;
  Rational least = 0;
  for (const Vector& d : directions) {
    if (d == CGAL::NULL_VECTOR) continue;
    for (const int sign : {1, -1}) {
      const Rational reach = reachAlong(of_a, of_b, d * sign);
      const Rational squared = reach * reach / d.squared_length();
      if (any && squared >= least) continue;
      any = true;
      least = squared;
    }
  }
  return any ? std::sqrt(CGAL::to_double(least.exact())) : INFINITY;
}

}  // namespace deformable_contact_monitor
