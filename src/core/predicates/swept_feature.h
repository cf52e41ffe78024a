// Features of two moving triangles that may meet: a vertex and a face, two edges, and two triangles
// folded about a common edge. Decided by certain signs, halving the step (float or double).
#pragma once

#include <cstdint>

#include "core/predicates/swept_polynomials.h"
#include "core/predicates/triangle_intersection.h"

namespace deformable_contact_monitor {

enum class FeatureKind {
  kVertexFace,  // x[3] on the triangle x[0] x[1] x[2]
  kEdgeEdge,    // segments x[0] x[1] and x[2] x[3]
  kFold,        // triangles x[0] x[1] x[2] and x[0] x[1] x[3], on the same side of their edge
};

// Four moving points; where they meet, [x1 - x0, x2 - x0, x3 - x0] is 0.
struct Feature {
  FeatureKind kind;
  MovingPoint x[4];
};

constexpr int kFeatures = 15;

// The features of two triangles: first vertices of b and the face of a, then vertices of a and the
// face of b, then edges of a and of b. If they meet, but not at t = 0, one of these does.
DCM_HD inline Feature featureOf(const MovingTriangle& a, const MovingTriangle& b, int index) {
  if (index < 3) {
    return {FeatureKind::kVertexFace, {a.point(0), a.point(1), a.point(2), b.point(index)}};
  }
  if (index < 6) {
    return {FeatureKind::kVertexFace, {b.point(0), b.point(1), b.point(2), a.point(index - 3)}};
  }
  const int i = (index - 6) / 3, j = (index - 6) % 3;
  return {FeatureKind::kEdgeEdge,
          {a.point(i), a.point(i == 2 ? 0 : i + 1), b.point(j), b.point(j == 2 ? 0 : j + 1)}};
}

// Whether the boxes of its two parts are apart at all times.
DCM_HD inline bool areApart(const Feature& feature) {
  MovingBox a, b;
  a.include(feature.x[0]);
  a.include(feature.x[1]);
  (feature.kind == FeatureKind::kVertexFace ? a : b).include(feature.x[2]);
  b.include(feature.x[3]);
  return areApart(a, b);
}

// A cubic that is zero where the four points lie in one plane; of any one sign.
template <class Real>
DCM_HD inline Cubic<Real> coplanarity(const Feature& feature) {
  const MovingVector<Real> u(feature.x[0], feature.x[1]), v(feature.x[0], feature.x[2]),
      w(feature.x[0], feature.x[3]);
  return determinantOf(MovingNormal<Real>(u, v), w);
}

// A feature in an interval of time: D as above, and orientations of points projected along one
// axis. Vertex-face abc, abp, bcp, cap; edge-edge pqa, pqb, abp, abq; fold pqa, pqb.
template <class Real>
struct FeaturePiece {
  Cubic<Real> d;
  Quadratic<Real> q[4];
};

namespace detail {

// The orientations, along the axis of the largest component of the normal halfway.
template <class Real>
DCM_HD inline void orientations(const Feature& feature, Quadratic<Real> q[4]) {
  const MovingPoint* const x = feature.x;
  const MovingVector<Real> u(x[0], x[1]);
  if (feature.kind == FeatureKind::kVertexFace) {
    const MovingVector<Real> v(x[0], x[2]), w(x[0], x[3]), s(x[1], x[2]), t(x[1], x[3]);
    const int axis = longestAxis(MovingNormal<Real>(u, v).middle());
    q[0] = projectedDeterminant(u, v, axis);
    q[1] = projectedDeterminant(u, w, axis);
    q[2] = projectedDeterminant(s, t, axis);
    q[3] = projectedDeterminant(w, v, axis);
    return;
  }
  const MovingVector<Real> v(x[0], x[2]), w(x[0], x[3]);
  if (feature.kind == FeatureKind::kFold) {
    const int axis = longestAxis(MovingNormal<Real>(u, v).middle());
    q[0] = projectedDeterminant(u, v, axis);
    q[1] = projectedDeterminant(u, w, axis);
    q[2] = q[3] = q[1];
    return;
  }
  const MovingVector<Real> s(x[2], x[3]), p(x[2], x[0]), r(x[2], x[1]);
  const int axis = longestAxis(MovingNormal<Real>(u, s).middle());
  q[0] = projectedDeterminant(u, v, axis);
  q[1] = projectedDeterminant(u, w, axis);
  q[2] = projectedDeterminant(s, p, axis);
  q[3] = projectedDeterminant(s, r, axis);
}

DCM_HD inline bool areOpposite(int a, int b) { return a * b < 0; }

// kApart: certainly nowhere in the interval; kMeet: certainly somewhere in it. What does not meet
// in a projection does not meet; where D changes its sign and all orientations are strict, the
// points lie in one plane that the projection does not flatten (abc is the sum of the three others,
// and p and q are on different sides of ab), in that order.
template <class Real>
DCM_HD inline PartVerdict pieceVerdict(FeatureKind kind, const FeaturePiece<Real>& piece) {
  const int s0 = piece.q[0].sign(), s1 = piece.q[1].sign();
  const int s2 = piece.q[2].sign(), s3 = piece.q[3].sign();
  bool apart, inside;
  if (kind == FeatureKind::kVertexFace) {
    apart = areOpposite(s1, s2) || areOpposite(s2, s3) || areOpposite(s3, s1) ||
            areOpposite(s0, s1) || areOpposite(s0, s2) || areOpposite(s0, s3);
    inside = s1 != 0 && s1 == s2 && s1 == s3;
  } else if (kind == FeatureKind::kEdgeEdge) {
    apart = s0 * s1 > 0 || s2 * s3 > 0;
    inside = areOpposite(s0, s1) && areOpposite(s2, s3);
  } else {
    apart = areOpposite(s0, s1);
    inside = s0 * s1 > 0;
  }
  if (apart) return PartVerdict::kApart;
  const bool crosses = areOpposite(piece.d.signAtStart(), piece.d.signAtEnd());
  return inside && crosses ? PartVerdict::kMeet : PartVerdict::kOpen;
}

template <class Real>
DCM_HD inline void halve(const FeaturePiece<Real>& piece, FeaturePiece<Real>& left,
                         FeaturePiece<Real>& right) {
  piece.d.halve(left.d, right.d);
  for (int i = 0; i < 4; ++i) piece.q[i].halve(left.q[i], right.q[i]);
}

}  // namespace detail

// When a feature first meets. kMeet: not before `low`, and somewhere in [low, high]; kApart: never;
// kOpen: not before `low`.
struct FeatureVerdict {
  PartVerdict part = PartVerdict::kApart;
  float low = 0, high = 0;
};

constexpr int kMostHalvings = 24;  // times are multiples of 2^-24: exact in float32
constexpr int kTimeHalvings = 21;  // first times are told to 2^-20, rounding included
constexpr int kMostPieces = 200;

// What halving tells of a feature with coplanarity `d`, in [0, until] alone. Without
// `wants_time`, `high` is only some time by which it has met.
template <class Real>
DCM_HD inline FeatureVerdict halvedVerdict(const Feature& feature, const Cubic<Real>& d,
                                           bool wants_time, float until) {
  struct Node {
    FeaturePiece<Real> piece;
    float low;
    int halvings;
  };
  Node stack[kMostHalvings + 2];
  stack[0].piece.d = d;
  detail::orientations(feature, stack[0].piece.q);
  stack[0].low = 0;
  stack[0].halvings = 0;
  int count = 1;
  for (int pieces = 0; count > 0; ++pieces) {
    const Node node = stack[--count];
    if (node.low > until) return {};
    if (node.piece.d.sign() != 0) continue;
    const PartVerdict part = detail::pieceVerdict(feature.kind, node.piece);
    if (part == PartVerdict::kApart) continue;
    const float width = 1.0F / static_cast<float>(1 << node.halvings);
    if (part == PartVerdict::kMeet && !(wants_time && node.halvings < kTimeHalvings)) {
      return {part, node.low, node.low + width};
    }
    if (node.halvings == kMostHalvings || pieces == kMostPieces) {
      return {PartVerdict::kOpen, node.low, 1};
    }
    Node& right = stack[count];
    Node& left = stack[count + 1];
    count += 2;
    detail::halve(node.piece, left.piece, right.piece);
    left.halvings = right.halvings = node.halvings + 1;
    left.low = node.low;
    right.low = node.low + width / 2;
  }
  return {};
}

}  // namespace deformable_contact_monitor
