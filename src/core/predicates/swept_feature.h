// Features of two moving triangles that may meet: a vertex and a face, two edges, or two triangles
// folded about a common edge.
//
// If two triangles meet, but not at t = 0, one of their 15 features meets first. When a feature
// meets, its four points lie in one plane, so that a cubic in time is zero. halvedVerdict() halves
// the time interval until the signs of that cubic and of projected orientations are certain, in
// float or double. swept_integers.h decides many cases that double leaves open.
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

// The decision on a feature. kMeet: it meets first in [low, high], and not before. kApart: it never
// meets. kOpen: it does not meet before `low`.
struct FeatureVerdict {
  PartVerdict part = PartVerdict::kApart;
  float low = 0, high = 0;
};

// Four moving points. Where they meet, the determinant [x1 - x0, x2 - x0, x3 - x0] is 0.
struct Feature {
  FeatureKind kind;
  MovingPoint x[4];
};

constexpr int kFeatures = 15;

constexpr int kMostHalvings = 24;  // times are multiples of 2^-24: exact in float32
constexpr int kTimeHalvings = 21;  // first times are told to kTimeWidth, rounding included
constexpr float kTimeWidth = 1.0F / (1 << 20);
constexpr int kMostPieces = 200;

// Returns a feature of two triangles: vertices of b with the face of a (0 to 2), vertices of a with
// the face of b (3 to 5), edges of a with edges of b (6 to 14). If they meet, but not at t = 0, one
// of these meets.
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

// Returns whether the boxes of its two parts are apart at all times.
DCM_HD inline bool areApart(const Feature& feature) {
  MovingBox a, b;
  a.include(feature.x[0]);
  a.include(feature.x[1]);
  (feature.kind == FeatureKind::kVertexFace ? a : b).include(feature.x[2]);
  b.include(feature.x[3]);
  return areApart(a, b);
}

// Makes that test for all features of two triangles, with boxes that are computed once.
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

  // Tests featureOf(a, b, index).
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

// Returns a cubic that is zero where the four points lie in one plane; its sign has no meaning.
template <class Real>
DCM_HD inline Cubic<Real> coplanarity(const Feature& feature) {
  const MovingVector<Real> u(feature.x[0], feature.x[1]), v(feature.x[0], feature.x[2]),
      w(feature.x[0], feature.x[3]);
  return determinantOf(MovingNormal<Real>(u, v), w);
}

namespace detail {

DCM_HD inline bool areOpposite(int a, int b) { return a * b < 0; }

// Returns the axis of the largest component of a normal halfway through the interval.
template <class Real>
DCM_HD inline int projectionAxis(const MovingVector<Real>& u, const MovingVector<Real>& v) {
  return longestAxis(crossOf(sumOf(u.from, u.to), sumOf(v.from, v.to)));
}

// A feature in an interval of time: its coplanarity D, and orientations of points projected along
// one axis. For vertex-face these are abc, abp, bcp, cap; for edge-edge pqa, pqb, abp, abq; for a
// fold pqa, pqb.
template <class Real>
struct FeaturePiece {
  using Number = Real;

  Cubic<Real> d;
  Quadratic<Real> q[4];  // not kept where its sign is known
  int sign[4];           // certain on the whole interval, or 0

  DCM_HD void set(int i, const MovingVector<Real>& u, const MovingVector<Real>& v, int axis) {
    q[i] = projectedDeterminant(u, v, axis);
    sign[i] = q[i].sign();
  }
};

// Returns whether the projections certainly do not meet during the interval. Then the two parts do
// not meet either.
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

// Returns whether the parts certainly meet in the interval: D changes its sign, and where it is
// zero, the points lie in a plane that the projection does not flatten (abc is the sum of the other
// three, and p and q are on different sides of ab), in that order.
template <class Real>
DCM_HD inline bool isInside(FeatureKind kind, const FeaturePiece<Real>& piece) {
  const int* const s = piece.sign;
  const bool inside = kind == FeatureKind::kVertexFace ? s[1] != 0 && s[1] == s[2] && s[1] == s[3]
                      : kind == FeatureKind::kEdgeEdge
                          ? areOpposite(s[0], s[1]) && areOpposite(s[2], s[3])
                          : s[0] * s[1] > 0;
  return inside && areOpposite(piece.d.signAtStart(), piece.d.signAtEnd());
}

// Computes the orientations in the whole interval, or in what the piece's set() knows. Returns
// false if they show at once that the parts are apart.
template <class Piece>
DCM_HD inline bool setOrientations(const Feature& feature, Piece& piece) {
  using Real = typename Piece::Number;
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

// The errors that each halving adds to a feature's polynomials.
template <class Real>
struct ErrorsOfHalving {
  Real d, q[4];

  ErrorsOfHalving() = default;
  DCM_HD explicit ErrorsOfHalving(const FeaturePiece<Real>& piece) : d(piece.d.errorOfHalving()) {
    for (int i = 0; i < 4; ++i) q[i] = piece.q[i].errorOfHalving();
  }
};

// Computes the orientations in both halves; those with a certain sign keep it. `piece` becomes its
// left half.
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

// Halves all polynomials of a piece, which becomes its left half.
template <class Real>
DCM_HD inline void halve(const ErrorsOfHalving<Real>& errors, FeaturePiece<Real>& piece,
                         FeaturePiece<Real>& right) {
  piece.d.halve(errors.d, piece.d, right.d);
  halveOrientations(errors, piece, right);
}

// Returns whether a cubic certainly has one root in its interval, and not at an end of it: its
// Bernstein coefficients change their signs once.
template <class Real>
DCM_HD inline bool hasOneRoot(const Cubic<Real>& d) {
  const int first = d.signAtStart(), last = d.signAtEnd();
  return areOpposite(first, last) &&
         (certainSign(d.c[1], d.error) == first || certainSign(d.c[2], d.error) == last);
}

// Returns about where that root is, in parts of the interval: by halving, then by Newton's method.
template <class Real>
DCM_HD inline Real rootOf(const Cubic<Real>& d) {
  constexpr int kHalvings = 4, kSteps = 3;
  const Real a = 3 * (d.c[1] - d.c[0]), next = 3 * (d.c[2] - d.c[1]), b = next - a;
  const Real e = d.c[3] - d.c[0] - next;
  const auto valueAt = [&](Real x) { return d.c[0] + x * (a + x * (b + x * e)); };
  Real low = 0, size = 1;
  for (int i = 0; i < kHalvings; ++i) {
    size *= Real(0.5);
    if ((valueAt(low + size) > 0) == (d.c[0] > 0)) low += size;
  }
  Real x = low + size * Real(0.5);
  for (int i = 0; i < kSteps; ++i) {
    x -= valueAt(x) / (a + x * (2 * b + x * 3 * e));
    x = least(most(x, low), low + size);
  }
  return x;
}

// One of the 2^level equal parts of [0, 1], and which right halves on the way to it wait.
struct HalvedInterval {
  int level = 0;
  std::uint32_t path = 0;     // its number among those parts
  std::uint32_t waiting = 0;  // bit k: the right half, k levels up, waits

  DCM_HD float width() const { return 1.0F / static_cast<float>(1U << level); }
  DCM_HD float low() const { return static_cast<float>(path) * width(); }
  DCM_HD bool rightWaits() const { return (waiting & 1) != 0; }
  DCM_HD void enterLeft(bool right_waits) {
    ++level;
    path <<= 1;
    waiting = waiting << 1 | (right_waits ? 1U : 0U);
  }
  // Moves to the earliest half that waits. Returns false if none does.
  DCM_HD bool goBack() {
    if (waiting == 0) return false;
    for (; !rightWaits(); waiting >>= 1, path >>= 1) --level;
    path |= 1;
    waiting &= ~1U;
    return true;
  }
};

// How short an interval around a root is in which signs are mostly certain, in halvings.
template <class Real>
constexpr int kRootHalvings = kTimeHalvings;
template <>
inline constexpr int kRootHalvings<float> = 8;

// Finds the short interval around the only root of a cubic: the part number `first` of 2^halvings
// equal parts. `d` becomes the cubic in it. Returns false if the root is not certainly there.
// `more` is errorOfHalving() of the cubic in the whole interval of time.
template <class Real>
DCM_HD inline bool narrowToRoot(int halvings, Real more, Cubic<Real>& d, std::uint32_t& first) {
  const auto parts = static_cast<Real>(1 << halvings);
  const Real place = rootOf(d) * parts;
  if (!(place >= 0 && place < parts)) return false;
  first = static_cast<std::uint32_t>(place);
  const Real from = static_cast<Real>(first);
  d.restrict(from / parts, (from + 1) / parts, more, d);
  return areOpposite(d.signAtStart(), d.signAtEnd());
}

// Returns the verdict on a feature that can only meet in `piece`, which begins at `low`.
template <class Real>
DCM_HD inline FeatureVerdict verdictIn(FeatureKind kind, const FeaturePiece<Real>& piece,
                                       float low) {
  if (isApart(kind, piece)) return {};
  if (!isInside(kind, piece)) return {PartVerdict::kOpen, 0, 1};
  return {PartVerdict::kMeet, low, low + 1.0F / (1 << kRootHalvings<Real>)};
}

// Decides a feature in an interval in which its coplanarity has one root. It only meets there, so
// that its signs in a short interval with the root decide, if they are certain.
template <class Real>
DCM_HD inline FeatureVerdict verdictAtRoot(FeatureKind kind, const FeaturePiece<Real>& piece,
                                           const ErrorsOfHalving<Real>& errors,
                                           const HalvedInterval& interval) {
  const FeatureVerdict open{PartVerdict::kOpen, interval.low(), 1};
  const int halvings = kRootHalvings<Real> - interval.level;
  FeaturePiece<Real> part;
  part.d = piece.d;
  std::uint32_t first = 0;
  if (halvings <= 0 || !narrowToRoot(halvings, errors.d, part.d, first)) return open;
  const auto parts = static_cast<Real>(1 << halvings), from = static_cast<Real>(first);
  for (int i = 0; i < 4; ++i) {
    part.sign[i] = piece.sign[i];
    if (part.sign[i] != 0) continue;
    piece.q[i].restrict(from / parts, (from + 1) / parts, errors.q[i], part.q[i]);
    part.sign[i] = part.q[i].sign();
  }
  constexpr float kWidth = 1.0F / (1 << kRootHalvings<Real>);
  FeatureVerdict verdict =
      verdictIn(kind, part, interval.low() + static_cast<float>(first) * kWidth);
  if (verdict.part == PartVerdict::kOpen) verdict.low = interval.low();
  return verdict;
}

// Returns whether the boxes of the two parts of a feature are certainly apart during the interval.
template <class Real>
DCM_HD DCM_RARE inline bool areApartIn(const Feature& feature, const HalvedInterval& interval) {
  const int count = feature.kind == FeatureKind::kVertexFace ? 3 : 2;
  bool apart = false;
  DCM_ROLLED for (int axis = 0; axis < 3 && !apart; ++axis) {
    int above = 0, below = 0, all = 0;
    DCM_ROLLED for (int i = 0; i < count; ++i) {
      DCM_ROLLED for (int j = count; j < 4; ++j) {
        const MovingPoint &p = feature.x[i], &q = feature.x[j];
        const Real from = static_cast<Real>(q.from[axis]) - static_cast<Real>(p.from[axis]);
        const Real to = static_cast<Real>(q.to[axis]) - static_cast<Real>(p.to[axis]);
        const Real error =
            4 * Rounding<Real>::kUnit * (sizeOf(from) + sizeOf(to)) + Rounding<Real>::kProduct;
        for (int end = 0; end < 2; ++end) {
          const Real t =
              static_cast<Real>(interval.low() + static_cast<float>(end) * interval.width());
          const int side = certainSign(from * (1 - t) + to * t, error);
          above += side > 0;
          below += side < 0;
          ++all;
        }
      }
    }
    apart = above == all || below == all;
  }
  return apart;
}

// Computes a feature in an interval from that in the whole one, in which its coplanarity is `d`.
template <class Real>
DCM_HD inline void setPiece(const Feature& feature, const Cubic<Real>& d,
                            const HalvedInterval& interval, FeaturePiece<Real>& piece) {
  piece.d = d;
  setOrientations(feature, piece);
  const ErrorsOfHalving<Real> errors(piece);
  for (int k = interval.level - 1; k >= 0; --k) {
    FeaturePiece<Real> right;
    halve(errors, piece, right);
    if ((interval.path >> k & 1) != 0) piece = right;
  }
}

}  // namespace detail

// Decides a feature with coplanarity `d`, whose sign is not certain, in [0, until]. Without
// `wants_time`, `high` is only some time by which it has met. Right halves that wait are kept as
// bits, and computed again from the whole interval when they are due: their polynomials would take
// 5 KB of each thread's stack. With kShortcuts, it looks at the only root of a cubic at once, and
// tests boxes if the points always lie in one plane.
template <class Real, bool kShortcuts = true>
DCM_HD DCM_RARE inline FeatureVerdict halvedVerdict(const Feature& feature, const Cubic<Real>& d,
                                                    bool wants_time, float until) {
  const float narrow = wants_time ? 1.0F / (1 << kTimeHalvings) : 1.0F;
  detail::FeaturePiece<Real> piece;
  piece.d = d;
  if (!detail::setOrientations(feature, piece)) return {};
  const detail::ErrorsOfHalving<Real> errors(piece);
  detail::HalvedInterval interval;
  const bool flat = kShortcuts && d.isLost() && feature.kind != FeatureKind::kFold;
  bool tries_root = kShortcuts;
  for (int pieces = 0;; ++pieces) {
    const float low = interval.low(), width = interval.width();
    if (low > until) return {};
    bool apart = detail::isApart(feature.kind, piece) ||
                 (flat && detail::areApartIn<Real>(feature, interval));
    if (!apart && width <= narrow && detail::isInside(feature.kind, piece)) {
      return {PartVerdict::kMeet, low, low + width};
    }
    if (!apart && tries_root && detail::hasOneRoot(piece.d)) {
      const FeatureVerdict at_root = detail::verdictAtRoot(feature.kind, piece, errors, interval);
      if (at_root.part == PartVerdict::kMeet)
        return at_root.low > until ? FeatureVerdict{} : at_root;
      apart = tries_root = at_root.part == PartVerdict::kApart;
    }
    if (!apart) {
      if (interval.level == kMostHalvings || pieces == kMostPieces) {
        return {PartVerdict::kOpen, low, 1};
      }
      detail::FeaturePiece<Real> right;
      detail::halve(errors, piece, right);
      interval.enterLeft(right.d.sign() == 0);
      if (piece.d.sign() == 0) {
        if (!detail::isApart(feature.kind, piece)) continue;
        ++pieces;  // the left half is done
      }
      if (interval.rightWaits()) {
        interval.goBack();
        piece = right;
        continue;
      }
    }
    if (!interval.goBack()) return {};
    detail::setPiece(feature, d, interval, piece);
  }
}

}  // namespace deformable_contact_monitor
