// Boxes of bodies, regions and tiles in a state.
#pragma once

#include <cfloat>
#include <cmath>

#include "core/rules/posed_vertex.h"
#include "cuda/device/boxes.cuh"
#include "cuda/stages/nearest.cuh"
#include "cuda/states/state_arrays.cuh"

namespace deformable_contact_monitor {

// Returns RigidTransform::isIdentity(), which is for the host alone.
__device__ inline bool isIdentityPose(const RigidTransform& pose) {
  bool same = true;
  for (int i = 0; i < 9; ++i) same = same && pose.rotation[i] == (i % 4 == 0 ? 1 : 0);
  for (int i = 0; i < 3; ++i) same = same && pose.translation[i] == 0;
  return same;
}

// Returns a triangle in the scene frame in a state.
__device__ inline Triangle posedSlot(const StateArrays& s, std::uint32_t state, std::uint32_t body,
                                     std::uint32_t slot) {
  Triangle t;
  for (int k = 0; k < 3; ++k) {
    const float* const row = s.corner + std::size_t{3} * k * s.slotCount() + slot;
    t.v[k] = {row[0], row[s.slotCount()], row[std::size_t{2} * s.slotCount()]};
  }
  const std::uint32_t moved = s.bodies[body].moved;
  if (moved == kNone) return t;
  const RigidTransform& pose = s.poses[std::size_t{state} * s.moved_count + moved];
  const bool is_identity = isIdentityPose(pose);
  for (Vec3f& v : t.v) v = posedVertex(pose, is_identity, v);
  return t;
}

// A pose in float32, to move boxes by. Devices in robots compute little in double.
struct QuickPose {
  float rotation[9], translation[3];
  bool is_still;  // boxes stay as they are

  __device__ QuickPose(const StateArrays& s, std::uint32_t body, std::uint32_t state) {
    const std::uint32_t moved = s.bodies[body].moved;
    is_still = moved == kNone;
    if (is_still) return;
    const RigidTransform& pose = s.poses[std::size_t{state} * s.moved_count + moved];
    for (int i = 0; i < 9; ++i) rotation[i] = static_cast<float>(pose.rotation[i]);
    for (int i = 0; i < 3; ++i) translation[i] = static_cast<float>(pose.translation[i]);
  }

  // Returns a box that holds the place of every vertex in the box `received`, as posedVertex()
  // rounds it. It is all of space where float32 ends. The margin of the sizes covers a dozen
  // roundings to float32 here, and that of the vertices.
  __device__ Aabb boxOf(const Aabb& received) const {
    if (is_still || received.empty()) return received;
    constexpr float kRounding = 4e-6F, kLeast = 1e-37F;
    const Vec3f low = received.min * 0.5F, high = received.max * 0.5F;
    float least[3], most[3];
    bool is_bounded = true;
    for (int i = 0; i < 3; ++i) {
      float centre = translation[i], extent = 0, size = fabsf(translation[i]);
      for (int j = 0; j < 3; ++j) {
        const float r = rotation[3 * i + j];
        centre += r * (low[j] + high[j]);
        extent += fabsf(r) * (high[j] - low[j]);
        size += fabsf(r) * 2 * fmaxf(fabsf(low[j]), fabsf(high[j]));
      }
      const float reach = extent + size * kRounding + kLeast;
      least[i] = centre - reach;
      most[i] = centre + reach;
      is_bounded = is_bounded && fabsf(least[i]) < INFINITY && fabsf(most[i]) < INFINITY;
    }
    if (!is_bounded) return {{-FLT_MAX, -FLT_MAX, -FLT_MAX}, {FLT_MAX, FLT_MAX, FLT_MAX}};
    return {{least[0], least[1], least[2]}, {most[0], most[1], most[2]}};
  }

  // Returns whether boxOf() a box ends within float32.
  __device__ bool isBounded(const Aabb& received) const {
    return is_still || received.empty() || boxOf(received).max.x < FLT_MAX;
  }

  // A place, and what is at most its error [m].
  struct Place {
    Vec3f at;
    float error_m;
  };

  // Returns about where a point comes to be. The error goes by the sizes before they cancel.
  __device__ Place at(const Vec3f& p) const {
    if (is_still) return {p, 0};
    constexpr float kRounding = 4e-6F, kLeast = 1e-37F;
    float place[3], size = kLeast;
    for (int i = 0; i < 3; ++i) {
      const float* const r = rotation + 3 * i;
      place[i] = translation[i] + r[0] * p.x + r[1] * p.y + r[2] * p.z;
      size += fabsf(translation[i]) + fabsf(r[0] * p.x) + fabsf(r[1] * p.y) + fabsf(r[2] * p.z);
    }
    return {{place[0], place[1], place[2]}, size * kRounding + kLeast};
  }
};

// Returns whether triangles in two boxes may be within a reach [m]; 0: whether they may intersect.
__device__ inline bool areInReach(const Aabb& a, const Aabb& b, float reach_m) {
  if (a.empty() || b.empty()) return false;
  return reach_m == 0 ? intersects(a, b) : lowerGap(a, b) <= reach_m;
}

// Returns how near triangles of a pair of bodies must be to matter in a state [m].
__device__ inline float reachOf(const StateArrays& s, const DeviceStatePair& pair,
                                std::uint32_t state) {
  if (s.question.nearest == 0) return pair.touch_m == 0 ? 0 : pair.reachM(0);
  return pair.reachM(__uint_as_float(static_cast<const volatile std::uint32_t&>(s.apart[state])));
}

// Returns whether it is known that a pair of bodies touches in a state.
__device__ inline bool isKnownToTouch(const StateArrays& s, std::uint32_t state,
                                      std::uint32_t pair) {
  const std::size_t place = std::size_t{state} * s.pair_count + pair;
  return static_cast<const volatile std::uint8_t&>(s.pair_touches[place]) != 0;
}

// Returns the least triangle of body a that is of no interest any more, because others touch that
// come first; kNone if there is none. Those of pairs with radii are compared by their distances.
__device__ inline std::uint32_t firstIdle(const StateArrays& s, std::uint32_t state,
                                          std::uint32_t pair) {
  if (s.pairs[pair].touch_m > 0) return kNone;
  if (s.question.all_pairs != 0 && !isKnownToTouch(s, state, pair)) return kNone;
  const Key first = static_cast<const volatile Key&>(s.first_touch[state]);
  const auto first_pair = static_cast<std::uint32_t>(first >> 32);
  if (first_pair != pair) return first_pair < pair ? 0 : kNone;
  return triangleOf(first) + 1;
}

// Returns whether nothing more is asked about a pair of bodies in a state.
__device__ inline bool isAnswered(const StateArrays& s, std::uint32_t state, std::uint32_t pair) {
  if (s.question.nearest != 0) return firstIdle(s, state, pair) == 0;
  if (s.question.all_pairs != 0) return isKnownToTouch(s, state, pair);
  return static_cast<const volatile std::uint32_t&>(s.touches[state]) != 0;
}

// Returns whether the host has stopped the launch. One warp in several reads the host's memory.
// Called by a whole warp.
__device__ inline bool isStopped(const StateArrays& s, bool asks_host) {
  if (s.question.limited == 0) return false;
  int stopped = 0;
  if (laneId() == 0) {
    volatile std::uint32_t& mark = s.counters->stopped;
    if (mark == 0 && asks_host && *static_cast<const volatile std::uint32_t*>(s.host_stop) != 0) {
      mark = 1;
    }
    stopped = mark != 0 ? 1 : 0;
  }
  return __shfl_sync(kFullWarp, stopped, 0) != 0;
}

constexpr std::uint32_t kWarpsPerStopper = 32;

}  // namespace deformable_contact_monitor
