// Stage pose, beside the posing: which fans are certified, and the ids of triangles' vertices.
#include "core/predicates/vertex_fan.h"
#include "core/rules/posed_vertex.h"
#include "cuda/device/warp.cuh"
#include "cuda/stages/corners.cuh"
#include "cuda/stages/pose_parts.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
// A closed ring of a usual mesh has seven points. Of blocks with more, some are fetched again and
// again.
constexpr std::uint32_t kStagedPoints = 10 * kThreads;

__device__ Vec3f posedAt(const SceneArrays& scene, const DeviceBody& body, VertexIndex i) {
  return posedVertex(body.pose, body.identity_pose != 0, receivedAt(scene, i));
}

// As isFanCertified() wants it. The points of a block's rings, which follow one another, are
// fetched all at once: one after the other each would be waited for.
class RingOfVertex {
 public:
  // `staged`: the points of the rings' places from `first` on.
  __device__ RingOfVertex(const SceneArrays& scene, const DeviceBody& body, const Vec3f* staged,
                          Place first, VertexIndex i)
      : scene_(scene),
        body_(body),
        staged_(staged),
        first_(first),
        begin_(scene.fan_begin[i]),
        end_(scene.fan_begin[i + 1]) {}
  __device__ std::uint32_t size() const { return end_.value - begin_.value; }
  __device__ Vec3f ring(std::uint32_t k) const {
    const std::uint32_t at = begin_.value - first_.value + k;
    return at < kStagedPoints ? staged_[at] : posedAt(scene_, body_, scene_.fan_ring[begin_ + k]);
  }
  __device__ bool closed() const {
    return scene_.fan_ring[begin_] == scene_.fan_ring[Place(end_.value - 1)];
  }

 private:
  const SceneArrays& scene_;
  const DeviceBody& body_;
  const Vec3f* staged_;
  Place first_, begin_, end_;
};

// A thread for each vertex, a block for each of scene.vertex_blocks: reads scene.received, so that
// it need not wait for scene.posed, and scene.repeated, which is zero again; adds to
// scene.vertex_id. No vertex of another index has the same place in the mesh: so the ring tells of
// all triangles there.
__global__ void __launch_bounds__(kThreads) fanKernel(CycleArrays c) {
  __shared__ Vec3f staged[kStagedPoints];
  const SceneArrays& scene = c.scene;
  const BodyBlock block = scene.vertex_blocks[Place(blockIdx.x)];
  const DeviceBody& body = scene.bodies[block.body];
  if (body.has_self == 0) return;
  const Place first = scene.fan_begin[VertexIndex(block.first)];
  const Place end = scene.fan_begin[VertexIndex(block.first + block.count)];
  const std::uint32_t count = min(end.value - first.value, kStagedPoints);
#pragma unroll 4
  for (std::uint32_t k = threadIdx.x; k < count; k += kThreads) {
    staged[k] = posedAt(scene, body, scene.fan_ring[first + k]);
  }
  __syncthreads();
  if (threadIdx.x >= block.count) return;
  const VertexIndex i(block.first + threadIdx.x);
  const bool repeated = scene.repeated[i] != 0;
  if (repeated) scene.repeated[i] = 0;
  if (repeated || scene.vertex_id[i] != i) return;
  const Vec3f v = posedAt(scene, body, i);
  const RingOfVertex ring(scene, body, staged, first, i);
  if (!c.params().share.has(v) || !isFanCertified(v, ring)) return;
  scene.vertex_id[i] = VertexIndex(i.value | kFanCertified);
}

// A thread for each slot of a tile: reads scene.vertex_id; writes members.ids.
__global__ void __launch_bounds__(kThreads) slotIdsKernel(CycleArrays c) {
  const MemberIndex slot(blockIdx.x * kThreads + threadIdx.x);
  if (slot.value >= c.scene.tile_count * kWarp) return;
  const TriangleIndex t = c.scene.slot_triangle[slot];
  c.members.ids[slot] = t.value == kNone ? uint4{} : idsOf(c.scene, t);
}

}  // namespace

void launchPoseFans(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  if (!shape.identify) return;
  if (shape.fans) fanKernel<<<cycle.scene.vertex_block_count, kThreads, 0, stream>>>(cycle);
  const unsigned slots = cycle.scene.tile_count * kWarp;
  slotIdsKernel<<<(slots + kThreads - 1) / kThreads, kThreads, 0, stream>>>(cycle);
}

}  // namespace deformable_contact_monitor
