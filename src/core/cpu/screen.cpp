#include "core/cpu/screen.h"

#include "core/predicates/vertex_fan.h"
#include "core/rules/margins.h"

namespace deformable_contact_monitor {
namespace {

using Prepared = PreparedTriangle<Triangle>;

// Whether one of these vertices has a certified fan: then triangles that share it meet in what they
// share alone.
bool isCertified(const Prepared& a, int shared_bits) {
  static_assert(kFanCertified == std::uint32_t{1} << 31, "the sign");
  return (laneBits(a.vertex_id < 0) & shared_bits) != 0;
}

}  // namespace

PairScreen<Triangle>::PairScreen(const CycleInput<Triangle>& input)
    : input_(input), margins_(input.scene.anyMargin()) {}

void PairScreen<Triangle>::screen(const std::vector<Prepared>& triangles, BoxPair* pairs,
                                  std::size_t count, std::vector<Candidate<Triangle>>& candidates) {
  neighbours_.resize(count);
  std::size_t neighbours = 0, separate = 0, left = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const BoxPair pair = pairs[i];
    const Prepared &a = triangles[pair.a.value], &b = triangles[pair.b.value];
    const int shared_a = sharedBits(a.vertex_id, b.vertex_id);
    const bool share = shared_a != 0;
    neighbours_[neighbours] = pair;
    neighbours += share & !isCertified(a, shared_a);
    pairs[separate] = pair;
    separate += !share;
  }
  for (std::size_t i = 0; i < separate; ++i) {
    const BoxPair pair = pairs[i];
    const Prepared &a = triangles[pair.a.value], &b = triangles[pair.b.value];
    const bool apart = onOneSide(b.plane, a.lanes) | onOneSide(a.plane, b.lanes);
    pairs[left] = pair;
    left += !apart | margins_;
  }
  for (std::size_t i = 0; i < left; ++i) {
    screenSeparate(triangles[pairs[i].a.value], triangles[pairs[i].b.value], candidates);
  }
  for (std::size_t i = 0; i < neighbours; ++i) {
    screenNeighbours(triangles[neighbours_[i].a.value], triangles[neighbours_[i].b.value],
                     candidates);
  }
}

void PairScreen<Triangle>::screen(const Prepared& a, const Prepared& b,
                                  std::vector<Candidate<Triangle>>& candidates) const {
  if (sharedBits(a.vertex_id, b.vertex_id) != 0) {
    screenNeighbours(a, b, candidates);
  } else {
    screenSeparate(a, b, candidates);
  }
}

void PairScreen<Triangle>::screenSeparate(const Prepared& a, const Prepared& b,
                                          std::vector<Candidate<Triangle>>& candidates) const {
  PairFacts facts;
  facts.margin_m = pairMargin(input_.scene.body(a.body.value).margin_m,
                              input_.scene.body(b.body.value).margin_m);
  const bool apart =
      sidesOf(b.plane, a.lanes, facts.sides.a) | sidesOf(a.plane, b.lanes, facts.sides.b);
  if (!apart || facts.margin_m > 0) candidates.push_back({a.triangle, b.triangle, facts});
}

void PairScreen<Triangle>::screenNeighbours(const Prepared& a, const Prepared& b,
                                            std::vector<Candidate<Triangle>>& candidates) const {
  const int in_a = sharedBits(a.vertex_id, b.vertex_id);
  if (input_.options.adjacent == AdjacentPairs::kSkip || isCertified(a, in_a)) return;
  const int in_b = sharedBits(b.vertex_id, a.vertex_id);
  if (restOnOneSide(b.plane, a.lanes, in_a) || restOnOneSide(a.plane, b.lanes, in_b)) return;
  PairFacts facts;
  facts.shared = sharedByBits(static_cast<std::uint32_t>(in_a), static_cast<std::uint32_t>(in_b));
  candidates.push_back({a.triangle, b.triangle, facts});
}

}  // namespace deformable_contact_monitor
