#include "core/cpu/swept_filter.h"

#include "core/rules/margins.h"

namespace deformable_contact_monitor {

PairScreen<MovingTriangle>::PairScreen(const CycleInput<MovingTriangle>& input,
                                       ScreenBuffers<MovingTriangle>& buffers)
    : input_(input),
      pads_(input.scene.anyPad()),
      lanes_(buffers.lanes),
      separate_(buffers.separate) {}

void PairScreen<MovingTriangle>::screen(
    const std::vector<PreparedTriangle<MovingTriangle>>& triangles, BoxPair* pairs,
    std::size_t count, Screened<MovingTriangle>& screened) {
  std::vector<Candidate<MovingTriangle>>& candidates = screened.candidates;
  // In other modes what is open counts, so that all must be asked alike.
  const bool exact = input_.options.predicates == Predicates::kExact;
  separate_.clear();
  for (std::size_t i = 0; i < count; ++i) {
    const BoxPair pair = pairs[i];
    const PreparedTriangle<MovingTriangle>&a = triangles[pair.a.value],
          &b = triangles[pair.b.value];
    if (!exact || padOf(a, b) > 0 || sharedBits(a.vertex_id, b.vertex_id) != 0) {
      screen(a, b, candidates);
    } else {
      pairs[separate_.size()] = pair;
      separate_.push_back({&a.posed, &b.posed});
    }
  }
  lanes_.screen(separate_, input_.options.first_times);
  const auto add = [&](std::uint32_t i, bool meet) {
    candidates.push_back({triangles[pairs[i].a.value].triangle,
                          triangles[pairs[i].b.value].triangle, SharedVertices(), meet});
  };
  for (const std::uint32_t i : lanes_.meeting()) add(i, true);
  for (const std::uint32_t i : lanes_.open()) add(i, false);
}

float PairScreen<MovingTriangle>::padOf(const PreparedTriangle<MovingTriangle>& a,
                                        const PreparedTriangle<MovingTriangle>& b) const {
  if (!pads_) return 0;
  return pairPad(input_.scene.body(a.body.value).pad_m, input_.scene.body(b.body.value).pad_m);
}

void PairScreen<MovingTriangle>::screen(const PreparedTriangle<MovingTriangle>& a,
                                        const PreparedTriangle<MovingTriangle>& b,
                                        std::vector<Candidate<MovingTriangle>>& candidates) const {
  const int in_a = sharedBits(a.vertex_id, b.vertex_id);
  SharedVertices shared;
  if (in_a != 0) {
    if (input_.options.adjacent == AdjacentPairs::kSkip) return;
    const int in_b = sharedBits(b.vertex_id, a.vertex_id);
    shared = sharedByBits(static_cast<std::uint32_t>(in_a), static_cast<std::uint32_t>(in_b));
  }
  candidates.push_back({a.triangle, b.triangle, shared, false});
}

}  // namespace deformable_contact_monitor
