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

// The same for all features of two triangles.
class FeatureBoxes {
 public:
  DCM_HD FeatureBoxes(const MovingTriangle& a, const MovingTriangle& b)
      : a_(a), b_(b), face_a_(boxOf(a)), face_b_(boxOf(b)) {
    for (int i = 0; i < 3; ++i) {
      const int j = i == 2 ? 0 : i + 1;
      edge_a_[i].include(a.point(i));
      edge_a_[i].include(a.point(j));
      edge_b_[i].include(b.point(i));
      edge_b_[i].include(b.point(j));
    }
  }

  // Of featureOf(a, b, index).
  DCM_HD bool areApart(int index) const {
    if (index < 3) return isApart(b_.point(index), face_a_);
    if (index < 6) return isApart(a_.point(index - 3), face_b_);
    const int i = (index - 6) / 3, j = (index - 6) % 3;
    return deformable_contact_monitor::areApart(edge_a_[i], edge_b_[j]);
  }

 private:
  DCM_HD static bool isApart(const MovingPoint& p, const MovingBox& box) {
    return deformable_contact_monitor::areApart(MovingBox{{p.from, p.from}, {p.to, p.to}}, box);
  }

  const MovingTriangle &a_, &b_;
  MovingBox face_a_, face_b_, edge_a_[3], edge_b_[3];
};

// A cubic that is zero where the four points lie in one plane; of any one sign.
template <class Real>
DCM_HD inline Cubic<Real> coplanarity(const Feature& feature) {
  const MovingVector<Real> u(feature.x[0], feature.x[1]), v(feature.x[0], feature.x[2]),
      w(feature.x[0], feature.x[3]);
  return determinantOf(MovingNormal<Real>(u, v), w);
}

namespace detail {

DCM_HD inline bool areOpposite(int a, int b) { return a * b < 0; }

// The axis of the largest component of a normal halfway.
template <class Real>
DCM_HD inline int projectionAxis(const MovingVector<Real>& u, const MovingVector<Real>& v) {
  return longestAxis(crossOf(sumOf(u.from, u.to), sumOf(v.from, v.to)));
}

// A feature in an interval of time: its coplanarity D, and orientations of points projected along
// one axis. Vertex-face abc, abp, bcp, cap; edge-edge pqa, pqb, abp, abq; fold pqa, pqb.
template <class Real>
struct FeaturePiece {
  Cubic<Real> d;
  Quadratic<Real> q[4];  // not kept where its sign is known
  int sign[4];           // certain on the whole interval, or 0

  DCM_HD void set(int i, const MovingVector<Real>& u, const MovingVector<Real>& v, int axis) {
    q[i] = projectedDeterminant(u, v, axis);
    sign[i] = q[i].sign();
  }
};

// Whether the projections do not meet at any time of the interval: then nor do the parts.
template <class Real>
DCM_HD inline bool isApart(FeatureKind kind, const FeaturePiece<Real>& piece) {
  const int* const s = piece.sign;
  if (kind == FeatureKind::kVertexFace) {
    return areOpposite(s[1], s[2]) || areOpposite(s[2], s[3]) || areOpposite(s[3], s[1]) ||
           areOpposite(s[0], s[1]) || areOpposite(s[0], s[2]) || areOpposite(s[0], s[3]);
  }
  if (kind == FeatureKind::kEdgeEdge) return s[0] * s[1] > 0 || s[2] * s[3] > 0;
  return areOpposite(s[0], s[1]);
}

// Whether they meet certainly in the interval: D changes its sign, and where it vanishes the points
// lie in one plane that the projection does not flatten (abc is the sum of the three others, and p
// and q are on different sides of ab), in that order.
template <class Real>
DCM_HD inline bool isInside(FeatureKind kind, const FeaturePiece<Real>& piece) {
  const int* const s = piece.sign;
  const bool inside = kind == FeatureKind::kVertexFace ? s[1] != 0 && s[1] == s[2] && s[1] == s[3]
                      : kind == FeatureKind::kEdgeEdge
                          ? areOpposite(s[0], s[1]) && areOpposite(s[2], s[3])
                          : s[0] * s[1] > 0;
  return inside && areOpposite(piece.d.signAtStart(), piece.d.signAtEnd());
}

// The orientations in the whole step; false if they tell at once that it is apart.
template <class Real>
DCM_HD inline bool setOrientations(const Feature& feature, FeaturePiece<Real>& piece) {
  const MovingPoint* const x = feature.x;
  const MovingVector<Real> u(x[0], x[1]), v(x[0], x[2]), w(x[0], x[3]);
  piece.sign[0] = piece.sign[1] = piece.sign[2] = piece.sign[3] = 0;
  if (feature.kind == FeatureKind::kVertexFace) {
    const MovingVector<Real> s(x[1], x[2]), t(x[1], x[3]);
    const int axis = projectionAxis(u, v);
    piece.set(1, u, w, axis);
    piece.set(2, s, t, axis);
    if (isApart(feature.kind, piece)) return false;
    piece.set(3, w, v, axis);
    piece.set(0, u, v, axis);
  } else if (feature.kind == FeatureKind::kEdgeEdge) {
    const MovingVector<Real> s(x[2], x[3]), p(x[2], x[0]), r(x[2], x[1]);
    const int axis = projectionAxis(u, s);
    piece.set(0, u, v, axis);
    piece.set(1, u, w, axis);
    if (isApart(feature.kind, piece)) return false;
    piece.set(2, s, p, axis);
    piece.set(3, s, r, axis);
  } else {
    const int axis = projectionAxis(u, v);
    piece.set(0, u, v, axis);
    piece.set(1, u, w, axis);
    piece.q[2] = piece.q[3] = piece.q[1];
  }
  return !isApart(feature.kind, piece);
}

// What halving adds to the errors of a feature's polynomials.
template <class Real>
struct ErrorsOfHalving {
  Real d, q[4];

  ErrorsOfHalving() = default;
  DCM_HD explicit ErrorsOfHalving(const FeaturePiece<Real>& piece) : d(piece.d.errorOfHalving()) {
    for (int i = 0; i < 4; ++i) q[i] = piece.q[i].errorOfHalving();
  }
};

// The orientations in both halves; those of known sign keep it. `piece` becomes its left half.
template <class Real>
DCM_HD inline void halveOrientations(const ErrorsOfHalving<Real>& errors, FeaturePiece<Real>& piece,
                                     FeaturePiece<Real>& right) {
  for (int i = 0; i < 4; ++i) {
    right.sign[i] = piece.sign[i];
    if (piece.sign[i] != 0) continue;
    piece.q[i].halve(errors.q[i], piece.q[i], right.q[i]);
    piece.sign[i] = piece.q[i].sign();
    right.sign[i] = right.q[i].sign();
  }
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

// What halving tells of a feature with coplanarity `d`, not of one sign, in [0, until] alone.
// Without `wants_time`, `high` is only some time by which it has met.
template <class Real>
DCM_HD inline FeatureVerdict halvedVerdict(const Feature& feature, const Cubic<Real>& d,
                                           bool wants_time, float until) {
  struct Node {
    detail::FeaturePiece<Real> piece;
    float low, width;
  };
  const float narrow = wants_time ? 1.0F / (1 << kTimeHalvings) : 1.0F;
  constexpr float kNarrowest = 1.0F / (1 << kMostHalvings);
  Node node;
  node.piece.d = d;
  node.low = 0;
  node.width = 1;
  if (!detail::setOrientations(feature, node.piece)) return {};
  const detail::ErrorsOfHalving<Real> errors(node.piece);
  Node later[kMostHalvings];  // right halves, the earliest last
  int count = 0;
  for (int pieces = 0;; ++pieces) {
    if (node.low > until) return {};
    if (!detail::isApart(feature.kind, node.piece)) {
      if (node.width <= narrow && detail::isInside(feature.kind, node.piece)) {
        return {PartVerdict::kMeet, node.low, node.low + node.width};
      }
      if (node.width == kNarrowest || pieces == kMostPieces) {
        return {PartVerdict::kOpen, node.low, 1};
      }
      Node& right = later[count];
      node.piece.d.halve(errors.d, node.piece.d, right.piece.d);
      detail::halveOrientations(errors, node.piece, right.piece);
      node.width /= 2;
      right.low = node.low + node.width;
      right.width = node.width;
      count += right.piece.d.sign() == 0 ? 1 : 0;
      if (node.piece.d.sign() == 0) continue;
    }
    if (count == 0) return {};
    node = later[--count];
  }
}

}  // namespace deformable_contact_monitor
