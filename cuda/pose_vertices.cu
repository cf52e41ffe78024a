// First stage: vertices into the scene frame, boxes of the bodies, nearest prototypes.
#include "core/vertex_hash.h"
#include "cuda/boxes.cuh"
#include "cuda/stages.cuh"
#include "cuda/warp.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;

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
  Winner winner;
  if (wanted) {
    // Last cycle's winner is the best guess, where there was one.
    std::uint32_t start = __float_as_uint(c.posed[i].w) >> 1;
    if (start >= c.cluster_count) start = 0;
    Nearest nearest;
    const bool sure = nearestListed(view, scaled, start, body.slack, nearest);
    winner = nearest.winner(scaled, body.slack);
    // The half-space rule takes any competitor; only who is certain may do without the rule.
    if (!sure) winner.tied = true;
  }
  if (inside) putPosed(c, i, v, winner);
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

void launchPose(const CycleView& cycle, cudaStream_t stream) {
  const unsigned for_bins = cycle.cluster_count / kThreads + 1;
  poseKernel<<<max(cycle.vertex_block_count, for_bins), kThreads, 0, stream>>>(cycle);
}

void launchIdentify(const CycleView& cycle, cudaStream_t stream) {
  cudaMemsetAsync(cycle.identity_table, 0,
                  (std::size_t{cycle.identity_mask} + 1) * sizeof(std::uint32_t), stream);
  identifyKernel<<<cycle.vertex_block_count, kThreads, 0, stream>>>(cycle);
}

}  // namespace deformable_contact_monitor
