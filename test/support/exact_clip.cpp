// The contact definition by construction: two closed sets are clipped in exact rationals.
#include "exact_clip.h"

#include <algorithm>

#include "exact_triangles.h"

namespace deformable_contact_monitor {
namespace {

using exact::Point;
using exact::Rational;
using exact::toPoint;
using exact::Vector;

// The points x with normal . (x - origin) <= 0.
struct HalfSpace {
  Vector normal;
  Point origin;

  Rational excess(const Point& x) const { return normal * (x - origin); }
};

void addPlane(const Vector& normal, const Point& origin, std::vector<HalfSpace>* out) {
  out->push_back({normal, origin});
  out->push_back({-normal, origin});
}

// The hull of three points as an intersection of half-spaces.
std::vector<HalfSpace> halfSpaces(const std::array<Point, 3>& p) {
  std::vector<HalfSpace> out;
  const Vector normal = CGAL::cross_product(p[1] - p[0], p[2] - p[0]);
  if (normal != CGAL::NULL_VECTOR) {
    addPlane(normal, p[0], &out);
    for (int i = 0; i < 3; ++i) {
      out.push_back({CGAL::cross_product(p[(i + 1) % 3] - p[i], normal), p[i]});
    }
    return out;
  }
  // A segment, or a point: the pair of points farthest apart spans it.
  int start = 0;
  for (int i = 1; i < 3; ++i) {
    if ((p[(i + 1) % 3] - p[i]).squared_length() >
        (p[(start + 1) % 3] - p[start]).squared_length()) {
      start = i;
    }
  }
  const Point from = p[start], to = p[(start + 1) % 3];
  const Vector d = to - from;
  if (d == CGAL::NULL_VECTOR) {
    for (const Vector& axis : {Vector(1, 0, 0), Vector(0, 1, 0), Vector(0, 0, 1)}) {
      addPlane(axis, from, &out);
    }
    return out;
  }
  // d x (x - from) = 0, row by row.
  addPlane(Vector(0, -d.z(), d.y()), from, &out);
  addPlane(Vector(d.z(), 0, -d.x()), from, &out);
  addPlane(Vector(-d.y(), d.x(), 0), from, &out);
  out.push_back({d, to});
  out.push_back({-d, from});
  return out;
}

// Sutherland and Hodgman's step on the hull of a cyclic list of points.
std::vector<Point> clip(const std::vector<Point>& polygon, const HalfSpace& half_space) {
  std::vector<Point> out;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point& from = polygon[i];
    const Point& to = polygon[(i + 1) % polygon.size()];
    const Rational a = half_space.excess(from), b = half_space.excess(to);
    if (a <= 0) out.push_back(from);
    if ((a < 0 && b > 0) || (a > 0 && b < 0)) out.push_back(from + (to - from) * (a / (a - b)));
  }
  return out;
}

std::vector<Point> commonPart(const exact::Corners& a, const exact::Corners& b) {
  std::vector<Point> common(a.begin(), a.end());
  for (const HalfSpace& half_space : halfSpaces(b)) common = clip(common, half_space);
  return common;
}

exact::Corners toCorners(const OracleTriangle& t) {
  return {toPoint(t[0]), toPoint(t[1]), toPoint(t[2])};
}

}  // namespace

namespace exact {

bool meetBeyond(const Corners& a, const Corners& b, const std::vector<Point>& shared) {
  const std::vector<Point> common = commonPart(a, b);
  if (shared.empty()) return !common.empty();

  const auto at = [&shared](std::size_t i) { return shared[std::min(i, shared.size() - 1)]; };
  const std::vector<HalfSpace> hull = halfSpaces({at(0), at(1), at(2)});
  // The common part is convex: it lies in the hull iff its corners do.
  return std::any_of(common.begin(), common.end(), [&hull](const Point& x) {
    return std::any_of(hull.begin(), hull.end(),
                       [&x](const HalfSpace& side) { return side.excess(x) > 0; });
  });
}

}  // namespace exact

bool meetBeyondByConstruction(const OracleTriangle& a, const OracleTriangle& b,
                              const std::vector<Vec3f>& shared) {
  std::vector<Point> points;
  for (const Vec3f& v : shared) points.push_back(toPoint(v));
  return exact::meetBeyond(toCorners(a), toCorners(b), points);
}

std::vector<std::array<double, 3>> commonCorners(const OracleTriangle& a, const OracleTriangle& b) {
  std::vector<std::array<double, 3>> corners;
  for (const Point& x : commonPart(toCorners(a), toCorners(b))) {
    corners.push_back({CGAL::to_double(x.x().exact()), CGAL::to_double(x.y().exact()),
                       CGAL::to_double(x.z().exact())});
  }
  return corners;
}

}  // namespace deformable_contact_monitor
