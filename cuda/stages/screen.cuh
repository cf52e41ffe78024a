// The cheap tests between a sweep and the narrow phase.
#pragma once

#include "core/predicates/aabb.h"
#include "core/predicates/narrow_phase.h"
#include "cuda/memory/cycle_view.cuh"

namespace deformable_contact_monitor {

// One bit per vertex of `a` that is also one of `b`.
__device__ inline std::uint32_t sharedBits(const uint4& a, const uint4& b) {
  const auto in_b = [&b](std::uint32_t id) { return id == b.x || id == b.y || id == b.z; };
  return (in_b(a.x) ? 1U : 0U) | (in_b(a.y) ? 2U : 0U) | (in_b(a.z) ? 4U : 0U);
}

__device__ inline std::uint32_t packSigns(const KnownSides& sides) {
  std::uint32_t signs = 0;
  for (int k = 0; k < 3; ++k) {
    signs |= static_cast<std::uint32_t>(sides.a[k] + 1) << (2 * k);
    signs |= static_cast<std::uint32_t>(sides.b[k] + 1) << (6 + 2 * k);
  }
  return signs;
}

__device__ inline KnownSides unpackSides(std::uint32_t signs) {
  KnownSides sides;
  for (int k = 0; k < 3; ++k) {
    sides.a[k] = static_cast<int>(signs >> (2 * k) & 3) - 1;
    sides.b[k] = static_cast<int>(signs >> (6 + 2 * k) & 3) - 1;
  }
  return sides;
}

constexpr unsigned kSharedShift = 12;

__device__ inline SharedVertices unpackShared(std::uint32_t signs) {
  SharedVertices shared;
  for (int k = 0; k < 3; ++k) {
    shared.in_a[k] = (signs >> (kSharedShift + k) & 1) != 0;
    shared.in_b[k] = (signs >> (kSharedShift + 3 + k) & 1) != 0;
    shared.any = shared.any || shared.in_a[k];
  }
  return shared;
}

__device__ inline float marginOf(const CycleView& c, const Member& a, const Member& b) {
  return most(c.bodies[a.body_and_home >> 1].margin_m, c.bodies[b.body_and_home >> 1].margin_m);
}

__device__ inline Aabb memberBox(const CycleView& c, const Member& m) {
  return inflated(boxOf(m.posed),
                  c.params->margins == 0 ? 0 : c.bodies[m.body_and_home >> 1].margin_m);
}

// A pair is reported only in the lowest cluster that its triangles have in common.
__device__ inline bool ownedBy(const CycleView& c, std::uint32_t cluster, const Member& a,
                               const Member& b) {
  if (a.list == kNone || b.list == kNone) return true;
  return lowestCommon(c.lists + a.list + 1, c.lists + b.list + 1) == cluster;
}

// Whether two members are a candidate; `shared_a` and `shared_b` are the bits of their shared
// vertices. `cluster`: where they met; kNone: they could meet nowhere else.
__device__ inline bool isCandidate(const CycleView& c, std::uint32_t cluster, std::uint32_t at_a,
                                   std::uint32_t at_b, std::uint32_t shared_a,
                                   std::uint32_t shared_b, Candidate& candidate) {
  const Member a = c.members[at_a], b = c.members[at_b];
  if (c.params->classes_exact == 0) {
    const std::uint32_t x = a.body_and_home >> 1, y = b.body_and_home >> 1;
    if ((c.pair_enabled[x * c.pair_row + y / 32] >> (y % 32) & 1) == 0) return false;
  }
  const PlaneFilter plane_a(a.posed), plane_b(b.posed);
  candidate = {at_a, at_b, 0};
  if (shared_a != 0) {
    candidate.signs = (shared_a | shared_b << 3) << kSharedShift;
    if (certainlyNotBeyondShared(a.posed, plane_a, b.posed, plane_b,
                                 unpackShared(candidate.signs))) {
      return false;
    }
  } else {
    KnownSides sides;
    const bool apart = certainlyApart(a.posed, plane_a, b.posed, plane_b, sides);
    if (apart && (c.params->margins == 0 || marginOf(c, a, b) == 0)) return false;
    candidate.signs = packSigns(sides);
  }
  return overlap(memberBox(c, a), memberBox(c, b)) &&
         (cluster == kNone || ownedBy(c, cluster, a, b));
}

}  // namespace deformable_contact_monitor
