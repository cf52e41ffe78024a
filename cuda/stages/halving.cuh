// halvedVerdict (core/predicates/swept_feature.h) as steps of a lane, so that a warp's lanes begin
// another feature wherever one is done. Intervals that wait are bits, not polynomials: where one
// has its turn it is made again from the whole step, which is rare, and no stack lies in memory.
#pragma once

#include "core/predicates/swept_feature.h"

namespace deformable_contact_monitor {

enum class HalvingStep {
  kGoesOn,
  kGoesBack,  // to an interval that has waited: goBack() is to be called
  kApart,     // there is none left
  kMeets,     // in the interval
  kOpen,      // the interval is
};

template <class Real>
class Halving {
 public:
  // Of a feature with coplanarity `d`, not of one sign; false if it never meets.
  __device__ bool begin(const Feature& feature, const Cubic<Real>& d) {
    kind_ = feature.kind;
    piece_.d = d;
    level_ = pieces_ = 0;
    path_ = waiting_ = 0;
    return detail::setOrientations(feature, piece_);
  }

  // Looks at the interval that has its turn. `narrow`: the width from which on one will do to meet
  // in; `until`: later ones are of no use; `most`: intervals that may be looked at.
  __device__ HalvingStep step(float narrow, float until, int most,
                              const detail::ErrorsOfHalving<Real>& errors) {
    if (low() > until) return HalvingStep::kApart;
    if (width() <= narrow && detail::isInside(kind_, piece_)) return HalvingStep::kMeets;
    if (level_ == kMostHalvings || pieces_ == most) return HalvingStep::kOpen;
    ++pieces_;
    detail::FeaturePiece<Real> right;
    halve(errors, right);
    const bool keeps_left = piece_.d.sign() == 0 && !detail::isApart(kind_, piece_);
    const bool keeps_right = right.d.sign() == 0 && !detail::isApart(kind_, right);
    ++level_;
    path_ <<= 1;
    waiting_ <<= 1;
    if (keeps_left) {
      waiting_ |= keeps_right ? 1U : 0U;
      return HalvingStep::kGoesOn;
    }
    if (keeps_right) {
      piece_ = right;
      path_ |= 1;
      return HalvingStep::kGoesOn;
    }
    if (waiting_ == 0) return HalvingStep::kApart;
    const int back = __ffs(static_cast<int>(waiting_)) - 1;  // to the last one that waits
    level_ -= back;
    path_ = path_ >> back | 1;
    waiting_ = waiting_ >> back & ~1U;
    return HalvingStep::kGoesBack;
  }

  // From the whole step, as begin() left it, to the interval that has its turn.
  __device__ void goBack(const Feature& feature, const Cubic<Real>& d) {
    piece_.d = d;
    detail::setOrientations(feature, piece_);
    const detail::ErrorsOfHalving<Real> errors(piece_);
    for (int k = level_ - 1; k >= 0; --k) {
      detail::FeaturePiece<Real> right;
      halve(errors, right);
      if ((path_ >> k & 1) != 0) piece_ = right;
    }
  }

  __device__ detail::ErrorsOfHalving<Real> errors() const {
    return detail::ErrorsOfHalving<Real>(piece_);
  }
  __device__ float width() const { return 1.0F / static_cast<float>(1U << level_); }
  __device__ float low() const { return static_cast<float>(path_) * width(); }

 private:
  // The piece becomes its left half.
  __device__ void halve(const detail::ErrorsOfHalving<Real>& errors,
                        detail::FeaturePiece<Real>& right) {
    piece_.d.halve(errors.d, piece_.d, right.d);
    detail::halveOrientations(errors, piece_, right);
  }

  FeatureKind kind_;
  detail::FeaturePiece<Real> piece_;
  int level_, pieces_;
  std::uint32_t path_;     // of the interval: its number among those of its width
  std::uint32_t waiting_;  // bit k: the right half of k levels up waits
};

}  // namespace deformable_contact_monitor
