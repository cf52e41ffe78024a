// The distance between triangles that do not intersect, for margins.
//
// The nearest points of two such triangles are two vertices, or a vertex and a point of an edge or
// a face, or points of two edges. Where the perpendicular meets that edge or face, each of these
// distances is a quotient of determinants of the coordinates. These are computed in double, and
// exactly where too much would cancel: otherwise a vertex at 1e30 would leave nothing but rounding
// noise. So the result is right to 2^-28 of itself for all finite float32 input. It is made of + -
// * / fma and sqrt, which round alike on host and device, so that both get the same bits. Nothing
// overflows or underflows: squares of determinants lie between 2^-894 and 2^780.
#pragma once

#include <cmath>

#include "core/host_device.h"
#include "core/predicates/orientation.h"
#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

namespace detail {

// A determinant in double that is at least this fraction of the sum of its terms is right to 2^-29
// of itself.
constexpr double kEnough = 1.0 / (1 << 20);

// Returns (b - a)_i (d - c)_j - (b - a)_j (d - c)_i. Products of two float32 are exact in double.
DCM_HD inline double exactCrossComponent(const Vec3f& a, const Vec3f& b, const Vec3f& c,
                                         const Vec3f& d, int i, int j) {
  Expansion<8> sum;
  const auto add = [&sum, i, j](const Vec3f& x, const Vec3f& y, double sign) {
    sum.add(sign * x[i] * y[j]);
    sum.add(-sign * x[j] * y[i]);
  };
  add(b, d, 1);
  add(b, c, -1);
  add(a, d, -1);
  add(a, c, 1);
  return sum.value();
}

DCM_HD DCM_RARE inline Vec3d exactCross(const Vec3f& a, const Vec3f& b, const Vec3f& c,
                                        const Vec3f& d) {
  return {exactCrossComponent(a, b, c, d, 1, 2), exactCrossComponent(a, b, c, d, 2, 0),
          exactCrossComponent(a, b, c, d, 0, 1)};
}

// Returns (b - a) x (d - c).
DCM_HD inline Vec3d crossOf(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& d) {
  const Vec3d u = toDouble(b) - toDouble(a), v = toDouble(d) - toDouble(c);
  const double m1 = u.y * v.z, m2 = u.z * v.y, m3 = u.z * v.x;
  const double m4 = u.x * v.z, m5 = u.x * v.y, m6 = u.y * v.x;
  const Vec3d n{m1 - m2, m3 - m4, m5 - m6};
  // Each component is checked by itself: beside the long edge of a needle, the one that decides a
  // side may be far smaller than the others.
  const bool enough = fabs(n.x) >= kEnough * (fabs(m1) + fabs(m2)) &&
                      fabs(n.y) >= kEnough * (fabs(m3) + fabs(m4)) &&
                      fabs(n.z) >= kEnough * (fabs(m5) + fabs(m6));
  return enough ? n : exactCross(a, b, c, d);
}

DCM_HD DCM_RARE inline double exactVolume(const Vec3f& a, const Vec3f& b, const Vec3f& c,
                                          const Vec3f& d) {
  Expansion<48> sum;
  addOrient3d(sum, a, b, c, d);
  return sum.value();
}

// Returns det[b - a; c - a; d - a].
DCM_HD inline double volumeOf(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& d) {
  double permanent;
  const double volume = orient3dDouble(a, b, c, d, permanent);
  return fabs(volume) >= kEnough * permanent ? volume : exactVolume(a, b, c, d);
}

// Returns the squared distance of p from the segment from q to r; `area` is (q - p) x (r - q).
DCM_HD inline double squaredToSegment(const Vec3f& p, const Vec3f& q, const Vec3f& r,
                                      const Vec3d& area) {
  const Vec3d from_q = toDouble(p) - toDouble(q), from_r = toDouble(p) - toDouble(r);
  const Vec3d along = toDouble(r) - toDouble(q);
  if (!(dot(from_q, along) > 0)) return dot(from_q, from_q);
  if (!(dot(from_r, along) < 0)) return dot(from_r, from_r);
  return dot(area, area) / dot(along, along);
}

// Twice the area, as a normal vector, of each vertex of `t` with each edge of `u`: of[i][j] is (u_j
// - t_i) x (u_j+1 - u_j). It tells on which side of the edge the vertex lies, seen along any
// direction.
struct VertexEdgeAreas {
  Vec3d of[3][3];

  DCM_HD VertexEdgeAreas(const Triangle& t, const Triangle& u) {
    DCM_ROLLED for (int i = 0; i < 3; ++i) {
      DCM_ROLLED for (int j = 0; j < 3; ++j) {
        of[i][j] = crossOf(t.v[i], u.v[j], u.v[j], u.v[j == 2 ? 0 : j + 1]);
      }
    }
  }
};

// Returns the squared distance of vertex i of `t` from the edges and the face of `u`. `area` has
// VertexEdgeAreas::of[i], and `normal` is that of u.
DCM_HD inline double squaredVertexDistance(const Triangle& t, int i, const Triangle& u,
                                           const Vec3d* area, const Vec3d& normal) {
  const double size2 = dot(normal, normal);
  if (size2 > 0 && dot(area[0], normal) >= 0 && dot(area[1], normal) >= 0 &&
      dot(area[2], normal) >= 0) {
    const double volume = volumeOf(u.v[0], u.v[1], u.v[2], t.v[i]);
    return volume * volume / size2;  // no edge is nearer
  }
  double least2 = INFINITY;
  DCM_ROLLED for (int j = 0; j < 3; ++j) {
    least2 = least(least2, squaredToSegment(t.v[i], u.v[j], u.v[j == 2 ? 0 : j + 1], area[j]));
  }
  return least2;
}

// Returns the squared distance of the edges from p to q and from r to s, or infinity if their
// common perpendicular does not meet both. The areas are those of the ends with the other edge.
DCM_HD inline double squaredEdgeDistance(const Vec3f& p, const Vec3f& q, const Vec3f& r,
                                         const Vec3f& s, const Vec3d& area_p, const Vec3d& area_q,
                                         const Vec3d& area_r, const Vec3d& area_s) {
  const Vec3d normal = crossOf(p, q, r, s);
  const double size2 = dot(normal, normal);
  // The ends of each edge must lie on different sides of the other edge, seen along the normal.
  if (!(size2 > 0 && dot(area_p, normal) >= 0 && dot(area_q, normal) <= 0 &&
        dot(area_r, normal) <= 0 && dot(area_s, normal) >= 0)) {
    return INFINITY;
  }
  const double volume = volumeOf(p, q, r, s);
  return volume * volume / size2;
}

// Returns the least squared distance of the vertices of `t` from the edges and the face of `u`.
DCM_HD inline double squaredVerticesDistance(const Triangle& t, const Triangle& u,
                                             const VertexEdgeAreas& areas) {
  const Vec3d normal = crossOf(u.v[0], u.v[1], u.v[1], u.v[2]);
  double least2 = INFINITY;
  DCM_ROLLED for (int i = 0; i < 3; ++i) {
    least2 = least(least2, squaredVertexDistance(t, i, u, areas.of[i], normal));
  }
  return least2;
}

// Returns the least squared distance of edges of `t` and edges of `u` whose common perpendicular
// meets both.
DCM_HD inline double squaredEdgesDistance(const Triangle& t, const Triangle& u,
                                          const VertexEdgeAreas& t_areas,
                                          const VertexEdgeAreas& u_areas) {
  double least2 = INFINITY;
  DCM_ROLLED for (int i = 0; i < 3; ++i) {
    const int i_next = i == 2 ? 0 : i + 1;
    DCM_ROLLED for (int j = 0; j < 3; ++j) {
      const int j_next = j == 2 ? 0 : j + 1;
      least2 = least(least2, squaredEdgeDistance(t.v[i], t.v[i_next], u.v[j], u.v[j_next],
                                                 t_areas.of[i][j], t_areas.of[i_next][j],
                                                 u_areas.of[j][i], u_areas.of[j_next][i]));
    }
  }
  return least2;
}

// Orders triangles by their coordinates, so that results do not depend on the order of the
// arguments.
DCM_HD inline bool precedes(const Triangle& a, const Triangle& b) {
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      if (a.v[i][k] != b.v[i][k]) return a.v[i][k] < b.v[i][k];
    }
  }
  return false;
}

DCM_HD inline double orderedSeparation(const Triangle& a, const Triangle& b) {
  const VertexEdgeAreas a_areas(a, b), b_areas(b, a);
  return sqrt(
      least(squaredEdgesDistance(a, b, a_areas, b_areas),
            least(squaredVerticesDistance(a, b, a_areas), squaredVerticesDistance(b, a, b_areas))));
}

// The features of two triangles, of which the nearest decides their distance: nine pairs of edges,
// the vertices of a, and those of b.
constexpr int kFeatures = 15;

// Returns the squared distance of one feature, or infinity where another one is certainly nearer.
// The root of the least one is orderedSeparation(), bit by bit. For processors that compute
// features side by side.
DCM_HD inline double squaredFeatureDistance(const Triangle& a, const Triangle& b, int feature) {
  const auto area = [](const Vec3f& p, const Vec3f& q, const Vec3f& r) {
    return crossOf(p, q, q, r);
  };
  if (feature < 9) {
    const int i = feature / 3, j = feature % 3;
    const Vec3f &p = a.v[i], &q = a.v[i == 2 ? 0 : i + 1];
    const Vec3f &r = b.v[j], &s = b.v[j == 2 ? 0 : j + 1];
    return squaredEdgeDistance(p, q, r, s, area(p, r, s), area(q, r, s), area(r, p, q),
                               area(s, p, q));
  }
  const Triangle &t = feature < 12 ? a : b, &u = feature < 12 ? b : a;
  const int i = feature % 3;
  Vec3d areas[3];
  for (int j = 0; j < 3; ++j) areas[j] = area(t.v[i], u.v[j], u.v[j == 2 ? 0 : j + 1]);
  return squaredVertexDistance(t, i, u, areas, crossOf(u.v[0], u.v[1], u.v[1], u.v[2]));
}

// Returns whether all vertices of `t` are certainly on one side of the plane of `u`, and farther
// from it than `distance`.
DCM_HD inline bool isBeyondPlane(const Triangle& t, const Triangle& u, double distance) {
  const Vec3d o = toDouble(u.v[0]), p = toDouble(u.v[1]) - o, q = toDouble(u.v[2]) - o;
  const double m1 = p.y * q.z, m2 = p.z * q.y, m3 = p.z * q.x;
  const double m4 = p.x * q.z, m5 = p.x * q.y, m6 = p.y * q.x;
  const Vec3d normal{m1 - m2, m3 - m4, m5 - m6};
  const Vec3d terms{fabs(m1) + fabs(m2), fabs(m3) + fabs(m4), fabs(m5) + fabs(m6)};
  constexpr double kBound = 7.8e-16;  // as in orient3dFiltered, and more than the normal needs
  const double reach =
      distance * (sqrt(dot(normal, normal)) + kBound * (terms.x + terms.y + terms.z));
  double low = INFINITY, high = -INFINITY;
  for (int i = 0; i < 3; ++i) {
    const Vec3d w = toDouble(t.v[i]) - o;
    const double height = dot(w, normal);
    const double error = kBound * (fabs(w.x) * terms.x + fabs(w.y) * terms.y + fabs(w.z) * terms.z);
    low = least(low, height - error);
    high = most(high, height + error);
  }
  constexpr double kRounding = 1 + 1e-14;  // of this function's own sums
  return low > reach * kRounding || high < -reach * kRounding;
}

}  // namespace detail

// Returns whether the plane of one triangle certainly keeps the other one farther away than
// `distance` [m].
DCM_HD inline bool arePlanesApart(const Triangle& a, const Triangle& b, double distance) {
  return detail::isBeyondPlane(a, b, distance) || detail::isBeyondPlane(b, a, distance);
}

// Returns the distance [m] of two triangles that do not intersect, degenerate ones included. The
// result for (b, a) has the same bits.
DCM_HD DCM_RARE inline double separation(const Triangle& a, const Triangle& b) {
  const bool swap = detail::precedes(b, a);
  return detail::orderedSeparation(swap ? b : a, swap ? a : b);
}

}  // namespace deformable_contact_monitor
