// Filters pairs in swept motion, in the stages sweep and oversized, and defines the facts that the
// narrow phase gets with a candidate.
#pragma once

#include "core/predicates/swept_intersection.h"
#include "cuda/stages/pair_filter.cuh"

namespace deformable_contact_monitor {

__device__ inline MovingTriangle movingAt(const CycleArrays& c, TileEntryIndex at) {
  return {c.tiles.earlier[at].posed, c.tiles.entries[at].posed};
}

// Returns a box grown by its body's pad and a little more. The sum of two pads is rounded
// differently where a pair is tested, and the extra covers the difference.
__device__ inline Aabb grown(const Aabb& box, float by_m) {
  return inflated(inflated(box, by_m), by_m * 1e-6F);
}

// Returns the pad of two entries' bodies [m].
__device__ inline float padOf(const CycleArrays& c, const TileEntry& a, const TileEntry& b) {
  return pairPad(c.scene.earlier_bodies[a.body].pad_m, c.scene.earlier_bodies[b.body].pad_m);
}

// Return the boxes of a triangle at both ends of the time interval, grown by its body's pad [m].
__device__ inline MovingBox paddedBox(const CycleArrays& c, const MovingTriangle& t, float pad_m) {
  const MovingBox box = boxOf(t);
  if (c.params().pads == 0) return box;
  return {grown(box.from, pad_m), grown(box.to, pad_m)};
}
__device__ inline MovingBox movingBoxAt(const CycleArrays& c, TileEntryIndex at) {
  return paddedBox(c, movingAt(c, at), c.scene.bodies[c.tiles.entries[at].body].margin_m);
}

// Returns the box of a tile entry that decides its partition, the same as in
// Corners::reachesInto().
__device__ inline Aabb partitionBoxAt(const CycleArrays& c, TileEntryIndex at) {
  return partitionBox(boxOf(movingAt(c, at)), c.scene.bodies[c.tiles.entries[at].body].margin_m);
}

// Does what filterPair() and isCandidateHere() do for two entries in swept motion, by moving boxes.
__device__ inline bool filterMovingPair(const CycleArrays& c, TileEntryIndex at_a,
                                        TileEntryIndex at_b, std::uint32_t shared_a,
                                        std::uint32_t shared_b, DeviceCandidate& candidate) {
  const TileEntry& a = c.tiles.entries[at_a];
  const TileEntry& b = c.tiles.entries[at_b];
  if (c.params().groups_exact == 0 && !c.scene.pairEnabled(a.part, b.part)) return false;
  // Puts the triangle with the lesser number first, so that the computed times do not depend on how
  // the pair was found.
  candidate = a.triangle < b.triangle
                  ? DeviceCandidate{at_a, at_b, (shared_a | shared_b << 3) << kSharedShift}
                  : DeviceCandidate{at_b, at_a, (shared_b | shared_a << 3) << kSharedShift};
  const ScenePartition& partition = c.params().partition;
  if (!partition.isWhole() && !partition.owns(partitionBoxAt(c, at_a), partitionBoxAt(c, at_b)))
    return false;
  return !areApart(movingBoxAt(c, at_a), movingBoxAt(c, at_b));
}

// DeviceCandidate::facts in swept motion has the sides at t = 0 and the shared vertices as in
// packFacts(), then the sides at t = 1, and then which ends the static filters left open.
constexpr unsigned kEndShift = 18;
constexpr std::uint32_t kStartOpen = 1U << 30, kEndOpen = 1U << 31;

__device__ inline std::uint32_t packSides(const KnownSides& sides) {
  std::uint32_t packed = 0;
  for (int k = 0; k < 3; ++k) {
    packed |= static_cast<std::uint32_t>(sides.a[k] + 1) << (2 * k);
    packed |= static_cast<std::uint32_t>(sides.b[k] + 1) << (6 + 2 * k);
  }
  return packed;
}

__device__ inline KnownSides unpackSides(std::uint32_t packed) {
  KnownSides sides;
  for (int k = 0; k < 3; ++k) {
    sides.a[k] = static_cast<int>(packed >> (2 * k) & 3) - 1;
    sides.b[k] = static_cast<int>(packed >> (6 + 2 * k) & 3) - 1;
  }
  return sides;
}

// SweptState::bits has a bit for each open feature, then a bit for each feature to be halved, and
// then two flags. For a while, the first bits are of features whose only root is looked for.
constexpr std::uint32_t kFeatureBits = (1U << kFeatures) - 1;
constexpr unsigned kLeftAt = kFeatures;
constexpr std::uint32_t kMeetsAtEnd = 1U << 30, kUndecided = 1U << 31;
static_assert(2 * kFeatures <= 30, "bits are not shared");

constexpr std::uint32_t kNever = 0x40000000U;  // the bits of 2.0F: after any time in [0, 1]

}  // namespace deformable_contact_monitor
