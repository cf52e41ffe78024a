#include "core/cpu/judge.h"

#include <algorithm>

namespace deformable_contact_monitor {

void judgeCandidates(const CycleInput<Triangle>& input,
                     const std::vector<Candidate<Triangle>>& candidates,
                     CycleOutput<Triangle>& output) {
  constexpr std::uint64_t kLook = 64;
  PacedLimit pace(input.limit, kLook);
  for (const Candidate<Triangle>& candidate : candidates) {
    if (pace.over()) return;
    ++output.candidates;
    PredicateState state{input.options.predicates};
    const Verdict verdict = candidateVerdict(input.set.posed(candidate.a),
                                             input.set.posed(candidate.b), candidate.facts, state);
    output.exact += state.exact > 0;
    if (!verdict.contact) continue;
    output.undecided += state.undecided;
    output.contacts.add({std::min(candidate.a, candidate.b), std::max(candidate.a, candidate.b),
                         verdict.separation_m});
  }
}

}  // namespace deformable_contact_monitor
