// Decides exactly, for all finite float32 input, what filters and halving leave open about two
// moving triangles; and combines all parts into the verdict on a pair. Host only. It allocates
// memory, and may be called by several threads at once.
#pragma once

#include "core/export.h"
#include "core/predicates/swept_adjacency.h"
#include "core/predicates/swept_intersection.h"

namespace deformable_contact_monitor {

// The first time at which something happens: not before `low`, and somewhere in [low, high], which
// are at most 2^-20 apart. Both are 2 if it never happens.
struct FirstTime {
  float low = 2, high = 2;

  bool happens() const { return high <= 1; }
};

// Returns when a vertex and a face, or two edges, of triangles that do not meet at t = 0 meet
// first. If the four points always lie in one plane, it returns when a vertex first comes to an
// edge: such triangles cannot meet for the first time in another way. Without `wants_time`, it
// returns any time at which they meet.
FirstTime exactFeatureTime(const Feature& feature, bool wants_time);

// Returns when two triangles that share vertices first meet beyond the hull of the shared points,
// or the infimum of these times.
FirstTime exactTimeBeyondShared(const MovingTriangle& a, const MovingTriangle& b,
                                const SharedVertices& shared);

// Decides what `quick`, whose part is kOpen, has left open. Counts in `state`.
DCM_EXPORT SweptVerdict decideOpen(const MovingTriangle& a, const MovingTriangle& b,
                                   const SharedVertices& shared, bool wants_time,
                                   const SweptVerdict& quick, PredicateState& state);

// Returns the verdict on two triangles with finite vertices. `shared` is what sharedTrajectories()
// says for triangles of one body, and empty for other pairs. In exact mode times are right to
// 2^-20.
template <unsigned kFilters = kAllSweptFilters>
SweptVerdict sweptVerdict(const MovingTriangle& a, const MovingTriangle& b,
                          const SharedVertices& shared, AdjacentPairs adjacent, bool wants_time,
                          PredicateState& state) {
  if (shared.any && adjacent == AdjacentPairs::kSkip) return {};
  const SweptVerdict verdict =
      shared.any ? quickSweptBeyondShared<double, kFilters>(a, b, shared, wants_time, state)
                 : quickSweptVerdict<double, kFilters>(a, b, wants_time, state);
  if (verdict.part != PartVerdict::kOpen) return verdict;
  return decideOpen(a, b, shared, wants_time, verdict, state);
}

}  // namespace deformable_contact_monitor
