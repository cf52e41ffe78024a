// Do two moving triangles meet at some time of the step, and when first? What filters, the static
// predicate at both ends and halving tell, in float or double, on both backends; what they leave
// open is decided exactly on the host (swept_exact.h).
#pragma once

#include "core/predicates/narrow_phase.h"
#include "core/predicates/swept_feature.h"
#include "core/predicates/swept_filters.h"
#include "core/predicates/swept_integer_signs.h"

namespace deformable_contact_monitor {

// Filters change no exact verdict; tests leave out one at a time.
enum SweptFilters : unsigned {
  kMovingBoxes = 1,      // of triangles
  kMovingPlanes = 2,     // of triangles
  kFixedDirections = 4,  // of pairs
  kFeatureBoxes = 8,     // of features
  kHalving = 16,         // of features' intervals, and the sign of their cubics
  kIntegerSigns = 32,    // of features' cubics
  kAllSweptFilters = 63,
};

// kMeet: certainly no contact in [0, first_low), certainly one in [first_low, first_high]; both are
// 0 if they meet at the start, and unless times are wanted they only hold for that. kOpen: what is
// certain of the features that are not in `open`, which has a bit for each of featureOf's, or
// kWholePair: first_high is 2 if none of them meets.
//
// In conservative and in fast mode nothing is open: what double (fast: float) arithmetic cannot
// decide counts as contact, state.undecided is set, and the contact in [first_low, first_high] is
// not certain.
struct SweptVerdict {
  PartVerdict part = PartVerdict::kApart;
  float first_low = 0, first_high = 0;
  std::uint32_t open = 0;
  bool meets_at_end = false;  // at t = 1
};

constexpr std::uint32_t kWholePair = 1U << 31;

namespace detail {

DCM_HD inline SweptVerdict meetsAt(float low, float high) {
  return {PartVerdict::kMeet, low, high, 0, false};
}

// Collects what features tell.
struct FirstMeeting {
  float low = 2, high = 2, open_low = 2;
  std::uint32_t open = 0;

  DCM_HD void add(const FeatureVerdict& verdict, std::uint32_t bits) {
    if (verdict.part == PartVerdict::kMeet) {
      low = least(low, verdict.low);
      high = least(high, verdict.high);
    } else if (verdict.part == PartVerdict::kOpen) {
      open_low = least(open_low, verdict.low);
      open |= bits;
    }
  }

  DCM_HD SweptVerdict verdict(bool meets_at_end, PredicateState& state) const {
    SweptVerdict result = meetsAt(low, high);
    result.meets_at_end = meets_at_end;
    if (open != 0 && state.mode == Predicates::kExact) {
      result.part = PartVerdict::kOpen;
      result.open = open;
    } else if (open != 0) {
      state.undecided = true;
      result.first_low = least(low, open_low);
      result.first_high = least(high, 1.0F);
    } else if (high > 1) {  // no feature
      if (!meets_at_end) return {};
      result.first_low = state.undecided ? 0.0F : 1.0F;
      result.first_high = 1;
    }
    return result;
  }
};

// The static verdict: that of pairs that do not move.
DCM_HD inline bool meetInState(const Triangle& a, const Triangle& b, const SharedVertices& shared,
                               PredicateState& state) {
  PairFacts facts;
  facts.shared = shared;
  return isCandidate(a, b, facts) && candidateVerdict(a, b, facts, state).contact;
}

// A contact at the start; one that is undecided may be none.
DCM_HD inline SweptVerdict meetsAtStart(const PredicateState& state) {
  return meetsAt(0, state.undecided ? 1.0F : 0.0F);
}

// A feature of a pair that does not meet at t = 0. `at_ends`: whether it may be left out if its
// points lie in one plane at t = 0 or at t = 1 alone.
template <class Real, unsigned kFilters>
DCM_HD inline FeatureVerdict featureVerdict(const Feature& feature, const Cubic<Real>& d,
                                            bool at_ends, bool wants_time, float until,
                                            Predicates mode) {
  FeatureVerdict verdict{PartVerdict::kOpen, 0, 1};
  if ((kFilters & kHalving) != 0) verdict = halvedVerdict(feature, d, wants_time, until);
  if ((kFilters & kIntegerSigns) != 0 && verdict.part == PartVerdict::kOpen && at_ends &&
      mode == Predicates::kExact && integerSigns(feature) == IntegerSigns::kNoRootWithin) {
    return {};
  }
  return verdict;
}

template <class Real, unsigned kFilters>
DCM_HD inline SweptVerdict featuresVerdict(const MovingTriangle& a, const MovingTriangle& b,
                                           const MovingSides<Real>& sides_b,
                                           const MovingSides<Real>& sides_a, bool meets_at_end,
                                           bool wants_time, PredicateState& state) {
  FirstMeeting first;
  const FeatureBoxes boxes(a, b);
  for (int i = 0; i < kFeatures; ++i) {
    if ((kFilters & kFeatureBoxes) != 0 && boxes.areApart(i)) continue;
    const Feature feature = featureOf(a, b, i);
    const Cubic<Real> d = i < 3   ? sides_b.of[i]
                          : i < 6 ? sides_a.of[i - 3]
                                  : coplanarity<Real>(feature);
    if ((kFilters & kHalving) != 0 && d.sign() != 0) continue;
    first.add(featureVerdict<Real, kFilters>(feature, d, true, wants_time, first.high, state.mode),
              1U << i);
    if (!wants_time && first.high <= 1) return meetsAt(first.low, first.high);
  }
  return first.verdict(meets_at_end, state);
}

// Two triangles that share no vertex.
template <class Real, unsigned kFilters>
DCM_HD inline SweptVerdict disjointVerdict(const MovingTriangle& a, const MovingTriangle& b,
                                           bool wants_time, PredicateState& state) {
  if ((kFilters & kMovingBoxes) != 0 && areApart(boxOf(a), boxOf(b))) return {};
  const MovingSides<Real> sides_b(MovingPlane<Real>(a), b);
  if ((kFilters & kMovingPlanes) != 0 && sides_b.areApart()) return {};
  const MovingSides<Real> sides_a(MovingPlane<Real>(b), a);
  if ((kFilters & kMovingPlanes) != 0 && sides_a.areApart()) return {};
  KnownSides start, end;
  if ((kFilters & kMovingPlanes) != 0) {
    sides_a.atStart(start.a);
    sides_b.atStart(start.b);
    sides_a.atEnd(end.a);
    sides_b.atEnd(end.b);
  }
  const PartVerdict quick_start = quickIntersection(a.from, b.from, start, state.mode);
  if (quick_start == PartVerdict::kMeet) return meetsAt(0, 0);
  const PartVerdict quick_end = quickIntersection(a.to, b.to, end, state.mode);
  if ((kFilters & kFixedDirections) != 0 && quick_end != PartVerdict::kMeet &&
      FixedDirections<Real>(a, b).areApart()) {
    return {};
  }
  if (quick_start == PartVerdict::kOpen && robustIntersection(a.from, b.from, start, state)) {
    return meetsAtStart(state);
  }
  const bool meets_at_end =
      quick_end == PartVerdict::kMeet ||
      (quick_end == PartVerdict::kOpen && robustIntersection(a.to, b.to, end, state));
  if (meets_at_end && !wants_time) return meetsAt(0, 1);
  return featuresVerdict<Real, kFilters>(a, b, sides_b, sides_a, meets_at_end, wants_time, state);
}

}  // namespace detail

// Of two triangles with finite vertices, neither of whose vertices is shared: without motion the
// static verdict. Real: double; or float, on devices where double is slow, and in fast mode. Times
// are told to 2^-20.
template <class Real, unsigned kFilters = kAllSweptFilters>
DCM_HD inline SweptVerdict quickSweptVerdict(const MovingTriangle& a, const MovingTriangle& b,
                                             bool wants_time, PredicateState& state) {
  if (isStill(a) && isStill(b)) {
    const bool meet = detail::meetInState(a.from, b.from, {}, state);
    return meet ? detail::meetsAtStart(state) : SweptVerdict{};
  }
  return detail::disjointVerdict<Real, kFilters>(a, b, wants_time, state);
}

}  // namespace deformable_contact_monitor
