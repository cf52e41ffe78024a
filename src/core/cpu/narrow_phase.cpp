// Stage `narrow_phase`: decides each candidate, at one moment or during a time interval. Pairs that
// the float32 filters have decided are only counted and copied.
#include <algorithm>
#include <cstdint>
#include <utility>

#include "core/cpu/pair_stages.h"
#include "core/predicates/swept_exact.h"
#include "core/predicates/swept_pad.h"
#include "core/rules/margins.h"

namespace deformable_contact_monitor {

void narrowPhase(const CycleInput<Triangle>& input, const FilteredPairs<Triangle>& filtered,
                 CycleOutput<Triangle>& output) {
  constexpr std::uint64_t kPollPeriod = 64;
  for (const auto& [a, b] : filtered.meeting) {
    output.contacts.add({std::min(a, b), std::max(a, b), 0});
  }
  output.counters.candidates += filtered.apart + filtered.meeting.size();
  PacedLimit pace(input.limit, kPollPeriod);
  for (const Candidate<Triangle>& candidate : filtered.candidates) {
    if (pace.over()) return;
    ++output.counters.candidates;
    PredicateState state{input.options.predicates};
    const Verdict verdict = candidateVerdict(input.set.posed(candidate.a),
                                             input.set.posed(candidate.b), candidate.facts, state);
    output.counters.exact += state.exact > 0;
    if (!verdict.contact) continue;
    output.counters.undecided += state.undecided;
    output.contacts.add({std::min(candidate.a, candidate.b), std::max(candidate.a, candidate.b),
                         verdict.separation_m});
  }
}

namespace {

// Returns the motion bound of a pair of bodies [m].
float padOf(const CycleInput<MovingTriangle>& input, const Candidate<MovingTriangle>& candidate) {
  return pairPad(input.scene.body(input.set.bodyOf(candidate.a).value).pad_m,
                 input.scene.body(input.set.bodyOf(candidate.b).value).pad_m);
}

// Orders the two triangles of a candidate. First times may depend on the order in the last digits;
// with this order they do not depend on the clusters.
Candidate<MovingTriangle> inOrder(Candidate<MovingTriangle> candidate) {
  if (candidate.b < candidate.a) {
    std::swap(candidate.a, candidate.b);
    std::swap(candidate.shared.in_a, candidate.shared.in_b);
  }
  return candidate;
}

}  // namespace

void narrowPhase(const CycleInput<MovingTriangle>& input,
                 const FilteredPairs<MovingTriangle>& filtered,
                 CycleOutput<MovingTriangle>& output) {
  constexpr std::uint64_t kPollPeriod = 16;
  const Options& options = input.options;
  PacedLimit pace(input.limit, kPollPeriod);
  for (const Candidate<MovingTriangle>& any_order : filtered.candidates) {
    if (pace.over()) return;
    ++output.counters.candidates;
    const Candidate<MovingTriangle> candidate = inOrder(any_order);
    if (candidate.meet) {
      const float first_high = options.first_times ? 0.0F : 1.0F;
      output.contacts.add({candidate.a, candidate.b, {0, first_high}, false});
      continue;
    }
    const MovingTriangle a = input.set.posed<MovingTriangle>(candidate.a);
    const MovingTriangle b = input.set.posed<MovingTriangle>(candidate.b);
    PredicateState state{options.predicates};
    const SweptVerdict verdict =
        sweptVerdict(a, b, candidate.shared, options.adjacent, options.first_times, state);
    output.counters.exact += state.exact > 0;
    if (verdict.part == PartVerdict::kMeet) {
      output.counters.undecided += state.undecided;
      output.contacts.add(
          {candidate.a, candidate.b, {verdict.first_low, verdict.first_high}, false});
      continue;
    }
    const float pad_m = candidate.shared.any ? 0 : padOf(input, candidate);
    if (pad_m == 0) continue;
    const PadVerdict pad = withinPad(a, b, pad_m);
    if (!pad.may_touch) continue;
    output.contacts.add({candidate.a, candidate.b, {pad.first_low, 1}, true});
  }
}

}  // namespace deformable_contact_monitor
