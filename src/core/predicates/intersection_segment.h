// Where two triangles intersect: the ends of their common segment.
//
// Which edges and vertices make the ends, exact signs decide; then the ends' coordinates are
// constructed.
#pragma once

#include "core/predicates/edge_crossing.h"
#include "core/predicates/segment_intersection.h"
#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

// Equal if the triangles touch at a point. Ends lie on both triangles, but for less than 2^-22 of
// their largest coordinate, rounding to float32 included (and for 2^-148 where that is subnormal);
// an end that is a vertex is that vertex.
struct CommonSegment {
  Vec3f from, to;
};

// How far the vertices of each of two triangles are above the other's plane, in units of its
// normal; right to a part in 2^29 and in the sign. Zeros where the other has no area.
struct Heights {
  double of_a[3], of_b[3];

  DCM_HD Heights(const Triangle& a, const Triangle& b) {
    DCM_ROLLED for (int i = 0; i < 3; ++i) {
      of_a[i] = detail::volumeOf(b.v[0], b.v[1], b.v[2], a.v[i]);
      of_b[i] = detail::volumeOf(a.v[0], a.v[1], a.v[2], b.v[i]);
    }
  }
};

namespace detail {

DCM_HD inline bool allZero(const double x[3]) { return x[0] == 0 && x[1] == 0 && x[2] == 0; }

// An edge that crosses or touches a plane, from where it is below it or on it to where it is above
// it or on it; not both ends are on it.
struct Crossing {
  Vec3f low, high;
  double at_low, at_high;

  DCM_HD bool isVertex() const { return at_low == 0 || at_high == 0; }
};

// The crossings of a triangle with a plane: from the right to the left of one who stands on the
// triangle, its normal up, and looks to where the plane's normal points.
struct Span {
  Crossing right, left;
};

// `side`: heights of t's vertices above the plane; not all zero. False: no vertex is on it or
// beyond.
DCM_HD inline bool spanOf(const Triangle& t, const double side[3], Span& span) {
  DCM_ROLLED for (int i = 0; i < 3; ++i) {
    const int j = i == 2 ? 0 : i + 1, k = j == 2 ? 0 : j + 1;
    const double s = side[i], u = side[j], w = side[k];
    if ((s > 0 && u <= 0 && w <= 0) || (s == 0 && u < 0 && w < 0)) {
      span = {{t.v[k], t.v[i], w, s}, {t.v[j], t.v[i], u, s}};
      return true;
    }
    if ((s < 0 && u >= 0 && w >= 0) || (s == 0 && u > 0 && w > 0)) {
      span = {{t.v[i], t.v[j], s, u}, {t.v[i], t.v[k], s, w}};
      return true;
    }
  }
  return false;
}

// Of a crossing of a with b's plane and one of b with a's: 1 if b's is farther along the product of
// the normals of a and b, 0 if they are one point.
DCM_HD inline int orderOf(const Crossing& of_a, const Crossing& of_b, PredicateState& state) {
  return orient3d(of_a.low, of_a.high, of_b.low, of_b.high, state);
}

DCM_HD DCM_RARE inline Vec3f pointOf(const Crossing& crossing, const Triangle& plane) {
  if (crossing.at_low == 0) return crossing.low;
  if (crossing.at_high == 0) return crossing.high;
  return nearestFloats(zeroBetween(crossing.low, crossing.high, crossing.at_low, crossing.at_high,
                                   [&plane](const Vec3f& v) {
                                     return expandedOrient3d(plane.v[0], plane.v[1], plane.v[2], v);
                                   }));
}

// Both have area, in different planes. False: they do not intersect.
DCM_HD inline bool segmentAcrossPlanes(const Triangle& a, const Triangle& b, const Heights& heights,
                                       CommonSegment& segment) {
  Span of_a, of_b;
  if (!spanOf(a, heights.of_a, of_a) || !spanOf(b, heights.of_b, of_b)) return false;
  // Along the product of the normals, a's begins on its right, b's on its left.
  PredicateState state;
  const int a_then_b = orderOf(of_a.right, of_b.right, state);
  const int b_then_a = orderOf(of_a.left, of_b.left, state);
  if (a_then_b < 0 || b_then_a > 0) return false;
  if (a_then_b == 0 || b_then_a == 0) {  // they touch at a point
    const Crossing &in_a = a_then_b == 0 ? of_a.right : of_a.left,
                   &in_b = a_then_b == 0 ? of_b.right : of_b.left;
    segment.from = in_b.isVertex() ? pointOf(in_b, a) : pointOf(in_a, b);
    segment.to = segment.from;
    return true;
  }
  const int begins = orderOf(of_a.right, of_b.left, state);
  const int ends = orderOf(of_a.left, of_b.right, state);
  const bool from_b = begins > 0 || (begins == 0 && of_b.left.isVertex());
  const bool to_b = ends < 0 || (ends == 0 && of_b.right.isVertex());
  segment.from = from_b ? pointOf(of_b.left, a) : pointOf(of_a.right, b);
  segment.to = to_b ? pointOf(of_b.right, a) : pointOf(of_a.left, b);
  return true;
}

// t has area; `line` is a segment or a point that is not in its plane. False: they do not
// intersect.
DCM_HD DCM_RARE inline bool pointAcrossPlane(const Triangle& t, const Triangle& line,
                                             const double side[3], CommonSegment& segment) {
  PredicateState state;
  int low = 0, high = 0;
  for (int i = 1; i < 3; ++i) {
    if (side[i] < side[low]) low = i;
    if (side[i] > side[high]) high = i;
  }
  const Crossing crossing{line.v[low], line.v[high], side[low], side[high]};
  if (crossing.at_low > 0 || crossing.at_high < 0) return false;
  if (!segmentIntersectsTriangle(crossing.low, crossing.high, t, state)) return false;
  segment.from = segment.to = pointOf(crossing, t);
  return true;
}

// det[b - a; c - a] of the points' projections along `axis`.
DCM_HD DCM_RARE inline Expansion<6> expandedOrient2d(const Vec3f& a, const Vec3f& b, const Vec3f& c,
                                                     int axis) {
  float ax, ay, bx, by, cx, cy;
  projected(a, axis, ax, ay);
  projected(b, axis, bx, by);
  projected(c, axis, cx, cy);
  Expansion<6> sum;
  sum.addProduct(ax, by);
  sum.addProduct(-static_cast<double>(ay), bx);
  sum.addProduct(bx, cy);
  sum.addProduct(-static_cast<double>(by), cx);
  sum.addProduct(cx, ay);
  sum.addProduct(-static_cast<double>(cy), ax);
  return sum;
}

// The farthest two of the points that were added.
struct FarthestPair {
  static constexpr int kMost = 15;  // six vertices, and nine crossings of edges
  Vec3f point[kMost];
  int count = 0;
  CommonSegment segment;
  double longest2 = -1;

  DCM_HD DCM_RARE void add(const Vec3f& p) {
    point[count++] = p;
    DCM_ROLLED for (int i = 0; i < count; ++i) {
      const Vec3d d = toDouble(p) - toDouble(point[i]);
      const double squared = dot(d, d);
      if (squared <= longest2) continue;
      longest2 = squared;
      segment = {point[i], p};
    }
  }
};

// Adds the vertices of t that are in u, in the same plane.
DCM_HD DCM_RARE inline void addVerticesWithin(const Triangle& t, const Triangle& u, int axis,
                                              FarthestPair& points) {
  PredicateState state;
  const bool has_area = axis >= 0 && orient2d(u.v[0], u.v[1], u.v[2], axis, state) != 0;
  DCM_ROLLED for (int i = 0; i < 3; ++i) {
    const Vec3f& v = t.v[i];
    const bool within =
        has_area ? pointInTriangle(v, u, axis, state) : segmentMeetsEdges(v, v, u, state);
    if (within) points.add(v);
  }
}

// Adds the points at which edges of a and b, in one plane, cross at inner points of both.
DCM_HD inline void addEdgeCrossings(const Triangle& a, const Triangle& b, int axis,
                                    FarthestPair& points) {
  DCM_ROLLED for (int i = 0; i < 3; ++i) {
    const Vec3f &p = a.v[i], &q = a.v[i == 2 ? 0 : i + 1];
    DCM_ROLLED for (int j = 0; j < 3; ++j) {
      const Vec3f &r = b.v[j], &s = b.v[j == 2 ? 0 : j + 1];
      const auto height = [&](const Vec3f& v) { return expandedOrient2d(r, s, v, axis); };
      const Expansion<6> at_p = height(p), at_q = height(q);
      if (at_p.sign() * at_q.sign() >= 0) continue;
      if (expandedOrient2d(p, q, r, axis).sign() * expandedOrient2d(p, q, s, axis).sign() >= 0) {
        continue;
      }
      points.add(nearestFloats(zeroBetween(p, q, at_p.value(), at_q.value(), height)));
    }
  }
}

// Of triangles in one plane, which projects along `axis` to a plane, or in one line (axis < 0): the
// longest chord. False: they do not intersect.
DCM_HD DCM_RARE inline bool longestChord(const Triangle& a, const Triangle& b, int axis,
                                         CommonSegment& segment) {
  FarthestPair points;
  addVerticesWithin(a, b, axis, points);
  addVerticesWithin(b, a, axis, points);
  if (axis >= 0) addEdgeCrossings(a, b, axis, points);
  segment = points.segment;
  return points.count > 0;
}

}  // namespace detail

}  // namespace deformable_contact_monitor
