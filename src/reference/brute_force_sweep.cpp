#include "reference/brute_force_sweep.h"

#include "core/common/posed_body.h"
#include "core/predicates/swept_exact.h"
#include "core/predicates/swept_pad.h"

namespace deformable_contact_monitor {

std::vector<MovingBodyTriangle> movingTriangles(const Body& body, const CycleLimit& limit) {
  const PosedBody from = PosedBody::earlier(body), to(body);
  const auto count = static_cast<std::uint32_t>(body.mesh.triangleCount());
  std::vector<MovingBodyTriangle> triangles;
  PacedLimit pace(limit, 1 << 14);
  for (std::uint32_t t = 0; t < count && !pace.over(); ++t) {
    const MovingTriangle moving{from.triangle(t), to.triangle(t)};
    if (isFinite(moving)) triangles.push_back({t, {from.received(t), to.received(t)}, moving});
  }
  return triangles;
}

std::optional<SweptContact> sweptContactOf(const MovingBodyTriangle& a, const MovingBodyTriangle& b,
                                           bool same_body, float pad_m, const Options& options,
                                           Counters& counters) {
  SharedVertices shared;
  if (same_body) shared = sharedTrajectories(a.received, b.received);
  if (shared.any && options.adjacent == AdjacentPairs::kSkip) return std::nullopt;
  PredicateState state{options.predicates};
  const SweptVerdict verdict =
      sweptVerdict(a.moving, b.moving, shared, options.adjacent, options.first_times, state);
  ++counters.candidates;
  counters.exact += state.exact > 0;
  if (verdict.part == PartVerdict::kMeet) {
    counters.undecided += state.undecided;
    return SweptContact{{verdict.first_low, verdict.first_high}, false};
  }
  if (pad_m == 0 || shared.any) return std::nullopt;
  const PadVerdict pad = withinPad(a.moving, b.moving, pad_m);
  if (!pad.may_touch) return std::nullopt;
  return SweptContact{{pad.first_low, 1}, true};
}

}  // namespace deformable_contact_monitor
