// Decides whether two moving triangles meet at some time in [0, 1], and when first.
//
// Filters, the static predicate at both ends, and halving decide in float or double, on both
// backends. What they leave open is decided exactly on the host (swept_exact.h).
#pragma once

#include "core/predicates/narrow_phase.h"
#include "core/predicates/swept_filters.h"
#include "core/predicates/swept_integers.h"

namespace deformable_contact_monitor {

// The filters as bits. They change no exact verdict; tests leave out one at a time.
enum SweptFilters : unsigned {
  kMovingBoxes = 1,      // of triangles
  kMovingPlanes = 2,     // of triangles
  kFixedDirections = 4,  // of pairs
  kFeatureBoxes = 8,     // of features
  kHalving = 16,         // of features' time intervals, and the sign of their cubics
  kIntegerSigns = 32,    // of features' cubics
  kTies = 64,            // of features
  kShortcuts = 128,      // of halving
  kAllSweptFilters = 255,
};

// The decision on a pair.
//
// kMeet: there is certainly no contact in [0, first_low), and certainly one in [first_low,
// first_high]; both are 0 for a contact at the start. Unless times are wanted, only the contact
// itself is certain. kOpen: `open` has a bit for each feature of featureOf() that is not decided,
// or kWholePair. The times are those of the features that are decided; first_high is 2 if none of
// these meets.
//
// In conservative mode no pair is open: if floating point cannot decide, the pair counts as
// contact, state.undecided is set, and a contact in [first_low, first_high] is not certain.
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

// Collects the decisions on features.
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

// Returns the verdict of discrete detection on one state.
DCM_HD DCM_RARE inline bool meetInState(const Triangle& a, const Triangle& b,
                                        const SharedVertices& shared, PredicateState& state) {
  PairFacts facts;
  facts.shared = shared;
  return isCandidate(a, b, facts) && candidateVerdict(a, b, facts, state).contact;
}

// Returns a contact at the start; if it is undecided, there may be none.
DCM_HD inline SweptVerdict meetsAtStart(const PredicateState& state) {
  return meetsAt(0, state.undecided ? 1.0F : 0.0F);
}

// Decides by integers a feature that double leaves open from `low` on, in a pair that does not meet
// at t = 0. `shared`: the vertex that two triangles share, if they do; then only meetings beyond it
// count, and a feature may not be dropped if its points lie in one plane at t = 0 or t = 1.
template <unsigned kFilters>
DCM_HD inline FeatureVerdict integerVerdict(const Feature& feature, const MovingPoint* shared,
                                            float low, bool wants_time) {
  auto signs = IntegerSigns::kUnknown;
  if ((kFilters & kIntegerSigns) != 0) signs = integerSigns(feature);
  if (signs == IntegerSigns::kNoRootWithin && shared == nullptr) return {};
  if ((kFilters & kTies) == 0) return {PartVerdict::kOpen, low, 1};
  return tieVerdict(feature, shared, low, wants_time, signs == IntegerSigns::kOneRoot);
}

// Decides a feature as far as the filters can. `shared` is that of integerVerdict().
template <class Real, unsigned kFilters>
DCM_HD inline FeatureVerdict featureVerdict(const Feature& feature, const Cubic<Real>& d,
                                            const MovingPoint* shared, bool wants_time, float until,
                                            Predicates mode) {
  FeatureVerdict verdict{PartVerdict::kOpen, 0, 1};
  if ((kFilters & kHalving) != 0) {
    verdict = halvedVerdict<Real, (kFilters & kShortcuts) != 0>(feature, d, wants_time, until);
  }
  if (verdict.part != PartVerdict::kOpen || mode != Predicates::kExact) return verdict;
  return integerVerdict<kFilters>(feature, shared, verdict.low, wants_time);
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
    first.add(
        featureVerdict<Real, kFilters>(feature, d, nullptr, wants_time, first.high, state.mode),
        1U << i);
    if (!wants_time && first.high <= 1) return meetsAt(first.low, first.high);
  }
  return first.verdict(meets_at_end, state);
}

// Decides two triangles that share no vertex, filter by filter.
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
  const PartVerdict quick_start = quickIntersection(a.from, b.from, start);
  if (quick_start == PartVerdict::kMeet) return meetsAt(0, 0);
  const PartVerdict quick_end = quickIntersection(a.to, b.to, end);
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

// Decides two triangles with finite vertices that share none. If they do not move, it returns the
// static verdict. Real is double; in tests also float, of which devices use the parts. Times are
// right to 2^-20.
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
