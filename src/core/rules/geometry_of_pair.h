// The geometry of a contact: where two triangles intersect or are closest, and in which direction b
// gets clear of a.
//
// It is computed in double, with + - * / sqrt and explicit fma only, so that host and device give
// the same bits. The two triangles are ordered by their coordinates first, so that (b, a) gives the
// mirrored result of (a, b).
#pragma once

#include <cfloat>

#include "core/host_device.h"
#include "core/pair_geometry.h"
#include "core/predicates/closest_points.h"
#include "core/predicates/intersection_segment.h"
#include "core/predicates/parting_translation.h"
#include "core/predicates/segment_intersection.h"
#include "core/predicates/triangle.h"
#include "core/rules/geometry_of_crossing.h"

namespace deformable_contact_monitor {

namespace detail {

// Returns the first axis along which three of the six points project to a triangle with area, or -1
// if all are on one line. `normal` becomes the normal of the plane through these three.
DCM_HD DCM_RARE inline int axisOfPlane(const Triangle& a, const Triangle& b, Vec3d& normal) {
  PredicateState state;
  const auto at = [&](int i) -> const Vec3f& { return i < 3 ? a.v[i] : b.v[i - 3]; };
  DCM_ROLLED for (int i = 0; i < 6; ++i) {
    DCM_ROLLED for (int j = i + 1; j < 6; ++j) {
      DCM_ROLLED for (int k = j + 1; k < 6; ++k) {
        const int axis = projectionAxis(at(i), at(j), at(k), state);
        if (axis < 0) continue;
        normal = crossOf(at(i), at(j), at(j), at(k));
        return axis;
      }
    }
  }
  return -1;
}

// Returns whether two degenerate triangles, segments or points, intersect.
DCM_HD DCM_RARE inline bool linesMeet(const Triangle& a, const Triangle& b) {
  PredicateState state;
  DCM_ROLLED for (int i = 0; i < 3; ++i) {
    if (segmentMeetsEdges(a.v[i], a.v[i == 2 ? 0 : i + 1], b, state)) return true;
  }
  return false;
}

DCM_HD DCM_RARE inline bool hasArea(const Triangle& t) {
  PredicateState state;
  return projectionAxis(t.v[0], t.v[1], t.v[2], state) >= 0;
}

// Fills in the geometry of two triangles in one plane, or on one line. Returns false if they do not
// intersect.
DCM_HD DCM_RARE inline bool fillCoplanar(const Triangle& a, const Triangle& b,
                                         PairGeometry& geometry) {
  Vec3d normal;
  const int axis = axisOfPlane(a, b, normal);
  CommonSegment segment;
  if (!longestChord(a, b, axis, segment)) return false;
  geometry.point_a = segment.from;
  geometry.point_b = segment.to;
  geometry.flags |= kCoplanar;
  if (axis < 0) {
    geometry.flags |= kNormalUndefined;
  } else {
    geometry.flags |= kNormalNotUnique;  // either side is as near
    geometry.normal = toFloat(unit(normal));
  }
  return true;
}

// Fills in the geometry of triangles in different planes, of which at least one has area. Returns
// false if they do not intersect.
DCM_HD inline bool fillCrossing(const Triangle& a, const Triangle& b, bool a_has_area,
                                bool b_has_area, const Heights& heights, PairGeometry& geometry) {
  CommonSegment segment;
  const bool meet = !a_has_area   ? pointAcrossPlane(b, a, heights.of_a, segment)
                    : !b_has_area ? pointAcrossPlane(a, b, heights.of_b, segment)
                                  : segmentAcrossPlanes(a, b, heights, segment);
  if (!meet) return false;
  geometry.point_a = segment.from;
  geometry.point_b = segment.to;
  const PartingTranslation way = partingTranslation(a, b, heights);
  geometry.normal = toFloat(way.direction);
  if (!way.unique) geometry.flags |= kNormalNotUnique;
  if (way.length > FLT_MAX) geometry.flags |= kSeparationUndefined;
  geometry.separation_m = 0.0F - toFloat(least<double>(way.length, FLT_MAX));
  return true;
}

// Fills in the geometry of triangles that intersect. Returns false if they do not; then only flags
// were set.
DCM_HD inline bool fillContact(const Triangle& a, const Triangle& b, PairGeometry& geometry) {
  const bool a_has_area = hasArea(a), b_has_area = hasArea(b);
  if (!a_has_area || !b_has_area) geometry.flags |= kDegenerate;
  if (!a_has_area && !b_has_area) return linesMeet(a, b) && fillCoplanar(a, b, geometry);
  const Heights heights(a, b);
  const bool coplanar = a_has_area ? allZero(heights.of_b) : allZero(heights.of_a);
  return coplanar ? fillCoplanar(a, b, geometry)
                  : fillCrossing(a, b, a_has_area, b_has_area, heights, geometry);
}

// Fills in the geometry of triangles that do not intersect: their closest points.
DCM_HD DCM_RARE inline void fillApart(const Triangle& a, const Triangle& b, float separation_m,
                                      PairGeometry& geometry) {
  constexpr float kLeast = 1.4e-45F;  // 0 is for those that intersect
  if (!hasArea(a) || !hasArea(b)) geometry.flags |= kDegenerate;
  const ClosestPoints closest = closestPoints(a, b);
  geometry.point_a = closest.on_a;
  geometry.point_b = closest.on_b;
  geometry.normal = toFloat(closest.direction);
  geometry.separation_m = separation_m;
  if (separation_m > 0) return;
  if (closest.distance > FLT_MAX) geometry.flags |= kSeparationUndefined;
  geometry.separation_m = most(kLeast, toFloat(least<double>(closest.distance, FLT_MAX)));
}

}  // namespace detail

// Returns the geometry of two triangles with finite vertices that were listed with that separation
// [m]; 0 means that they intersect. Predicates below exact may list triangles that do not
// intersect: these get the geometry of triangles that are apart.
DCM_HD inline PairGeometry generalGeometryOf(const Triangle& a, const Triangle& b,
                                             float separation_m) {
  const bool swap = detail::precedes(b, a);
  const Triangle &first = swap ? b : a, &second = swap ? a : b;
  PairGeometry geometry({}, {}, {}, 0, 0);
  const bool meet = separation_m <= 0 && detail::fillContact(first, second, geometry);
  if (!meet) detail::fillApart(first, second, separation_m, geometry);
  const Vec3f zero;  // makes 0 of -0
  geometry.normal = swap ? zero - geometry.normal : zero + geometry.normal;
  if (!swap) return geometry;
  if (!meet) {
    const Vec3f on_first = geometry.point_a;
    geometry.point_a = geometry.point_b;
    geometry.point_b = on_first;
  }
  return geometry;
}

// Computes what generalGeometryOf(a, b, 0) returns if the triangles properly cross, as most do.
// Returns false if that is not certain; then `geometry` is left in an unspecified state.
DCM_HD inline bool crossingGeometryOf(const Triangle& a, const Triangle& b,
                                      PairGeometry& geometry) {
  const bool swap = detail::precedes(b, a);
  Triangle first, second;
  for (int i = 0; i < 3; ++i) {
    first.v[i] = selected(swap, b.v[i], a.v[i]);
    second.v[i] = selected(swap, a.v[i], b.v[i]);
  }
  if (!detail::fillProperCrossing(first, second, geometry)) return false;
  const Vec3f zero;  // makes 0 of -0
  geometry.normal = swap ? zero - geometry.normal : zero + geometry.normal;
  return true;
}

// Returns generalGeometryOf(a, b, separation_m), faster where the triangles properly cross.
DCM_HD inline PairGeometry geometryOf(const Triangle& a, const Triangle& b, float separation_m) {
  PairGeometry geometry;
  if (separation_m <= 0 && crossingGeometryOf(a, b, geometry)) return geometry;
  return generalGeometryOf(a, b, separation_m);
}

}  // namespace deformable_contact_monitor
