// Distances and motions of small triangle meshes by brute force, in double.
#include "small_shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace deformable_contact_monitor {
namespace {

using Triangle = std::array<Vec3d, 3>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Vec3d mixed(const Vec3d& a, const Vec3d& b, double t) { return a + (b - a) * t; }

double pointToSegment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const Vec3d way = b - a;
  const double squared = dot(way, way);
  const double t = squared > 0 ? std::clamp(dot(p - a, way) / squared, 0.0, 1.0) : 0;
  return length(p - mixed(a, b, t));
}

// The nearest points of two segments lie within both, or one of them is an end point.
double segmentToSegment(const Vec3d& p, const Vec3d& q, const Vec3d& a, const Vec3d& b) {
  double least = std::min({pointToSegment(p, a, b), pointToSegment(q, a, b),
                           pointToSegment(a, p, q), pointToSegment(b, p, q)});
  const Vec3d u = q - p, v = b - a, w = p - a;
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v);
  const double det = uu * vv - uv * uv;
  if (det <= 0) return least;
  const double s = (uv * dot(v, w) - vv * dot(u, w)) / det;
  const double t = (uu * dot(v, w) - uv * dot(u, w)) / det;
  if (s < 0 || s > 1 || t < 0 || t > 1) return least;
  return std::min(least, length(mixed(p, q, s) - mixed(a, b, t)));
}

// Returns whether the point, which lies in the triangle's plane, lies within the triangle.
bool isInside(const Vec3d& p, const Triangle& t, const Vec3d& normal) {
  for (int i = 0; i < 3; ++i) {
    const Vec3d edge = t[(i + 1) % 3] - t[i];
    if (dot(cross(edge, p - t[i]), normal) < 0) return false;
  }
  return true;
}

double pointToTriangle(const Vec3d& p, const Triangle& t) {
  const Vec3d normal = cross(t[1] - t[0], t[2] - t[0]);
  const double squared = dot(normal, normal);
  if (squared == 0) return kInfinity;  // its edges have the distance
  const double height = dot(p - t[0], normal) / std::sqrt(squared);
  const Vec3d foot = p - normal * (height / std::sqrt(squared));
  return isInside(foot, t, normal) ? std::abs(height) : kInfinity;
}

bool pierces(const Vec3d& p, const Vec3d& q, const Triangle& t) {
  const Vec3d normal = cross(t[1] - t[0], t[2] - t[0]);
  const double at_p = dot(p - t[0], normal), at_q = dot(q - t[0], normal);
  if ((at_p > 0) == (at_q > 0) || at_p == at_q) return false;
  return isInside(mixed(p, q, at_p / (at_p - at_q)), t, normal);
}

double triangleDistance(const Triangle& a, const Triangle& b) {
  double least = kInfinity;
  for (int i = 0; i < 3; ++i) {
    if (pierces(a[i], a[(i + 1) % 3], b) || pierces(b[i], b[(i + 1) % 3], a)) return 0;
    least = std::min({least, pointToTriangle(a[i], b), pointToTriangle(b[i], a)});
    for (int j = 0; j < 3; ++j) {
      least = std::min(least, segmentToSegment(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]));
    }
  }
  return least;
}

bool isFinite(const Vec3d& v) { return std::isfinite(v.x + v.y + v.z); }

std::vector<Triangle> finiteTriangles(const SmallShape& shape) {
  std::vector<Triangle> finite;
  for (const auto& [i, j, k] : shape.triangles) {
    const Triangle triangle{shape.vertices[i], shape.vertices[j], shape.vertices[k]};
    if (std::all_of(triangle.begin(), triangle.end(), isFinite)) finite.push_back(triangle);
  }
  return finite;
}

// Returns an upper bound of how far any vertex moves between two times without a knot in between.
double travel(const SmallMotion& motion, double from, double to) {
  const SmallShape begin = motion.at(from), end = motion.at(to);
  double most = 0;
  for (std::size_t i = 0; i < begin.vertices.size(); ++i) {
    const double way = length(end.vertices[i] - begin.vertices[i]);
    if (std::isfinite(way)) most = std::max(most, way);
  }
  return most;
}

// Looks at a part of an interval in which all vertices move on straight lines.
void advance(const SmallMotion& a, const SmallMotion& b, double from, double to, Encounter* found) {
  constexpr double kTouching = 1e-6, kPassing = 1e-3;  // [m]
  const double way = travel(a, from, to) + travel(b, from, to);
  double time = from, begun = -1;
  while (true) {
    const double distance = distanceBetween(a.at(time), b.at(time));
    found->least_m = std::min(found->least_m, distance);
    if (distance > 0) begun = -1;
    if (distance == 0 && begun < 0) begun = time;
    if (begun >= 0 && (time - begun) * way >= kPassing * (to - from)) found->is_certain = true;
    if (found->is_certain || time >= to || way == 0) break;
    time = std::min(to, time + std::max(distance, kTouching * 50) / way * (to - from));
  }
}

}  // namespace

double SmallShape::brokenShare() const {
  if (triangles.empty()) return 0;
  const auto finite = static_cast<double>(finiteTriangles(*this).size());
  return 1 - finite / static_cast<double>(triangles.size());
}

Vec3d transformed(const RigidTransform& pose, const Vec3d& p) {
  const double* const r = pose.rotation;
  return {r[0] * p.x + r[1] * p.y + r[2] * p.z + pose.translation[0],
          r[3] * p.x + r[4] * p.y + r[5] * p.z + pose.translation[1],
          r[6] * p.x + r[7] * p.y + r[8] * p.z + pose.translation[2]};
}

RigidTransform composed(const RigidTransform& outer, const RigidTransform& inner) {
  RigidTransform result;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) {
        sum += outer.rotation[3 * row + k] * inner.rotation[3 * k + column];
      }
      result.rotation[3 * row + column] = sum;
    }
  }
  const Vec3d origin =
      transformed(outer, {inner.translation[0], inner.translation[1], inner.translation[2]});
  result.translation[0] = origin.x;
  result.translation[1] = origin.y;
  result.translation[2] = origin.z;
  return result;
}

double distanceBetween(const SmallShape& a, const SmallShape& b) {
  double least = kInfinity;
  const std::vector<Triangle> of_b = finiteTriangles(b);
  for (const Triangle& one : finiteTriangles(a)) {
    for (const Triangle& other : of_b) {
      least = std::min(least, triangleDistance(one, other));
      if (least == 0) return 0;
    }
  }
  return least;
}

double depthWithin(const SmallShape& inner, const SmallShape& outer) {
  Vec3d middle;
  for (const Vec3d& v : outer.vertices) middle = middle + v * (1.0 / outer.vertices.size());
  double least = kInfinity;
  for (const Triangle& t : finiteTriangles(outer)) {
    Vec3d normal = cross(t[1] - t[0], t[2] - t[0]);
    normal = normal * ((dot(middle - t[0], normal) > 0 ? 1 : -1) / length(normal));
    for (const Vec3d& v : inner.vertices) least = std::min(least, dot(v - t[0], normal));
  }
  return least;
}

SmallShape SmallMotion::at(double time) const {
  const auto next = std::find_if(times.begin() + 1, times.end() - 1,
                                 [time](double knot) { return knot >= time; });
  const auto i = static_cast<std::size_t>(next - times.begin());
  const double part = (time - times[i - 1]) / (times[i] - times[i - 1]);
  SmallShape shape{vertices[i - 1], triangles};
  for (std::size_t k = 0; k < shape.vertices.size(); ++k) {
    shape.vertices[k] = mixed(shape.vertices[k], vertices[i][k], std::clamp(part, 0.0, 1.0));
  }
  return shape;
}

Encounter encounterOf(const SmallMotion& a, const SmallMotion& b) {
  std::set<double> knots(a.times.begin(), a.times.end());
  knots.insert(b.times.begin(), b.times.end());
  Encounter found;
  found.least_m = kInfinity;
  double from = 0;
  for (const double to : knots) {
    if (to > from && !found.is_certain) advance(a, b, from, to, &found);
    from = to;
  }
  return found;
}

}  // namespace deformable_contact_monitor
