// The verdict on one pair of triangles, by the rules that the backends compose.
#pragma once

#include "core/predicates/narrow_phase.h"

namespace deformable_contact_monitor {

// Two triangles as received (not posed otherwise). `same_body`: vertices with equal coordinates are
// shared.
DCM_HD inline Verdict pairVerdict(const Triangle& a, const Triangle& b, bool same_body,
                                  AdjacentPairs adjacent, float margin_m, PredicateState& state) {
  PairFacts facts;
  if (same_body) facts.shared = sharedVertices(a, b);
  facts.margin_m = margin_m;
  if (facts.shared.any && adjacent == AdjacentPairs::kSkip) return {};
  return isCandidate(a, b, facts) ? candidateVerdict(a, b, facts, state) : Verdict{};
}

}  // namespace deformable_contact_monitor
