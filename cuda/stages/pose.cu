// First stage: vertices into the scene frame, boxes of the bodies, nearest prototypes.
#include "core/rules/vertex_hash.h"
#include "cuda/device/boxes.cuh"
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
// With so few, lanes that all do the same are faster than a shorter search.
constexpr std::uint32_t kFewPrototypes = 64;

__device__ Vec3f receivedAt(const CycleView& c, std::uint32_t i) {
  const float* v = c.received + 3 * std::size_t{i};
  return {v[0], v[1], v[2]};
}

__device__ void putPosed(const CycleView& c, std::uint32_t i, const Vec3f& v,
                         const Winner& winner) {
  c.posed[i] =
      make_float4(v.x, v.y, v.z, __uint_as_float(winner.cluster << 1 | (winner.tied ? 1U : 0U)));
}

__global__ void __launch_bounds__(kThreads) poseKernel(CycleView c) {
  letNextStart();  // the kernel ahead has ended: this one is launched the usual way
  const std::uint32_t thread = blockIdx.x * kThreads + threadIdx.x;
  if (thread <= c.cluster_count) {
    c.bins[thread] = c.next_bins[thread];
    countOf(c, thread) = 0;
  }
  if (thread == 0) *c.counters = CycleCounters{};
  if (blockIdx.x >= c.vertex_block_count) return;

  const BodyBlock block = c.vertex_blocks[blockIdx.x];
  const DeviceBody& body = c.bodies[block.body];
  const bool inside = threadIdx.x < block.count;
  const std::uint32_t i = block.first + (inside ? threadIdx.x : 0);
  Vec3f v = receivedAt(c, i);
  if (body.identity_pose == 0) v = apply(body.pose, v);
  const bool finite = isFinite(v);
  const bool wanted = inside && finite;
  if (body.partner_count > 0) {
    __shared__ BlockBox box;
    box.clear();
    box.include(wanted ? Aabb{v, v} : Aabb{});
    box.addTo(c.body_boxes + kSides * block.body);
  }
  const PrototypesView view = prototypesView(c);
  const Vec3f scaled = c.params->scale.apply(v);
  Nearest nearest;
  bool found = true;
  if (wanted && view.count <= kFewPrototypes) {
    nearest = nearestOfAll(view, scaled);
  } else if (wanted) {
    // Last cycle's winner is the best guess, where there was one.
    std::uint32_t start = __float_as_uint(c.posed[i].w) >> 1;
    if (start >= c.cluster_count) start = 0;
    found = nearestListed(view, scaled, start, body.slack, nearest);
  }
  const std::uint32_t place = warpReserve(c.far_count, !found);
  if (!found) c.far_vertices[place] = make_uint2(i, block.body);
  if (inside) putPosed(c, i, v, wanted ? nearest.winner(scaled, body.slack) : Winner());
}

// By a whole warp.
__device__ Nearest nearestByWarp(const PrototypesView& view, const Vec3f& v) {
  Nearest nearest;
#pragma unroll 4
  for (std::uint32_t g = laneId(); g < view.count; g += kWarp) {
    nearest.consider(g, squaredDistance(v, view.prototypes[g]));
  }
  for (unsigned o = kWarp / 2; o > 0; o /= 2) {
    Nearest other;
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

// The vertices for which the lists did not reach far enough, over all prototypes; but for those
// whose triangles will be culled. The rule would do with a worse guess, but in many more clusters.
__global__ void __launch_bounds__(kThreads) farKernel(CycleView c) {
  awaitKernelAhead();
  letNextStart();
  const std::uint32_t count = *c.far_count;
  const std::uint32_t warps = gridDim.x * (kThreads / kWarp);
  const std::uint32_t each = min(kWarp, (count + warps - 1) / warps);
  const std::uint32_t warp = (blockIdx.x * kThreads + threadIdx.x) / kWarp;
  for (std::uint32_t first = warp * each; first < count; first += warps * each) {
    const std::uint32_t k = first + laneId();
    const bool mine = laneId() < each && k < count;
    const uint2 far = mine ? c.far_vertices[k] : make_uint2(0, 0);
    unsigned rest = __ballot_sync(kFullWarp, mine && !isOutOfReach(c, far.y));
    for (; rest != 0; rest &= rest - 1) {
      const int lane = __ffs(static_cast<int>(rest)) - 1;
      const std::uint32_t i = __shfl_sync(kFullWarp, far.x, lane);
      const std::uint32_t body = __shfl_sync(kFullWarp, far.y, lane);
      const float4 p = c.posed[i];
      const Vec3f v{p.x, p.y, p.z};
      const Vec3f scaled = c.params->scale.apply(v);
      const Nearest nearest = nearestByWarp(prototypesView(c), scaled);
      if (laneId() == 0) putPosed(c, i, v, nearest.winner(scaled, c.bodies[body].slack));
    }
  }
}

// An open-addressing table into which each vertex puts its number + 1, unless one with equal
// coordinates is there. Slots are filled once and never emptied, so a reader sees all it needs.
__global__ void __launch_bounds__(kThreads) identifyKernel(CycleView c) {
  const BodyBlock block = c.vertex_blocks[blockIdx.x];
  if (threadIdx.x >= block.count) return;
  const DeviceBody& body = c.bodies[block.body];
  const std::uint32_t i = block.first + threadIdx.x;
  const Vec3f v = receivedAt(c, i);
  c.vertex_id[i] = i;
  if (body.has_self == 0 || !isFinite(v)) return;
  std::uint32_t slot = static_cast<std::uint32_t>(vertexHash(v, block.body)) & c.identity_mask;
  while (true) {
    const std::uint32_t found = atomicCAS(&c.identity_table[slot], 0U, i + 1);
    if (found == 0) return;
    const std::uint32_t other = found - 1;
    const bool same_body = other - body.first_vertex < body.vertex_count;
    if (same_body && receivedAt(c, other) == v) {
      c.vertex_id[i] = other;
      return;
    }
    slot = (slot + 1) & c.identity_mask;
  }
}

}  // namespace

void launchPose(const CycleView& cycle, const DeviceTraits& device, cudaStream_t stream) {
  const unsigned for_bins = cycle.cluster_count / kThreads + 1;
  poseKernel<<<max(cycle.vertex_block_count, for_bins), kThreads, 0, stream>>>(cycle);
  constexpr unsigned kFarBlocksEach = 4;  // of a multiprocessor
  launchEarly(farKernel, kFarBlocksEach * device.multiprocessors, kThreads, 0, device, stream,
              cycle);
}

void launchIdentify(const CycleView& cycle, cudaStream_t stream) {
  cudaMemsetAsync(cycle.identity_table, 0,
                  (std::size_t{cycle.identity_mask} + 1) * sizeof(std::uint32_t), stream);
  identifyKernel<<<cycle.vertex_block_count, kThreads, 0, stream>>>(cycle);
}

}  // namespace deformable_contact_monitor
