// What poses of one state and of two have in common (stage pose).
#pragma once

#include "cuda/device/boxes.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {

// With so few, lanes that all do the same are faster than a shorter search.
constexpr std::uint32_t kFewPrototypes = 64;

__device__ inline Vec3f receivedAt(const SceneArrays& scene, VertexIndex i) {
  const float* v = scene.received.row(i);
  return {v[0], v[1], v[2]};
}

__device__ inline void putPosed(const SceneArrays& scene, VertexIndex i, const Vec3f& v,
                                const NearestPrototype& nearest) {
  scene.posed[i] =
      make_float4(v.x, v.y, v.z, __uint_as_float(nearest.cluster << 1 | (nearest.tied ? 1U : 0U)));
}

// By a whole warp: the nearest of all prototypes.
__device__ inline NearestSearch nearestByWarp(const PrototypesView& view, const Vec3f& v) {
  NearestSearch nearest;
#pragma unroll 4
  for (std::uint32_t g = laneId(); g < view.count; g += kWarp) {
    nearest.consider(g, squaredDistance(v, view.prototypes[g]));
  }
  for (unsigned o = kWarp / 2; o > 0; o /= 2) {
    NearestSearch other;
    other.cluster = __shfl_xor_sync(kFullWarp, nearest.cluster, o);
    other.least2 = __shfl_xor_sync(kFullWarp, nearest.least2, o);
    other.second2 = __shfl_xor_sync(kFullWarp, nearest.second2, o);
    const float second2 =
        fminf(fmaxf(nearest.least2, other.least2), fminf(nearest.second2, other.second2));
    if (other.least2 < nearest.least2) nearest = other;
    nearest.second2 = second2;
  }
  return nearest;
}

// In swept motion, in place of launchPoseIdentities and launchPose.
void launchPoseMovingIdentities(const CycleArrays& cycle, cudaStream_t stream);
void launchPoseMoving(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

}  // namespace deformable_contact_monitor
