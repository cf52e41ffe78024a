// Constructs where two triangles intersect: the ends of their common segment.
//
// Exact signs decide which edges and vertices make the ends; then coordinates are computed. A point
// of an edge is where a linear function, known at both ends, is zero. Its coordinates are quotients
// of determinants in double; where too much would cancel, as for an edge that reaches from -1e30 to
// 1e30, their numerators are summed exactly.
#pragma once

#include <cfloat>
#include <cmath>

#include "core/host_device.h"
#include "core/predicates/contact_determinants.h"
#include "core/predicates/orientation.h"
#include "core/predicates/segment_intersection.h"
#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

// Rounds to float32. The result is never infinite: a number that would round beyond the largest
// float32 becomes the largest float32.
DCM_HD inline Vec3f nearestFloats(const Vec3d& v) {
  const auto nearest = [](double x) {
    return toFloat(least<double>(most<double>(x, -FLT_MAX), FLT_MAX));
  };
  return {nearest(v.x), nearest(v.y), nearest(v.z)};
}

DCM_HD inline double largestCoordinate(const Vec3d& v) {
  return most(fabs(v.x), most(fabs(v.y), fabs(v.z)));
}

namespace detail {

// Returns the zero of a linear function, each coordinate right to 2^-50 of itself. `add(v, sum)`
// adds its value at v to an expansion. Values are computed again for each coordinate, because two
// of them at a time would take more of the stack on the device.
template <int N, class Add>
DCM_HD DCM_RARE inline Vec3d exactZeroBetween(const Vec3f& p, const Vec3f& q, const Add& add) {
  // A value is a multiple of 2^-447 below 2^390. Compressed, it has at most 1 + 837 / 52
  // components.
  constexpr int kCompressed = N < 17 ? N : 17;
  double x[3], at_end[2] = {0, 0};
  DCM_ROLLED for (int k = 0; k < 3; ++k) {
    Expansion<4 * kCompressed> sum;
    DCM_ROLLED for (int end = 0; end < 2; ++end) {
      Expansion<N> value;
      add(end == 0 ? q : p, value);
      value.compress();
      sum.addMultiple(value, end == 0 ? p[k] : -static_cast<double>(q[k]));
      at_end[end] = value.value();
    }
    x[k] = sum.value();
  }
  const double divisor = at_end[0] - at_end[1];  // their signs differ
  return {x[0] / divisor, x[1] / divisor, x[2] / divisor};
}

}  // namespace detail

// Returns one of two points, without taking their addresses: that would keep them out of registers.
DCM_HD inline Vec3f selected(bool first, const Vec3f& p, const Vec3f& q) {
  return {first ? p.x : q.x, first ? p.y : q.y, first ? p.z : q.z};
}

// Finds the zero of a linear function whose values at p and q, right to 2^-29 of themselves, have
// different signs. Returns false if the point could be off by more than 2^-23 of its largest
// coordinate.
DCM_HD inline bool zeroNearEnd(const Vec3f& p, const Vec3f& q, double at_p, double at_q,
                               Vec3d& point) {
  constexpr double kMostOffset = 16;  // in largest coordinates of the point
  const bool from_p = fabs(at_p) <= fabs(at_q);
  const Vec3d base = toDouble(selected(from_p, p, q)), other = toDouble(selected(from_p, q, p));
  const double share = (from_p ? at_p : at_q) / (from_p ? at_p - at_q : at_q - at_p);
  const Vec3d offset = (other - base) * share;
  point = base + offset;
  return largestCoordinate(offset) <= kMostOffset * largestCoordinate(point);
}

// Returns the same zero. `add(v, sum)` adds the function's value at v to an Expansion<N>.
template <int N, class Add>
DCM_HD inline Vec3d zeroBetween(const Vec3f& p, const Vec3f& q, double at_p, double at_q,
                                const Add& add) {
  Vec3d point;
  if (zeroNearEnd(p, q, at_p, at_q, point)) return point;
  return detail::exactZeroBetween<N>(p, q, add);
}

// The common segment of two triangles; both ends are equal if they touch at a point. The ends lie
// on both triangles up to 2^-22 of their largest coordinate, rounding to float32 included (and up
// to 2^-148 where that is subnormal). An end that is a vertex is exactly that vertex.
struct CommonSegment {
  Vec3f from, to;
};

// Heights of the vertices of each of two triangles above the other's plane, in units of its normal;
// right to 2^-29 of themselves, and in the sign. They are zero where the other triangle has no
// area.
struct Heights {
  double of_a[3], of_b[3];

  DCM_HD Heights(const Triangle& a, const Triangle& b) {
    DCM_ROLLED for (int i = 0; i < 3; ++i) {
      of_a[i] = detail::contactVolume(b.v[0], b.v[1], b.v[2], a.v[i]);
      of_b[i] = detail::contactVolume(a.v[0], a.v[1], a.v[2], b.v[i]);
    }
  }
};

namespace detail {

DCM_HD inline bool allZero(const double x[3]) { return x[0] == 0 && x[1] == 0 && x[2] == 0; }

// An edge that crosses or touches a plane. It goes from the end that is below the plane or on it to
// the end that is above it or on it; not both ends are on it.
struct Crossing {
  Vec3f low, high;
  double at_low, at_high;

  DCM_HD bool isVertex() const { return at_low == 0 || at_high == 0; }
};

// The two crossings of a triangle's edges with a plane. Seen by someone who stands on the triangle,
// its normal up, and looks in the direction of the plane's normal, one is on the right and one on
// the left.
struct Span {
  Crossing right, left;
};

// Finds the span of t. `side` has the heights of t's vertices above the plane; not all are zero.
// Returns false if all vertices are strictly on one side.
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

// Compares a crossing of a with b's plane and a crossing of b with a's plane. Returns 1 if b's is
// farther along the product of the normals of a and b, 0 if they are the same point.
DCM_HD inline int orderOf(const Crossing& of_a, const Crossing& of_b) {
  const int filtered = orient3dFiltered(of_a.low, of_a.high, of_b.low, of_b.high);
  if (filtered != kUncertain) return filtered;
  const bool has_shared_end = of_a.low == of_b.low || of_a.low == of_b.high ||
                              of_a.high == of_b.low || of_a.high == of_b.high;
  return has_shared_end ? 0 : orient3dExact(of_a.low, of_a.high, of_b.low, of_b.high);
}

DCM_HD DCM_RARE inline Vec3f pointOf(const Crossing& crossing, const Triangle& plane) {
  if (crossing.at_low == 0) return crossing.low;
  if (crossing.at_high == 0) return crossing.high;
  const auto add = [&plane](const Vec3f& v, Expansion<48>& sum) {
    addOrient3d(sum, plane.v[0], plane.v[1], plane.v[2], v);
  };
  return nearestFloats(
      zeroBetween<48>(crossing.low, crossing.high, crossing.at_low, crossing.at_high, add));
}

// Finds the segment of two triangles with area in different planes. Returns false if they do not
// intersect.
DCM_HD inline bool segmentAcrossPlanes(const Triangle& a, const Triangle& b, const Heights& heights,
                                       CommonSegment& segment) {
  Span of_a, of_b;
  if (!spanOf(a, heights.of_a, of_a) || !spanOf(b, heights.of_b, of_b)) return false;
  // Along the product of the normals, the span of a begins on its right, that of b on its left.
  const int a_then_b = orderOf(of_a.right, of_b.right);
  const int b_then_a = orderOf(of_a.left, of_b.left);
  if (a_then_b < 0 || b_then_a > 0) return false;
  if (a_then_b == 0 || b_then_a == 0) {  // they touch at a point
    const Crossing &in_a = a_then_b == 0 ? of_a.right : of_a.left,
                   &in_b = a_then_b == 0 ? of_b.right : of_b.left;
    segment.from = in_b.isVertex() ? pointOf(in_b, a) : pointOf(in_a, b);
    segment.to = segment.from;
    return true;
  }
  const int begins = orderOf(of_a.right, of_b.left);
  const int ends = orderOf(of_a.left, of_b.right);
  const bool from_b = begins > 0 || (begins == 0 && of_b.left.isVertex());
  const bool to_b = ends < 0 || (ends == 0 && of_b.right.isVertex());
  segment.from = from_b ? pointOf(of_b.left, a) : pointOf(of_a.right, b);
  segment.to = to_b ? pointOf(of_b.right, a) : pointOf(of_a.left, b);
  return true;
}

// Finds the point of a triangle t with area and a segment or point `line` that is not in its plane.
// Returns false if they do not intersect.
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

// Returns det[b - a; c - a] of the points' projections along `axis`, exactly.
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

// Keeps the two of the added points that are farthest apart.
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

// Adds the vertices of t that lie in u, which is in the same plane.
DCM_HD DCM_RARE inline void addVerticesWithin(const Triangle& t, const Triangle& u, int axis,
                                              FarthestPair& points) {
  PredicateState state;
  const bool has_area = axis >= 0 && orient2d(u.v[0], u.v[1], u.v[2], axis, state) != 0;
  DCM_ROLLED for (int i = 0; i < 3; ++i) {
    const Vec3f& v = t.v[i];
    const bool within = isVertexOf(u, v) || (has_area ? pointInTriangle(v, u, axis, state)
                                                      : segmentMeetsEdges(v, v, u, state));
    if (within) points.add(v);
  }
}

// Returns the sign of expandedOrient2d(a, b, c, axis).
DCM_HD DCM_RARE inline int sideOfLine(const Vec3f& a, const Vec3f& b, const Vec3f& c, int axis) {
  if (c == a || c == b) return 0;  // common in layers of cloth, and slow otherwise
  PredicateState state;
  return orient2d(a, b, c, axis, state);
}

// Adds the point at which the edges from p to q and from r to s cross at inner points of both.
DCM_HD DCM_RARE inline void addEdgeCrossing(const Vec3f& p, const Vec3f& q, const Vec3f& r,
                                            const Vec3f& s, int axis, FarthestPair& points) {
  const auto height = [&](const Vec3f& v) { return expandedOrient2d(r, s, v, axis); };
  const auto add = [&](const Vec3f& v, Expansion<6>& sum) { sum = height(v); };
  points.add(nearestFloats(zeroBetween<6>(p, q, height(p).value(), height(q).value(), add)));
}

// Adds the points at which edges of a and b, all in one plane, cross at inner points of both.
DCM_HD inline void addEdgeCrossings(const Triangle& a, const Triangle& b, int axis,
                                    FarthestPair& points) {
  DCM_ROLLED for (int i = 0; i < 3; ++i) {
    const Vec3f &p = a.v[i], &q = a.v[i == 2 ? 0 : i + 1];
    DCM_ROLLED for (int j = 0; j < 3; ++j) {
      const Vec3f &r = b.v[j], &s = b.v[j == 2 ? 0 : j + 1];
      if (sideOfLine(r, s, p, axis) * sideOfLine(r, s, q, axis) >= 0) continue;
      if (sideOfLine(p, q, r, axis) * sideOfLine(p, q, s, axis) >= 0) continue;
      addEdgeCrossing(p, q, r, s, axis, points);
    }
  }
}

// Finds the longest chord of the overlap of two triangles in one plane, which has area along
// `axis`, or on one line (axis < 0). Returns false if they do not intersect.
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
