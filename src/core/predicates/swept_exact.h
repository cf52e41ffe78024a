// What filters and halving leave open about two moving triangles, decided exactly for every finite
// float32 input; and the whole verdict on a pair. Host only; thread-compatible, allocates memory.
#pragma once

#include "core/export.h"
#include "core/predicates/swept_adjacency.h"
#include "core/predicates/swept_intersection.h"

namespace deformable_contact_monitor {

// When something happens first: not before `low`, and somewhere in [low, high], at most 2^-20
// apart. 2: never.
struct FirstTime {
  float low = 2, high = 2;

  bool happens() const { return high <= 1; }
};

// When a vertex and a face or two edges meet, of triangles that do not meet at t = 0. Where the
// four points always lie in one plane that is when a vertex comes to an edge: without a contact
// before, such triangles cannot meet otherwise first. Without `wants_time`, any time at which they
// meet.
FirstTime exactFeatureTime(const Feature& feature, bool wants_time);

// When two triangles that share vertices meet beyond the hull of the shared points, or the infimum
// of these times.
FirstTime exactTimeBeyondShared(const MovingTriangle& a, const MovingTriangle& b,
                                const SharedVertices& shared);

// Decides what `quick`, of kPart kOpen, has left open; counts in `state`.
DCM_EXPORT SweptVerdict decideOpen(const MovingTriangle& a, const MovingTriangle& b,
                                   const SharedVertices& shared, bool wants_time,
                                   const SweptVerdict& quick, PredicateState& state);

// The verdict on two triangles with finite vertices; `shared` as sharedTrajectories tells, for
// triangles of one body, else none. Times are told to 2^-20 in exact mode.
template <unsigned kFilters = kAllSweptFilters>
SweptVerdict sweptVerdict(const MovingTriangle& a, const MovingTriangle& b,
                          const SharedVertices& shared, AdjacentPairs adjacent, bool wants_time,
                          PredicateState& state) {
  if (shared.any && adjacent == AdjacentPairs::kSkip) return {};
  SweptVerdict verdict;
  const bool fast = state.mode == Predicates::kFast;
  if (shared.any) {
    verdict = fast ? quickSweptBeyondShared<float, kFilters>(a, b, shared, wants_time, state)
                   : quickSweptBeyondShared<double, kFilters>(a, b, shared, wants_time, state);
  } else {
    verdict = fast ? quickSweptVerdict<float, kFilters>(a, b, wants_time, state)
                   : quickSweptVerdict<double, kFilters>(a, b, wants_time, state);
  }
  if (verdict.part != PartVerdict::kOpen) return verdict;
  return decideOpen(a, b, shared, wants_time, verdict, state);
}

}  // namespace deformable_contact_monitor
