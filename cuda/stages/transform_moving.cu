// Stage transform in swept motion: transforms both states of the vertices, and estimates the motion
// that all of them have in common. Boxes and clusters ignore the common motion, so that boxes do
// not grow when the whole scene moves.
#include "core/rules/common_motion.h"
#include "core/rules/posed_vertex.h"
#include "core/rules/vertex_hash.h"
#include "cuda/device/launch.cuh"
#include "cuda/stages/transform_parts.cuh"

namespace deformable_contact_monitor {
namespace {

// Returns a vertex as received in the earlier state.
__device__ Vec3f earlierReceivedAt(const SceneArrays& scene, const EarlierBody& body,
                                   VertexIndex i) {
  if (body.has_vertices == 0) return receivedAt(scene, i);
  const float* v = scene.earlier_received.row(i);
  return {v[0], v[1], v[2]};
}

__device__ MovingPoint posedAt(const SceneArrays& scene, BodyIndex b, VertexIndex i) {
  const DeviceBody& body = scene.bodies[b];
  const EarlierBody& earlier = scene.earlier_bodies[b];
  MovingPoint p;
  p.to = posedVertex(body.pose, body.identity_pose != 0, receivedAt(scene, i));
  p.from = earlier.is_still != 0 ? p.to
                                 : posedVertex(earlier.pose, earlier.identity_pose != 0,
                                               earlierReceivedAt(scene, earlier, i));
  return p;
}

__device__ bool isFiniteAlways(const MovingPoint& p) { return isFinite(p.from) && isFinite(p.to); }

// Returns the median of the lanes' numbers, by a bitonic sort. Called by a whole warp.
__device__ float warpMedian(float x) {
  for (unsigned size = 2; size <= kWarp; size *= 2) {
    for (unsigned step = size / 2; step > 0; step /= 2) {
      const float other = __shfl_xor_sync(kFullWarp, x, step);
      const bool ascending = (laneId() & size) == 0;
      const bool lower = (laneId() & step) == 0;
      x = lower == ascending ? fminf(x, other) : fmaxf(x, other);
    }
  }
  return __shfl_sync(kFullWarp, x, kWarp / 2);
}

// Returns the median of the motions of 32 vertices that are evenly spread, or 0 if subtracting it
// would not halve the motions. Called by a whole warp.
__device__ Vec3f sampledMotion(const SceneArrays& scene) {
  const BodyBlock block = scene.vertex_blocks[Place(
      static_cast<std::uint32_t>(std::uint64_t{scene.vertex_block_count} * laneId() / kWarp))];
  const MovingPoint p = posedAt(scene, block.body, VertexIndex(block.first + block.count / 2));
  Vec3f motion;
  if (isFiniteAlways(p)) motion = p.to - p.from;
  const Vec3f common{warpMedian(motion.x), warpMedian(motion.y), warpMedian(motion.z)};
  const auto size = [](const Vec3f& m) { return fmaxf(fabsf(m.x), fmaxf(fabsf(m.y), fabsf(m.z))); };
  const float with = warpMedian(size(motion)), without = warpMedian(size(motion - common));
  return isFinite(common) && 2 * without < with ? common : Vec3f{};
}

// One warp: writes scene.common_motion.
__global__ void __launch_bounds__(kWarp) commonMotionKernel(CycleArrays c) {
  letNextKernelStart();
  const Vec3f motion = sampledMotion(c.scene);
  if (laneId() == 0) c.scene.common_motion[Place(0)] = motion;
}

__device__ void putEarlier(const SceneArrays& scene, VertexIndex i, const Vec3f& v,
                           const NearestPrototype& nearest) {
  scene.earlier_posed[i] =
      make_float4(v.x, v.y, v.z, __uint_as_float(nearest.cluster << 1 | (nearest.tied ? 1U : 0U)));
}

// A vertex at both ends of the time interval, as the clusters use it [scaled]. The common motion is
// subtracted from the later state.
struct ScaledPoint {
  Vec3f from, to;

  __device__ ScaledPoint(const CycleArrays& c, const MovingPoint& p) {
    const SceneScale scale = c.params().scale;
    from = scale.apply(p.from);
    to = withoutMotion(scale, c.scene.common_motion[Place(0)]).apply(p.to);
  }
};

// Does what transformKernel in transform.cu does, for both states: writes scene.earlier_posed too.
__global__ void __launch_bounds__(kTransformThreads) transformMovingKernel(CycleArrays c) {
  const BodyBlock block = c.scene.vertex_blocks[Place(blockIdx.x)];
  const DeviceBody& body = c.scene.bodies[block.body];
  const bool inside = threadIdx.x < block.count;
  const VertexIndex i(block.first + (inside ? threadIdx.x : 0));
  const MovingPoint p = posedAt(c.scene, block.body, i);
  const bool wanted = inside && isFiniteAlways(p);
  std::uint32_t start = __float_as_uint(c.scene.posed[i].w) >> 1;
  awaitPreviousKernel();
  letNextKernelStart();
  const PrototypesView view = c.clusters.view();
  const ScaledPoint scaled(c, p);
  NearestSearch from, to;
  bool found = true;
  if (wanted && view.count <= kFewPrototypes) {
    from = nearestOfAll(view, scaled.from);
    to = nearestOfAll(view, scaled.to);
  } else if (wanted) {
    if (start >= view.count) start = 0;
    // A vertex outside the partition keeps this guess, as in transform.cu.
    from.cluster = to.cluster = start;
    const ScenePartition& partition = c.params().partition;
    if (partition.has(p.from) || partition.has(p.to)) {
      found = nearestListed(view, scaled.to, start, body.slack, to);
      found = nearestListed(view, scaled.from, to.cluster, body.slack, from) && found;
    }
  }
  if (body.partner_count > 0) {
    __shared__ BlockBox box;
    box.clear();
    const Vec3f motion = c.scene.common_motion[Place(0)];
    box.include(wanted ? sweptBox({{p.from, p.from}, {p.to, p.to}}, motion) : Aabb{});
    box.addTo(c.scene.body_boxes.row(block.body));
  }
  const Place place(warpReserve(&c.counters().far_vertices, !found));
  if (!found) c.scene.far_vertices[place] = {i, block.body};
  if (inside) {
    putPosed(c.scene, i, p.to, wanted ? to.result(scaled.to, body.slack) : NearestPrototype());
    putEarlier(c.scene, i, p.from,
               wanted ? from.result(scaled.from, body.slack) : NearestPrototype());
  }
}

// Does what farKernel in transform.cu does, for both states.
__global__ void __launch_bounds__(kTransformThreads) farMovingKernel(CycleArrays c) {
  awaitPreviousKernel();
  letNextKernelStart();
  forEachFarVertex(c, [&c](VertexIndex i, BodyIndex body) {
    const float4 to = c.scene.posed[i], from = c.scene.earlier_posed[i];
    const MovingPoint p{{from.x, from.y, from.z}, {to.x, to.y, to.z}};
    const ScaledPoint scaled(c, p);
    const NearestSearch nearest_to = nearestByWarp(c.clusters.view(), scaled.to);
    const NearestSearch nearest_from = nearestByWarp(c.clusters.view(), scaled.from);
    const float slack = c.scene.bodies[body].slack;
    if (laneId() != 0) return;
    putPosed(c.scene, i, p.to, nearest_to.result(scaled.to, slack));
    putEarlier(c.scene, i, p.from, nearest_from.result(scaled.from, slack));
  });
}

// Does what identify() in vertex_identity.cu does. Vertices are equal if they are equal as received
// in both states.
__global__ void __launch_bounds__(kTransformThreads) identifyMovingKernel(CycleArrays c) {
  const BodyBlock block = c.scene.vertex_blocks[Place(blockIdx.x)];
  if (threadIdx.x >= block.count) return;
  const DeviceBody& body = c.scene.bodies[block.body];
  const EarlierBody& earlier = c.scene.earlier_bodies[block.body];
  const auto received = [&](VertexIndex v) {
    return MovingPoint{earlierReceivedAt(c.scene, earlier, v), receivedAt(c.scene, v)};
  };
  const VertexIndex i(block.first + threadIdx.x);
  const MovingPoint p = received(i);
  c.scene.vertex_id[i] = i;
  if (body.has_self == 0 || !isFiniteAlways(p)) return;
  const std::uint32_t mask = c.scene.identity_mask;
  const auto hash_to = static_cast<std::uint32_t>(vertexHash(p.to, block.body.value));
  Place slot(static_cast<std::uint32_t>(vertexHash(p.from, hash_to)) & mask);
  while (true) {
    const std::uint32_t found = atomicCAS(&c.scene.identity_table[slot], 0U, i.value + 1);
    if (found == 0) return;
    const VertexIndex other(found - 1);
    const bool same_body = other.value - body.first_vertex < body.vertex_count;
    if (same_body && received(other) == p) {
      c.scene.vertex_id[i] = other;
      return;
    }
    slot = Place((slot.value + 1) & mask);
  }
}

}  // namespace

void launchMovingVertexIdentities(const CycleArrays& cycle, cudaStream_t stream) {
  identifyMovingKernel<<<cycle.scene.vertex_block_count, kTransformThreads, 0, stream>>>(cycle);
}

void launchTransformMoving(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  commonMotionKernel<<<1, kWarp, 0, stream>>>(cycle);
  launchDependent(transformMovingKernel, cycle.scene.vertex_block_count, kTransformThreads, 0,
                  shape.device, stream, cycle);
  launchFar(farMovingKernel, cycle, shape, stream);
}

}  // namespace deformable_contact_monitor
