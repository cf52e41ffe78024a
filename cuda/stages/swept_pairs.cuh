// Pairs in swept motion: from boxes that meet to candidates (stages sweep and large), and what the
// judge knows of a candidate.
#pragma once

#include "core/predicates/swept_intersection.h"
#include "core/rules/common_motion.h"
#include "cuda/stages/screen.cuh"

namespace deformable_contact_monitor {

__device__ inline MovingTriangle movingAt(const CycleArrays& c, MemberIndex at) {
  return {c.members.earlier[at].posed, c.members.members[at].posed};
}

// A box grown by what the body's boxes grow by, and a little, for pads of two bodies are added up
// and taken off in another order elsewhere.
__device__ inline Aabb grown(const Aabb& box, float by_m) {
  return inflated(inflated(box, by_m), by_m * 1e-6F);
}

// Of two members' bodies [m].
__device__ inline float padOf(const CycleArrays& c, const Member& a, const Member& b) {
  return pairPad(c.scene.earlier_bodies[a.body].pad_m, c.scene.earlier_bodies[b.body].pad_m);
}

// A triangle at both ends of the step, with its body's pad.
__device__ inline MovingBox paddedBox(const CycleArrays& c, const MovingTriangle& t, float pad_m) {
  const MovingBox box = boxOf(t);
  if (c.params().pads == 0) return box;
  return {grown(box.from, pad_m), grown(box.to, pad_m)};
}
__device__ inline MovingBox movingBoxAt(const CycleArrays& c, MemberIndex at) {
  return paddedBox(c, movingAt(c, at), c.scene.bodies[c.members.members[at].body].margin_m);
}

// Of a member, for the shares: as Corners::reachesInto() has it.
__device__ inline Aabb shareBoxAt(const CycleArrays& c, MemberIndex at) {
  return shareBox(boxOf(movingAt(c, at)), c.scene.bodies[c.members.members[at].body].margin_m);
}

// As screenPair, of two members in swept motion; by moving boxes.
__device__ inline bool screenMovingPair(const CycleArrays& c, MemberIndex at_a, MemberIndex at_b,
                                        std::uint32_t shared_a, std::uint32_t shared_b,
                                        DeviceCandidate& candidate) {
  const Member& a = c.members.members[at_a];
  const Member& b = c.members.members[at_b];
  if (c.params().groups_exact == 0 && !pairEnabled(c.scene, a.body, b.body)) return false;
  // The lesser triangle first, so that times do not depend on who found the pair.
  candidate = a.triangle < b.triangle
                  ? DeviceCandidate{at_a, at_b, (shared_a | shared_b << 3) << kSharedShift}
                  : DeviceCandidate{at_b, at_a, (shared_b | shared_a << 3) << kSharedShift};
  const SceneShare& share = c.params().share;
  if (!share.isWhole() && !share.owns(shareBoxAt(c, at_a), shareBoxAt(c, at_b))) return false;
  return !areApart(movingBoxAt(c, at_a), movingBoxAt(c, at_b));
}

// DeviceCandidate::facts in swept motion: sides at t = 0 and shared vertices as packFacts has them,
// sides at t = 1, and what the static filters left open.
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

// SweptState::bits: of open features, of those that are to be halved, and what else is known.
constexpr std::uint32_t kFeatureBits = (1U << kFeatures) - 1;
constexpr unsigned kLeftAt = kFeatures;
constexpr std::uint32_t kMeetsAtEnd = 1U << 30, kUndecided = 1U << 31;
static_assert(2 * kFeatures <= 30, "bits are not shared");

constexpr std::uint32_t kNever = 0x40000000U;  // 2 as a float's bits

}  // namespace deformable_contact_monitor
