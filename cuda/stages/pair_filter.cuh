// Filters pairs whose boxes meet: the last part of the stages sweep and oversized. The pairs that
// are left are candidates.
#pragma once

#include "core/predicates/aabb.h"
#include "core/predicates/narrow_phase.h"
#include "core/predicates/vertex_fan.h"
#include "core/rules/margins.h"
#include "cuda/memory/cycle_arrays.cuh"

namespace deformable_contact_monitor {

// Returns the ids of all tile entries' vertices, as far as CycleParams::identities knows them; null
// if it knows none.
__device__ inline const uint4* vertexIds(const CycleArrays& c) {
  if (c.params().identities == KnownIdentities::kNone) return nullptr;
  const bool all = c.params().identities == KnownIdentities::kAll;
  return all ? c.tiles.ids.data() : c.scene.slot_numbers.data();
}

// Returns one bit for each vertex of `a` that is also a vertex of `b`. x, y, z are the ids of the
// vertices.
__device__ inline std::uint32_t sharedBits(const uint4& a, const uint4& b) {
  const auto inB = [&b](std::uint32_t id) {
    return static_cast<std::uint32_t>((id == b.x) | (id == b.y) | (id == b.z));
  };
  return inB(a.x) | inB(a.y) << 1 | inB(a.z) << 2;
}

// Returns whether some vertex of `a` is also one of `b`.
__device__ inline bool shareVertices(const uint4& a, const uint4& b) {
  return (a.x == b.x) | (a.x == b.y) | (a.x == b.z) | (a.y == b.x) | (a.y == b.y) | (a.y == b.z) |
         (a.z == b.x) | (a.z == b.y) | (a.z == b.z);
}

// The bits of all three vertices of a triangle.
constexpr std::uint32_t kAllVertices = 7;

// Returns a bit for each vertex that has a certified fan. Triangles that share such a vertex meet
// only in the vertices and edges that they share.
__device__ inline std::uint32_t certifiedBits(const uint4& ids) {
  const auto bit = [](std::uint32_t id) { return (id & kFanCertified) != 0 ? 1U : 0U; };
  return bit(ids.x) | bit(ids.y) << 1 | bit(ids.z) << 2;
}

// Packs the facts of a pair into one word, see DeviceCandidate::facts. The margin is not among
// them.
constexpr unsigned kSharedShift = 12;

__device__ inline std::uint32_t packFacts(const PairFacts& facts) {
  std::uint32_t packed = 0;
  for (int k = 0; k < 3; ++k) {
    packed |= static_cast<std::uint32_t>(facts.sides.a[k] + 1) << (2 * k);
    packed |= static_cast<std::uint32_t>(facts.sides.b[k] + 1) << (6 + 2 * k);
    packed |= (facts.shared.in_a[k] ? 1U : 0U) << (kSharedShift + k);
    packed |= (facts.shared.in_b[k] ? 1U : 0U) << (kSharedShift + 3 + k);
  }
  return packed;
}

__device__ inline PairFacts unpackFacts(std::uint32_t packed) {
  PairFacts facts;
  for (int k = 0; k < 3; ++k) {
    facts.sides.a[k] = static_cast<int>(packed >> (2 * k) & 3) - 1;
    facts.sides.b[k] = static_cast<int>(packed >> (6 + 2 * k) & 3) - 1;
  }
  facts.shared = sharedByBits(packed >> kSharedShift & 7, packed >> (kSharedShift + 3) & 7);
  return facts;
}

// Returns the bits of the shared vertices: three for those of a, then three for those of b.
__device__ inline std::uint32_t sharedBitsOf(const DeviceCandidate& candidate) {
  return candidate.facts >> kSharedShift & 0x3f;
}

// Returns the margin of two entries' bodies [m].
__device__ inline float marginOf(const CycleArrays& c, const TileEntry& a, const TileEntry& b) {
  if (c.params().margins == 0) return 0;
  return pairMargin(c.scene.bodies[a.body].margin_m, c.scene.bodies[b.body].margin_m);
}

__device__ inline Aabb tileEntryBox(const CycleArrays& c, const TileEntry& m) {
  return inflated(boxOf(m.posed), c.params().margins == 0 ? 0 : c.scene.bodies[m.body].margin_m);
}

// Finds the shared vertices of two tile entries by their coordinates. Vertices are equal if they
// are equal as received; then they are equal in the scene frame too.
__device__ inline SharedVertices sharedAsReceived(const CycleArrays& c, const TileEntry& a,
                                                  const TileEntry& b) {
  bool same_x = false;  // most pairs need no other test
  for (int k = 0; k < 9; ++k) same_x |= a.posed.v[k / 3].x == b.posed.v[k % 3].x;
  if (a.body != b.body || !same_x || !sharedVertices(a.posed, b.posed).any) return {};
  const auto received = [&c](const TileEntry& of) {
    Triangle t;
    for (int k = 0; k < 3; ++k) {
      const float* const v = c.scene.received.row(c.scene.corners.row(of.triangle)[k]);
      t.v[k] = {v[0], v[1], v[2]};
    }
    return t;
  };
  return sharedVertices(received(a), received(b));
}

// Returns whether two tile entries whose boxes meet may be a candidate, and sets `candidate`.
// `shared_a` and `shared_b`: the bits of their shared vertices, as far as they are known. For pairs
// with a margin planes decide nothing. isCandidateHere() makes the other tests.
__device__ inline bool filterPair(const CycleArrays& c, TileEntryIndex at_a, TileEntryIndex at_b,
                                  std::uint32_t shared_a, std::uint32_t shared_b,
                                  DeviceCandidate& candidate) {
  const TileEntry a = c.tiles.at(at_a), b = c.tiles.at(at_b);
  if (c.params().groups_exact == 0 && !c.scene.pairEnabled(a.part, b.part)) return false;
  PairFacts facts;
  facts.shared = sharedByBits(shared_a, shared_b);
  facts.margin_m = marginOf(c, a, b);
  if (!isCandidate(a.posed, b.posed, facts)) return false;
  candidate = {at_a, at_b, packFacts(facts)};
  return true;
}

// Returns whether a pair that filterPair() left is a candidate of this partition. If equal vertices
// were not searched (CycleParams::identities), it compares those of the pair: it drops a pair that
// shares one if such pairs are skipped or if it is certainly apart beyond the shared vertices, and
// otherwise adds these to `candidate`. filterPair() has dropped no such pair, because triangles
// that share a vertex meet.
__device__ inline bool isCandidateHere(const CycleArrays& c, const TileEntry& a, const TileEntry& b,
                                       DeviceCandidate& candidate) {
  const CycleParams& params = c.params();
  // The boxes were rounded, and there are no planes where there are margins.
  if (params.margins != 0 && !intersects(tileEntryBox(c, a), tileEntryBox(c, b))) return false;
  const ScenePartition& partition = params.partition;
  if (!partition.isWhole() && !partition.owns(tileEntryBox(c, a), tileEntryBox(c, b))) return false;
  if (params.any_self == 0 || params.identities == KnownIdentities::kAll) return true;
  PairFacts facts = unpackFacts(candidate.facts);
  facts.shared = sharedAsReceived(c, a, b);
  if (!facts.shared.any) return true;
  atomicAdd(&c.counters().sharing_pairs, 1U);
  candidate.facts = packFacts(facts);
  return params.adjacent != AdjacentPairs::kSkip &&
         beyondSharedVerdict(facts.shared, facts.sides) != PartVerdict::kApart;
}

}  // namespace deformable_contact_monitor
