#include "core/cpu/narrow_phase.h"

#include <algorithm>

namespace deformable_contact_monitor {

void judgeCandidates(const CycleInput<Triangle>& input, const Screened<Triangle>& screened,
                     CycleOutput<Triangle>& output) {
  constexpr std::uint64_t kLook = 64;
  for (const auto& [a, b] : screened.meeting) {
    output.contacts.add({std::min(a, b), std::max(a, b), 0});
  }
  output.candidates += screened.apart + screened.meeting.size();
  PacedLimit pace(input.limit, kLook);
  for (const Candidate<Triangle>& candidate : screened.candidates) {
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
