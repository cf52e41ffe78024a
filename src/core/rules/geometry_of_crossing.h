// The geometry of two triangles that properly cross: no vertex of one is on the plane of the other,
// and double arithmetic tells all signs.
//
// That is how nearly all contacts are. The result has the same bits as the general rule
// (geometry_of_pair.h), but it takes a fraction of the work, no memory besides registers, and the
// same path for all pairs. Where that is not certain, it says so.
#pragma once

#include <cfloat>
#include <cmath>

#include "core/host_device.h"
#include "core/pair_geometry.h"
#include "core/predicates/contact_determinants.h"
#include "core/predicates/intersection_segment.h"
#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

namespace detail {

// Computes det[b - a; c - a; d - a]. Returns false if it is zero, or if double arithmetic does not
// suffice.
DCM_HD inline bool properVolume(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& d,
                                double& volume) {
  return certainVolume(a, b, c, d, volume) && volume != 0;
}

// The nearest face of the Minkowski difference of two triangles. A face that is nearly as near as
// another one makes it open, unless a clearly nearer one is added later.
struct ClearlyNearestFace {
  Vec3d normal;
  double squared_distance = INFINITY, squared_size = 1;  // the distance is in units of the normal
  bool is_open = false, is_lost = false;  // lost: numbers were too large or too small to compare

  DCM_HD bool isCertain() const { return !is_open && !is_lost; }

  // Adds a face, which points outwards, if `counts` holds.
  DCM_HD void add(const Vec3d& face_normal, double distance, bool counts) {
    constexpr double kClearly = 1 + 0x1p-20, kLeast = 1e-280, kMost = 1e280;
    const double size = dot(face_normal, face_normal), squared = distance * distance;
    if (!counts || !(size > 0)) return;
    const double here = squared * squared_size, best = squared_distance * size;
    const bool is_nearer = here * kClearly<best, is_farther = here> best * kClearly;
    is_lost = is_lost || !(distance > 0 && here > kLeast && here < kMost && best > kLeast);
    is_open = !is_nearer && (is_open || !is_farther);
    if (!(here < best)) return;
    normal = face_normal;
    squared_distance = squared;
    squared_size = size;
  }
};

// A triangle that crosses a plane, turned so that the first vertex is alone on its side.
struct TurnedTriangle {
  Vec3f v[3];
  double height[3];  // above the plane

  // Returns whether there is such a vertex. `heights` are those of the vertices of t; none is zero.
  DCM_HD bool turn(const Triangle& t, const double heights[3]) {
    const bool up0 = heights[0] > 0, up1 = heights[1] > 0, up2 = heights[2] > 0;
    const bool is0 = up1 == up2, is1 = up0 == up2;
    v[0] = selected(is0, t.v[0], selected(is1, t.v[1], t.v[2]));
    v[1] = selected(is0, t.v[1], selected(is1, t.v[2], t.v[0]));
    v[2] = selected(is0, t.v[2], selected(is1, t.v[0], t.v[1]));
    height[0] = is0 ? heights[0] : (is1 ? heights[1] : heights[2]);
    height[1] = is0 ? heights[1] : (is1 ? heights[2] : heights[0]);
    height[2] = is0 ? heights[2] : (is1 ? heights[0] : heights[1]);
    return !(is0 && is1);
  }
  DCM_HD bool isUp() const { return height[0] > 0; }

  // Finds the sign of riseOver() for the edge opposite to the first vertex. Heights are right to
  // 2^-29 of themselves. Returns false if their difference is not enough.
  DCM_HD bool riseOfOpposite(bool& rises) const {
    const double rise = height[2] - height[1];
    rises = rise > 0;
    return fabs(rise) > 0x1p-27 * most(fabs(height[1]), fabs(height[2]));
  }

  // Returns the crossing of the edge between v[0] and v[1], or between v[0] and v[2].
  DCM_HD Crossing crossing(bool of_first_edge) const {
    const Vec3f other = selected(of_first_edge, v[1], v[2]);
    const double at_other = of_first_edge ? height[1] : height[2];
    const bool is_up = isUp();
    return {selected(is_up, other, v[0]), selected(is_up, v[0], other),
            is_up ? at_other : height[0], is_up ? height[0] : at_other};
  }
};

// Finds a point as pointOf() does. Returns false if too much cancels.
DCM_HD inline bool certainPointOf(bool first, const Crossing& one, const Crossing& other,
                                  Vec3f& point) {
  Vec3d exact;
  const bool is_certain =
      zeroNearEnd(selected(first, one.low, other.low), selected(first, one.high, other.high),
                  first ? one.at_low : other.at_low, first ? one.at_high : other.at_high, exact);
  point = nearestFloats(exact);
  return is_certain;
}

// Two triangles that cross each other's planes.
struct CrossingPair {
  TurnedTriangle a, b;
  ClearlyNearestFace nearest;
  double volume[2][2];  // of the edges of a and of b that go out from and come back to v[0]

  // Adds the faces along the normals of the triangles' planes. Finds how both lie across the
  // other's plane. Returns false if that is not certain, or one does not cross.
  DCM_HD bool addPlanes(const Triangle& first, const Triangle& second) {
    double of_a[3], of_b[3];
    bool is_certain = true;
    for (int i = 0; i < 3; ++i) {
      is_certain &= properVolume(second.v[0], second.v[1], second.v[2], first.v[i], of_a[i]);
      is_certain &= properVolume(first.v[0], first.v[1], first.v[2], second.v[i], of_b[i]);
    }
    is_certain = is_certain && a.turn(first, of_a) && b.turn(second, of_b);
    if (!is_certain) return false;
    Vec3d normal_a, normal_b;
    is_certain = certainCross(first.v[0], first.v[1], first.v[1], first.v[2], normal_a);
    is_certain &= certainCross(second.v[0], second.v[1], second.v[1], second.v[2], normal_b);
    addPlane(normal_a, of_b, 1);
    addPlane(normal_b, of_a, -1);
    return is_certain;
  }
  DCM_HD void addPlane(const Vec3d& normal, const double height[3], double sign) {
    nearest.add(normal * sign, -least(height[0], least(height[1], height[2])), true);
    nearest.add(normal * -sign, most(height[0], most(height[1], height[2])), true);
  }

  // Finds the ends of the common segment. Returns false if the triangles do not meet, or that is
  // not certain. The orders are those of segmentAcrossPlanes(): where a vertex is above the plane,
  // the edge that comes back to it is on the right.
  DCM_HD bool findSegment(PairGeometry& geometry) {
    bool is_certain = true;
    for (int i = 0; i < 2; ++i) {
      const Vec3f &p = a.v[i == 0 ? 0 : 2], &q = a.v[i == 0 ? 1 : 0];
      is_certain &= properVolume(p, q, b.v[0], b.v[1], volume[i][0]);
      is_certain &= properVolume(p, q, b.v[2], b.v[0], volume[i][1]);
    }
    if (!is_certain) return false;
    const bool up_a = a.isUp(), up_b = b.isUp();
    const auto order = [&](bool back_a, bool back_b) {
      return back_a ? (back_b ? volume[1][1] : volume[1][0])
                    : (back_b ? volume[0][1] : volume[0][0]);
    };
    if (order(up_a, up_b) < 0 || order(!up_a, !up_b) > 0) return false;
    const bool from_b = order(up_a, !up_b) < 0;
    const bool to_b = order(!up_a, up_b) > 0;
    is_certain = certainPointOf(from_b, b.crossing(up_b), a.crossing(!up_a), geometry.point_a);
    is_certain &= certainPointOf(to_b, b.crossing(!up_b), a.crossing(up_a), geometry.point_b);
    return is_certain;
  }

  // Adds the face of an edge of a and an edge of b, if `counts` holds.
  DCM_HD bool addEdges(const Vec3f& p, const Vec3f& q, const Vec3f& r, const Vec3f& s,
                       double edge_volume, bool rises, bool counts) {
    const double sign = rises ? 1 : -1;
    Vec3d normal;
    const bool is_certain = certainCross(p, q, r, s, normal);
    nearest.add(normal * sign, sign * edge_volume, counts);
    return is_certain || !counts;
  }

  // Adds the faces of two edges, one of each triangle, that rise or fall alike above the other's
  // plane. The edge that goes out from a vertex above falls, the one that comes back rises. Returns
  // false if something is not certain.
  DCM_HD bool addEdgePairs() {
    const bool up_a = a.isUp(), up_b = b.isUp(), alike = up_a == up_b;
    bool rises_a, rises_b;
    bool is_certain = a.riseOfOpposite(rises_a);
    is_certain &= b.riseOfOpposite(rises_b);
    is_certain &=
        addEdges(a.v[0], a.v[1], selected(alike, b.v[0], b.v[2]), selected(alike, b.v[1], b.v[0]),
                 alike ? volume[0][0] : volume[0][1], !up_a, true);
    is_certain &=
        addEdges(a.v[2], a.v[0], selected(alike, b.v[2], b.v[0]), selected(alike, b.v[0], b.v[1]),
                 alike ? volume[1][1] : volume[1][0], up_a, true);
    double edge_volume;
    const bool back_a = rises_b == up_a, back_b = rises_a == up_b;
    const Vec3f p = selected(back_a, a.v[2], a.v[0]), q = selected(back_a, a.v[0], a.v[1]);
    is_certain &= properVolume(p, q, b.v[1], b.v[2], edge_volume);
    is_certain &= addEdges(p, q, b.v[1], b.v[2], edge_volume, rises_b, true);
    const Vec3f r = selected(back_b, b.v[2], b.v[0]), s = selected(back_b, b.v[0], b.v[1]);
    is_certain &= properVolume(a.v[1], a.v[2], r, s, edge_volume);
    is_certain &= addEdges(a.v[1], a.v[2], r, s, edge_volume, rises_a, true);
    const bool counts = rises_a == rises_b;
    is_certain &= properVolume(a.v[1], a.v[2], b.v[1], b.v[2], edge_volume) || !counts;
    is_certain &= addEdges(a.v[1], a.v[2], b.v[1], b.v[2], edge_volume, rises_a, counts);
    return is_certain;
  }
};

// Computes the geometry of triangles, ordered by precedes(), if they properly cross. Returns false
// if that is not certain; then `geometry` is left in an unspecified state.
DCM_HD inline bool fillProperCrossing(const Triangle& first, const Triangle& second,
                                      PairGeometry& geometry) {
  CrossingPair pair;
  if (!pair.addPlanes(first, second) || !pair.findSegment(geometry)) return false;
  const bool is_certain = pair.addEdgePairs();
  const ClearlyNearestFace& nearest = pair.nearest;
  const double depth = sqrt(nearest.squared_distance / nearest.squared_size);
  geometry.normal = toFloat(nearest.normal * (1 / sqrt(nearest.squared_size)));
  geometry.separation_m = 0.0F - toFloat(depth);
  geometry.flags = 0;
  return is_certain && nearest.isCertain() && depth <= FLT_MAX;
}

}  // namespace detail

}  // namespace deformable_contact_monitor
