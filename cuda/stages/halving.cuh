// Runs halvedVerdict (core/predicates/swept_feature.h) step by step: it halves the time interval of
// a feature until a sign is certain. Each lane of a warp can begin another feature as soon as one
// is done. The last intervals that wait are kept in the thread's memory, and all of them as bits.
// When an interval is due that is not kept, it is computed again from the whole interval, while the
// other lanes of the warp wait.
#pragma once

#include "core/predicates/swept_feature.h"

namespace deformable_contact_monitor {

// The outcome of a step.
enum class HalvingStep {
  kGoesOn,
  kGoesBack,  // to an interval that is not kept; the caller must call goBack()
  kApart,     // no interval is left: the feature does not meet
  kMeets,     // the feature meets in the current interval
  kOpen,      // the current interval cannot be decided
};

// The state of one lane: its feature, the current interval and the intervals that wait.
template <class Real>
class Halving {
 public:
  // The last intervals that wait. Not a member, for arrays that are indexed lie in memory.
  struct Kept {
    static constexpr int kMost = 2;
    detail::FeaturePiece<Real> pieces[kMost];
    int count;

    __device__ void add(const detail::FeaturePiece<Real>& piece) {
      if (count == kMost) pieces[0] = pieces[--count];
      pieces[count++] = piece;
    }
  };

  // Begins a feature with coplanarity `d`, whose sign must not be certain. Returns false if the
  // feature never meets.
  __device__ bool begin(const Feature& feature, const Cubic<Real>& d, Kept& kept) {
    kept.count = 0;
    kind_ = feature.kind;
    piece_.d = d;
    level_ = pieces_ = 0;
    path_ = waiting_ = 0;
    return detail::setOrientations(feature, piece_);
  }

  // Examines the current interval. `narrow`: a meeting interval of at most this width is a result.
  // `until`: intervals that begin later are of no use. `most`: the most intervals to examine.
  __device__ HalvingStep step(float narrow, float until, int most,
                              const detail::ErrorsOfHalving<Real>& errors, Kept& kept) {
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
      if (keeps_right) {
        waiting_ |= 1U;
        kept.add(right);
      }
      return HalvingStep::kGoesOn;
    }
    if (keeps_right) {
      piece_ = right;
      path_ |= 1;
      return HalvingStep::kGoesOn;
    }
    if (waiting_ == 0) return HalvingStep::kApart;
    const int back =
        __ffs(static_cast<int>(waiting_)) - 1;  // levels up to the last interval that waits
    level_ -= back;
    path_ = path_ >> back | 1;
    waiting_ = waiting_ >> back & ~1U;
    if (kept.count == 0) return HalvingStep::kGoesBack;
    piece_ = kept.pieces[--kept.count];
    return HalvingStep::kGoesOn;
  }

  // Computes the current interval again from the whole interval, after step() returned kGoesBack.
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
  // Replaces the piece by its left half, and sets `right` to the right one.
  __device__ void halve(const detail::ErrorsOfHalving<Real>& errors,
                        detail::FeaturePiece<Real>& right) {
    piece_.d.halve(errors.d, piece_.d, right.d);
    detail::halveOrientations(errors, piece_, right);
  }

  FeatureKind kind_;
  detail::FeaturePiece<Real> piece_;
  int level_, pieces_;
  std::uint32_t path_;     // the number of the current interval among those of its width
  std::uint32_t waiting_;  // bit k: the right half, k levels up, waits
};

}  // namespace deformable_contact_monitor
