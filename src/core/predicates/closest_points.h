// Constructs the closest points of two triangles that do not intersect. It goes through the same
// features as triangle_distance.h, but keeps the points of the nearest one.
#pragma once

#include <cmath>

#include "core/host_device.h"
#include "core/predicates/intersection_segment.h"
#include "core/predicates/triangle_distance.h"

namespace deformable_contact_monitor {

// The closest points of a and b. Each lies on its triangle, and their distance is that of the
// triangles, up to 2^-22 of the points' largest coordinate, rounding to float32 included, or 2^-50
// of the distance if that is more, and 2^-24 of the smaller triangle's longest edge. The direction
// is right to 2^-13 rad, an angle by which it may turn where the distance hardly changes.
struct ClosestPoints {
  Vec3f on_a, on_b;
  Vec3d direction;      // from a to b, a unit vector
  double distance = 0;  // [m]; equals separation()
};

namespace detail {

// The nearest pair of features so far, of a first and a second triangle.
struct NearestFeature {
  double squared = INFINITY;
  Vec3d on_first;
  Vec3d direction;  // from the first to the second, of any length

  DCM_HD Vec3d across() const {
    return direction * (sqrt(squared) / sqrt(dot(direction, direction)));
  }
  // Takes a pair of features: `point` lies on one of them, and the closest point of the other one
  // lies from it in the direction `way`, which has any length. `sign` is 1 if `point` is on the
  // first triangle, else -1.
  DCM_HD void take(double squared_distance, const Vec3d& point, const Vec3d& way, double sign) {
    squared = squared_distance;
    direction = way * sign;
    on_first = sign > 0 ? point : point + way * (sqrt(squared) / sqrt(dot(way, way)));
  }
};

// Tries the point p with the segment from q to r; `area` is (q - p) x (r - q).
DCM_HD inline void tryPointAndSegment(const Vec3f& p, const Vec3f& q, const Vec3f& r,
                                      const Vec3d& area, double sign, NearestFeature& nearest) {
  const double squared = squaredToSegment(p, q, r, area);
  if (!(squared < nearest.squared)) return;
  const Vec3d to_q = toDouble(q) - toDouble(p), to_r = toDouble(r) - toDouble(p);
  const Vec3d along = toDouble(r) - toDouble(q);
  Vec3d way = cross(along, area);
  if (!(dot(to_q, along) < 0)) {
    way = to_q;
  } else if (!(dot(to_r, along) > 0)) {
    way = to_r;
  }
  nearest.take(squared, toDouble(p), way, sign);
}

// Tries the vertices of `t` with the edges and the face of `u`, as squaredVertexDistance() does.
// `sign` is 1 if t is the first triangle.
DCM_HD inline void tryVertices(const Triangle& t, const Triangle& u, const VertexEdgeAreas& areas,
                               double sign, NearestFeature& nearest) {
  const Vec3d normal = crossOf(u.v[0], u.v[1], u.v[1], u.v[2]);
  const double size2 = dot(normal, normal);
  DCM_ROLLED for (int i = 0; i < 3; ++i) {
    const Vec3d* const area = areas.of[i];
    if (size2 > 0 && dot(area[0], normal) >= 0 && dot(area[1], normal) >= 0 &&
        dot(area[2], normal) >= 0) {
      const double volume = volumeOf(u.v[0], u.v[1], u.v[2], t.v[i]);
      const double squared = volume * volume / size2;
      if (squared < nearest.squared) {
        nearest.take(squared, toDouble(t.v[i]), normal * (volume > 0 ? -1.0 : 1.0), sign);
      }
      continue;
    }
    DCM_ROLLED for (int j = 0; j < 3; ++j) {
      tryPointAndSegment(t.v[i], u.v[j], u.v[j == 2 ? 0 : j + 1], area[j], sign, nearest);
    }
  }
}

// A point of the edge from p to q, given by the sizes of a linear function at both ends. `reach` is
// its distance from the nearer end: the point's error is a fraction of it.
struct EdgePoint {
  Vec3d point;
  double reach;

  DCM_HD EdgePoint(const Vec3f& p, const Vec3f& q, double at_p, double at_q) {
    const bool from_p = fabs(at_p) <= fabs(at_q);
    const double whole = fabs(at_p) + fabs(at_q);
    const double share = whole > 0 ? (from_p ? fabs(at_p) : fabs(at_q)) / whole : 0;
    const Vec3f &base = from_p ? p : q, &other = from_p ? q : p;
    const Vec3d offset = (toDouble(other) - toDouble(base)) * share;
    point = toDouble(base) + offset;
    reach = largestCoordinate(offset);
  }
};

// Tries the edges of both, as squaredEdgeDistance() does.
DCM_HD inline void tryEdges(const Triangle& a, const Triangle& b, const VertexEdgeAreas& a_areas,
                            const VertexEdgeAreas& b_areas, NearestFeature& nearest) {
  DCM_ROLLED for (int i = 0; i < 3; ++i) {
    const int i_next = i == 2 ? 0 : i + 1;
    DCM_ROLLED for (int j = 0; j < 3; ++j) {
      const int j_next = j == 2 ? 0 : j + 1;
      const Vec3f &p = a.v[i], &q = a.v[i_next], &r = b.v[j], &s = b.v[j_next];
      const Vec3d normal = crossOf(p, q, r, s);
      const double size2 = dot(normal, normal);
      const double at_p = dot(a_areas.of[i][j], normal), at_q = dot(a_areas.of[i_next][j], normal);
      const double at_r = dot(b_areas.of[j][i], normal), at_s = dot(b_areas.of[j_next][i], normal);
      if (!(size2 > 0 && at_p >= 0 && at_q <= 0 && at_r <= 0 && at_s >= 0)) continue;
      const double volume = volumeOf(p, q, r, s);
      const double squared = volume * volume / size2;
      if (!(squared < nearest.squared)) continue;
      const EdgePoint of_a(p, q, at_p, at_q), of_b(r, s, at_r, at_s);
      const Vec3d to_b = normal * (volume > 0 ? -1.0 : 1.0);
      if (of_a.reach <= of_b.reach) {
        nearest.take(squared, of_a.point, to_b, 1);
      } else {
        nearest.take(squared, of_b.point, to_b * -1.0, -1);
      }
    }
  }
}

}  // namespace detail

// Returns the closest points. The caller chooses the order of a and b: another order may round
// differently.
DCM_HD DCM_RARE inline ClosestPoints closestPoints(const Triangle& a, const Triangle& b) {
  const detail::VertexEdgeAreas a_areas(a, b), b_areas(b, a);
  detail::NearestFeature nearest;
  detail::tryEdges(a, b, a_areas, b_areas, nearest);
  detail::tryVertices(a, b, a_areas, 1, nearest);
  detail::tryVertices(b, a, b_areas, -1, nearest);
  ClosestPoints closest;
  const double size = sqrt(dot(nearest.direction, nearest.direction));
  closest.direction = nearest.direction * (1 / size);
  closest.distance = sqrt(nearest.squared);
  closest.on_a = nearestFloats(nearest.on_first);
  closest.on_b = nearestFloats(nearest.on_first + closest.direction * closest.distance);
  return closest;
}

}  // namespace deformable_contact_monitor
