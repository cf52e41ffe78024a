#include "core/cpu/swept_narrow_phase.h"

#include <cstdint>
#include <utility>

#include "core/predicates/swept_exact.h"
#include "core/predicates/swept_pad.h"
#include "core/rules/margins.h"

namespace deformable_contact_monitor {
namespace {

float padOf(const CycleInput<MovingTriangle>& input, const Candidate<MovingTriangle>& candidate) {
  return pairPad(input.scene.body(input.set.bodyOf(candidate.a).value).pad_m,
                 input.scene.body(input.set.bodyOf(candidate.b).value).pad_m);
}

// Times may depend on who comes first; so that they do not depend on clusters, the lesser triangle
// does.
Candidate<MovingTriangle> inOrder(Candidate<MovingTriangle> candidate) {
  if (candidate.b < candidate.a) {
    std::swap(candidate.a, candidate.b);
    std::swap(candidate.shared.in_a, candidate.shared.in_b);
  }
  return candidate;
}

}  // namespace

void judgeCandidates(const CycleInput<MovingTriangle>& input,
                     const Screened<MovingTriangle>& screened,
                     CycleOutput<MovingTriangle>& output) {
  constexpr std::uint64_t kLook = 16;
  const Options& options = input.options;
  PacedLimit pace(input.limit, kLook);
  for (const Candidate<MovingTriangle>& any_order : screened.candidates) {
    if (pace.over()) return;
    ++output.candidates;
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
    output.exact += state.exact > 0;
    if (verdict.part == PartVerdict::kMeet) {
      output.undecided += state.undecided;
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
