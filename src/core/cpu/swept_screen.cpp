#include "core/cpu/swept_screen.h"

namespace deformable_contact_monitor {

void PairScreen<MovingTriangle>::screen(
    const std::vector<PreparedTriangle<MovingTriangle>>& triangles, BoxPair* pairs,
    std::size_t count, std::vector<Candidate<MovingTriangle>>& candidates) {
  for (std::size_t i = 0; i < count; ++i) {
    screen(triangles[pairs[i].a.value], triangles[pairs[i].b.value], candidates);
  }
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
  candidates.push_back({a.triangle, b.triangle, shared});
}

}  // namespace deformable_contact_monitor
