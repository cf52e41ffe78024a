// Provides the parts that stage transform at one moment and in swept motion have in common.
#pragma once

#include "cuda/device/boxes.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/corners.cuh"
#include "cuda/stages/cut_off.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {

// With at most so many prototypes, testing all of them is faster than a shorter search in which the
// lanes of a warp take different paths.
constexpr std::uint32_t kFewPrototypes = 64;

__device__ inline Vec3f receivedAt(const SceneArrays& scene, VertexIndex i) {
  const float* v = scene.received.row(i);
  return {v[0], v[1], v[2]};
}

// Writes a vertex to scene.posed, with its nearest prototype packed into w.
__device__ inline void putPosed(const SceneArrays& scene, VertexIndex i, const Vec3f& v,
                                const NearestPrototype& nearest) {
  scene.posed[i] =
      make_float4(v.x, v.y, v.z, __uint_as_float(nearest.cluster << 1 | (nearest.tied ? 1U : 0U)));
}

// Returns the nearest of all prototypes. Called by a whole warp, whose lanes divide the prototypes.
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

// The number of threads of a block in this stage.
constexpr unsigned kTransformThreads = 128;

// Calls visit(vertex, body) by a whole warp for each of scene.far_vertices, except those of bodies
// whose triangles will be culled. Called by all blocks of a kernel, of kTransformThreads each.
template <class Visit>
__device__ inline void forEachFarVertex(const CycleArrays& c, const Visit& visit) {
  const std::uint32_t count = c.counters().far_vertices;
  const std::uint32_t warps = gridDim.x * (kTransformThreads / kWarp);
  const std::uint32_t each = min(kWarp, (count + warps - 1) / warps);
  const std::uint32_t warp = (blockIdx.x * kTransformThreads + threadIdx.x) / kWarp;
  for (std::uint32_t first = warp * each; first < count; first += warps * each) {
    if (first >= warps * each && warpIsCutOff(c, warp % kWarpsPerAsker == 0)) return;
    const std::uint32_t k = first + laneId();
    const bool mine = laneId() < each && k < count;
    const FarVertex far = mine ? c.scene.far_vertices[Place(k)] : FarVertex{};
    unsigned rest = __ballot_sync(kFullWarp, mine && !isOutOfReach(c.scene, far.body));
    for (; rest != 0; rest &= rest - 1) {
      const int lane = __ffs(static_cast<int>(rest)) - 1;
      visit(VertexIndex(__shfl_sync(kFullWarp, far.vertex.value, lane)),
            BodyIndex(__shfl_sync(kFullWarp, far.body.value, lane)));
    }
  }
}

// Launches a kernel that calls forEachFarVertex(), by programmatic dependent launch. Does nothing
// if there are so few prototypes that no vertex can be far.
inline void launchFar(void (*kernel)(CycleArrays), const CycleArrays& cycle,
                      const CycleShape& shape, cudaStream_t stream) {
  if (cycle.clusters.count <= kFewPrototypes) return;
  constexpr unsigned kFarBlocksEach = 4;  // of a multiprocessor
  launchDependent(kernel, kFarBlocksEach * shape.device.multiprocessors, kTransformThreads, 0,
                  shape.device, stream, cycle);
}

// Enqueue the stage in swept motion; launchVertexIdentities() and launchTransform() call them.
void launchMovingVertexIdentities(const CycleArrays& cycle, cudaStream_t stream);
void launchTransformMoving(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

}  // namespace deformable_contact_monitor
