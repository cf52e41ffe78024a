// Stage pose: vertices into the scene frame, boxes of the bodies, nearest prototypes.
#include "core/rules/posed_vertex.h"
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/cut_off.cuh"
#include "cuda/stages/reach.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/transform_parts.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;

// A thread for each vertex, a block for each of scene.vertex_blocks: reads scene.received, writes
// scene.posed, adds to scene.body_boxes and, where the lists of neighbours do not reach far enough
// for a vertex, to scene.far_vertices.
__global__ void __launch_bounds__(kThreads) poseKernel(CycleArrays c) {
  const BodyBlock block = c.scene.vertex_blocks[Place(blockIdx.x)];
  const DeviceBody& body = c.scene.bodies[block.body];
  const bool inside = threadIdx.x < block.count;
  const VertexIndex i(block.first + (inside ? threadIdx.x : 0));
  const Vec3f v = posedVertex(body.pose, body.identity_pose != 0, receivedAt(c.scene, i));
  const bool wanted = inside && isFinite(v);
  const PrototypesView view = c.clusters.view();
  const Vec3f scaled = c.params().scale.apply(v);
  NearestSearch nearest;
  bool found = true;
  if (wanted && view.count <= kFewPrototypes) {
    nearest = nearestOfAll(view, scaled);
  } else if (wanted) {
    // Last cycle's nearest is the best guess, where there was one.
    std::uint32_t start = __float_as_uint(c.scene.posed[i].w) >> 1;
    if (start >= view.count) start = 0;
    nearest.cluster = start;  // and tied, where this share has next to nothing to look for
    if (c.params().share.has(v)) {
      found = nearestListed(view, scaled, start, body.slack, nearest);
    }
  }
  letNextStart();  // the first kernel of a cycle: nothing is ahead of it
  if (body.partner_count > 0) {
    __shared__ BlockBox box;
    box.clear();
    box.include(wanted ? Aabb{v, v} : Aabb{});
    box.addTo(c.scene.body_boxes.row(block.body));
  }
  const Place place(warpReserve(&c.counters().far_vertices, !found));
  if (!found) c.scene.far_vertices[place] = {i, block.body};
  if (inside) {
    putPosed(c.scene, i, v, wanted ? nearest.result(scaled, body.slack) : NearestPrototype());
  }
}

// A warp for each of scene.far_vertices, but for those whose triangles will be dropped: writes the
// nearest of all prototypes into scene.posed. The half-space rule would do with a worse guess, but
// in many more clusters.
__global__ void __launch_bounds__(kThreads) farKernel(CycleArrays c) {
  awaitKernelAhead();
  letNextStart();
  const std::uint32_t count = c.counters().far_vertices;
  const std::uint32_t warps = gridDim.x * (kThreads / kWarp);
  const std::uint32_t each = min(kWarp, (count + warps - 1) / warps);
  const std::uint32_t warp = (blockIdx.x * kThreads + threadIdx.x) / kWarp;
  for (std::uint32_t first = warp * each; first < count; first += warps * each) {
    if (first >= warps * each && warpIsCutOff(c, warp % kWarpsPerAsker == 0)) return;
    const std::uint32_t k = first + laneId();
    const bool mine = laneId() < each && k < count;
    const FarVertex far = mine ? c.scene.far_vertices[Place(k)] : FarVertex{};
    unsigned rest = __ballot_sync(kFullWarp, mine && !isOutOfReach(c.scene, far.body));
    for (; rest != 0; rest &= rest - 1) {
      const int lane = __ffs(static_cast<int>(rest)) - 1;
      const VertexIndex i(__shfl_sync(kFullWarp, far.vertex.value, lane));
      const BodyIndex body(__shfl_sync(kFullWarp, far.body.value, lane));
      const float4 p = c.scene.posed[i];
      const Vec3f v{p.x, p.y, p.z};
      const Vec3f scaled = c.params().scale.apply(v);
      const NearestSearch nearest = nearestByWarp(c.clusters.view(), scaled);
      if (laneId() == 0) {
        putPosed(c.scene, i, v, nearest.result(scaled, c.scene.bodies[body].slack));
      }
    }
  }
}

}  // namespace

void addClearing(const CycleArrays& cycle, const CycleShape& shape, HostCopies& copies) {
  copies.addZeros(1, cycle.the_counters.data());
  copies.addZeros(std::size_t{kSides} * cycle.scene.body_count, cycle.scene.body_boxes.data());
  const std::size_t clusters = cycle.clusters.count;
  copies.addZeros(clusters * MemberArrays::kCountPlaces, cycle.members.counts.data());
  copies.add(cycle.members.next_bins.data(), clusters, cycle.members.bins.data());
  copies.addZeros(cycle.contacts.swept_counters.size(), cycle.contacts.swept_counters.data());
  if (!shape.identify) return;
  copies.addZeros(cycle.scene.identity_table.size(), cycle.scene.identity_table.data());
}

void launchPose(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  if (shape.swept) return launchPoseMoving(cycle, shape, stream);
  poseKernel<<<cycle.scene.vertex_block_count, kThreads, 0, stream>>>(cycle);
  if (cycle.clusters.count <= kFewPrototypes) return;  // none is far

  constexpr unsigned kFarBlocksEach = 4;  // of a multiprocessor
  launchEarly(farKernel, kFarBlocksEach * shape.device.multiprocessors, kThreads, 0, shape.device,
              stream, cycle);
}

}  // namespace deformable_contact_monitor
