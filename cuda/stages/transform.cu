// Stage transform: brings vertices into the scene frame, bounds the bodies, and finds each vertex's
// nearest prototypes. The prototypes belong to stage assign; they are found here because each
// vertex is read once, while up to six triangles use it.
#include "core/rules/posed_vertex.h"
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/transform_parts.cuh"

namespace deformable_contact_monitor {
namespace {

// One thread for each vertex, one block for each of scene.vertex_blocks. Reads scene.received;
// writes scene.posed; adds to scene.body_boxes. If the lists of neighbours do not reach far enough
// for a vertex, it is added to scene.far_vertices.
__global__ void __launch_bounds__(kTransformThreads) transformKernel(CycleArrays c) {
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
    // Starts the search at the last cycle's nearest prototype, if there was one.
    std::uint32_t start = __float_as_uint(c.scene.posed[i].w) >> 1;
    if (start >= view.count) start = 0;
    // A vertex outside the partition keeps this guess, which counts as tied. That is correct for
    // any prototype, and few of these vertices have a triangle in the partition.
    nearest.cluster = start;
    if (c.params().partition.has(v)) {
      found = nearestListed(view, scaled, start, body.slack, nearest);
    }
  }
  letNextKernelStart();  // the first kernel of a cycle has no previous one
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

// One warp for each of scene.far_vertices, except those whose triangles will be culled: writes the
// nearest of all prototypes into scene.posed. A worse guess would be correct too, but the triangles
// would go to many more clusters.
__global__ void __launch_bounds__(kTransformThreads) farKernel(CycleArrays c) {
  awaitPreviousKernel();
  letNextKernelStart();
  forEachFarVertex(c, [&c](VertexIndex i, BodyIndex body) {
    const float4 p = c.scene.posed[i];
    const Vec3f v{p.x, p.y, p.z};
    const Vec3f scaled = c.params().scale.apply(v);
    const NearestSearch nearest = nearestByWarp(c.clusters.view(), scaled);
    if (laneId() == 0) putPosed(c.scene, i, v, nearest.result(scaled, c.scene.bodies[body].slack));
  });
}

}  // namespace

void addClearing(const CycleArrays& cycle, const CycleShape& shape, HostCopies& copies) {
  copies.addZeros(1, cycle.the_counters.data());
  copies.addZeros(std::size_t{kSides} * cycle.scene.body_count, cycle.scene.body_boxes.data());
  const std::size_t clusters = cycle.clusters.count;
  copies.addZeros(clusters * TileArrays::kCountPlaces, cycle.tiles.counts.data());
  copies.add(cycle.tiles.next_bins.data(), clusters, cycle.tiles.bins.data());
  copies.addZeros(cycle.contacts.swept_counters.size(), cycle.contacts.swept_counters.data());
  copies.addZeros(cycle.scene.rejected.size(), cycle.scene.rejected.data());
  if (!shape.identify) return;
  copies.addZeros(cycle.scene.identity_table.size(), cycle.scene.identity_table.data());
  if (shape.fans) copies.addZeros(cycle.scene.vertex_id.size(), cycle.scene.vertex_id.data());
}

void launchTransform(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  if (shape.swept) return launchTransformMoving(cycle, shape, stream);
  transformKernel<<<cycle.scene.vertex_block_count, kTransformThreads, 0, stream>>>(cycle);
  launchFar(farKernel, cycle, shape, stream);
}

}  // namespace deformable_contact_monitor
