// Decides features of moving triangles by the only root of their coplanarity, as verdictAtRoot() of
// swept_feature.h does, but from the feature itself. It computes one orientation after the other,
// only around the root, so that it needs few registers.
#pragma once

#include "core/predicates/swept_feature.h"

namespace deformable_contact_monitor {
namespace detail {

// A feature in [from, to], of which only the signs are kept.
template <class Real>
struct PieceOfSigns : FeaturePiece<Real> {
  Real from, to;

  DCM_HD void set(int i, const MovingVector<Real>& u, const MovingVector<Real>& v, int axis) {
    Quadratic<Real> q = projectedDeterminant(u, v, axis);
    q.restrict(from, to, q.errorOfHalving(), q);
    this->sign[i] = q.sign();
  }
};

// Decides a feature whose coplanarity in the whole interval of time is `d`, and which only matters
// in `interval`, by the only root of `d` there. It is open if there may be more roots, or if the
// signs around the root are not certain.
template <class Real>
DCM_HD inline FeatureVerdict verdictByRoot(const Feature& feature, const Cubic<Real>& d,
                                           const HalvedInterval& interval) {
  const FeatureVerdict open{PartVerdict::kOpen, interval.low(), 1};
  const Real more = d.errorOfHalving();
  PieceOfSigns<Real> piece;
  piece.d = d;
  if (interval.level > 0) {
    const Real low = interval.low();
    d.restrict(low, low + interval.width(), more, piece.d);
    if (piece.d.sign() != 0) return {};
  }
  if (!hasOneRoot(piece.d)) return open;
  const int halvings = kRootHalvings<Real> - interval.level;
  std::uint32_t first = 0;
  if (!narrowToRoot(halvings, more, piece.d, first)) return open;
  constexpr float kWidth = 1.0F / (1 << kRootHalvings<Real>);
  const float low = static_cast<float>(interval.path << halvings | first) * kWidth;
  piece.from = low;
  piece.to = low + kWidth;
  if (!setOrientations(feature, piece)) return {};
  return verdictIn(feature.kind, piece, low);
}

}  // namespace detail
}  // namespace deformable_contact_monitor
