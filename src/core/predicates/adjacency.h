// Defines what counts as a contact between triangles of one body that share vertices.
//
// Such triangles always touch. They are in contact if they also meet beyond the convex hull of the
// shared vertices: for two triangles on a common edge, if they are folded onto each other; for two
// on a common vertex, if they meet at another point.
#pragma once

#include <cstdint>
#include <type_traits>

#include "core/predicates/triangle_intersection.h"

namespace deformable_contact_monitor {

// Tells which vertices two triangles have in common.
struct SharedVertices {
  bool in_a[3] = {false, false, false};
  bool in_b[3] = {false, false, false};
  bool any = false;
};

// Finds the shared vertices by equal coordinates as received, so that a polygon soup behaves like a
// welded mesh.
DCM_HD inline SharedVertices sharedVertices(const Triangle& a, const Triangle& b) {
  SharedVertices shared;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (a.v[i] == b.v[j]) shared.in_a[i] = shared.in_b[j] = shared.any = true;
    }
  }
  return shared;
}

// Returns one bit for each of a's three vertices that is also one of b's, by their ids.
DCM_HD inline std::uint32_t sharedBits(const std::uint32_t a[3], const std::uint32_t b[3]) {
  std::uint32_t bits = 0;
  for (int i = 0; i < 3; ++i) {
    bits |= (a[i] == b[0] || a[i] == b[1] || a[i] == b[2] ? 1U : 0U) << i;
  }
  return bits;
}

// Makes SharedVertices from sharedBits(a, b) and sharedBits(b, a).
DCM_HD inline SharedVertices sharedByBits(std::uint32_t bits_a, std::uint32_t bits_b) {
  SharedVertices shared;
  for (int i = 0; i < 3; ++i) {
    shared.in_a[i] = (bits_a >> i & 1) != 0;
    shared.in_b[i] = (bits_b >> i & 1) != 0;
  }
  shared.any = bits_a != 0;
  return shared;
}

namespace detail {

// The triangle (p, x[0], x[1]) as one piece, whose edge opposite to p is (x[0], x[1]) and does not
// contain p. A degenerate one is made of two pieces, the segments from p to x[0] and to x[1].
template <class TriangleType, class Point>
struct Fan {
  TriangleType piece[2];
  int count = 0;

  DCM_HD Fan(const Point& p, const Point x[2], int x_count, PredicateState& state) {
    if (x_count == 2 && projectionAxis(p, x[0], x[1], state) >= 0) {
      piece[count++] = {{p, x[0], x[1]}};
      return;
    }
    for (int i = 0; i < x_count; ++i) {
      if (x[i] != p) piece[count++] = {{p, x[i], x[i]}};
    }
  }
};

// Decides for coplanar triangles pab and pcd with area along `axis`. They meet beyond p iff their
// angles at p overlap, that is, iff an edge that leaves p in one of them lies in the angle of the
// other. This is common in flat meshes.
template <class Point>
DCM_HD inline bool anglesMeet(const Point& p, const Point a[2], const Point b[2], int axis,
                              PredicateState& state) {
  const int side_a = orient2d(p, a[0], a[1], axis, state);
  const int side_b = orient2d(p, b[0], b[1], axis, state);
  int s[2][2];
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) s[i][j] = orient2d(p, a[i], b[j], axis, state);
  }
  for (int i = 0; i < 2; ++i) {
    if (-s[i][0] * side_b >= 0 && s[i][1] * side_b >= 0) return true;
    if (s[0][i] * side_a >= 0 && -s[1][i] * side_a >= 0) return true;
  }
  return false;
}

// Decides for two triangles that share only p. If two convex sets that contain p meet at another
// point, they share a segment that leaves p. Along its ray, the edge opposite to p of one piece is
// reached while the ray is still in the other piece. So testing these edges against the other
// pieces is enough.
template <class TriangleType, class Point>
DCM_HD inline bool meetBeyondPoint(const Point& p, const Point a[2], int a_count, const Point b[2],
                                   int b_count, PredicateState& state) {
  if (a_count == 2 && b_count == 2) {
    const int axis = projectionAxis(p, a[0], a[1], state);
    if (axis >= 0 && orient2d(p, b[0], b[1], axis, state) != 0 &&
        orient3d(p, a[0], a[1], b[0], state) == 0 && orient3d(p, a[0], a[1], b[1], state) == 0) {
      return anglesMeet(p, a, b, axis, state);
    }
  }
  const Fan<TriangleType, Point> fan_a(p, a, a_count, state), fan_b(p, b, b_count, state);
  for (int i = 0; i < fan_a.count; ++i) {
    for (int j = 0; j < fan_b.count; ++j) {
      const TriangleType& s = fan_a.piece[i];
      const TriangleType& t = fan_b.piece[j];
      if (segmentIntersectsTriangle(s.v[1], s.v[2], t, state) ||
          segmentIntersectsTriangle(t.v[1], t.v[2], s, state)) {
        return true;
      }
    }
  }
  return false;
}

// For a point a on the line pq: returns 0 if it lies on the segment pq, -1 if it lies beyond p, 1
// if beyond q.
template <class Point>
DCM_HD inline int beyondEnd(const Point& p, const Point& q, const Point& a) {
  if (inBox(a, p, q)) return 0;
  return inBox(p, a, q) ? -1 : 1;
}

// Decides for triangles pqa and pqb. They meet beyond pq iff they are folded onto each other:
// coplanar, with a and b on the same side of pq. Degenerate ones do iff they stick out of pq at the
// same end.
template <class Point>
DCM_HD inline bool meetBeyondEdge(const Point& p, const Point& q, const Point& a, const Point& b,
                                  PredicateState& state) {
  const int side = orient3dFiltered(p, q, a, b);
  if (side == 1 || side == -1) return false;  // not coplanar
  const int axis = projectionAxis(p, q, a, state);
  if (axis < 0) {
    if (projectionAxis(p, q, b, state) >= 0) return false;
    return beyondEnd(p, q, a) * beyondEnd(p, q, b) > 0;
  }
  const int side_a = orient2d(p, q, a, axis, state);
  const int side_b = orient2d(p, q, b, axis, state);
  if (side_a * side_b < 0) return false;  // coplanar or not, they only share pq
  // With side_b == 0 they are coplanar only if b lies on the line pq; then pqb is part of that
  // line.
  if (side_b == 0 && !state.undecided) return false;
  return orient3d(p, q, a, b, state) == 0;
}

}  // namespace detail

// Do two triangles of one body that share vertices meet anywhere beyond the convex hull of the
// distinct shared points? `a` and `b` are posed. In conservative mode an undecided sign makes it
// true. Triangles, or others as in segment_intersection.h.
template <class TriangleType>
DCM_HD DCM_RARE inline bool meetBeyondShared(const TriangleType& a, const TriangleType& b,
                                             const SharedVertices& shared, PredicateState& state) {
  using Point = std::decay_t<decltype(a.v[0])>;
  Point common[3], rest_a[3], rest_b[3];
  int common_count = 0, a_count = 0, b_count = 0;
  for (int i = 0; i < 3; ++i) {
    if (!shared.in_b[i]) rest_b[b_count++] = b.v[i];
    if (!shared.in_a[i]) {
      rest_a[a_count++] = a.v[i];
      continue;
    }
    bool known = false;
    for (int k = 0; k < common_count; ++k) known = known || common[k] == a.v[i];
    if (!known) common[common_count++] = a.v[i];
  }
  if (a_count == 0 || b_count == 0) return false;  // one of them is the hull of the shared points
  const bool meet = common_count == 1
                        ? detail::meetBeyondPoint<TriangleType>(common[0], rest_a, a_count, rest_b,
                                                                b_count, state)
                        : detail::meetBeyondEdge(common[0], common[1], rest_a[0], rest_b[0], state);
  return meet || state.undecided;
}

}  // namespace deformable_contact_monitor
