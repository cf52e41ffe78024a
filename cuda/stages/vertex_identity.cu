// Stage pose, beside the posing: which vertices are equal, which fans are certified, and the ids of
// triangles' vertices.
#include "core/predicates/vertex_fan.h"
#include "core/rules/posed_vertex.h"
#include "core/rules/vertex_hash.h"
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/transform_parts.cuh"

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

// The vertex whose number + 1 is in scene.identity_table for all that equal `v`: `i`, which does,
// where there was none. Slots are filled once and never emptied, so a reader sees all it needs.
__device__ VertexIndex firstEqual(const SceneArrays& scene, BodyIndex b, VertexIndex i,
                                  const Vec3f& v) {
  const DeviceBody& body = scene.bodies[b];
  const std::uint32_t mask = scene.identity_mask;
  Place slot(static_cast<std::uint32_t>(vertexHash(v, b.value)) & mask);
  while (true) {
    const std::uint32_t found = atomicCAS(&scene.identity_table[slot], 0U, i.value + 1);
    if (found == 0) return i;
    const VertexIndex other(found - 1);
    const bool same_body = other.value - body.first_vertex < body.vertex_count;
    if (same_body && receivedAt(scene, other) == v) return other;
    slot = Place((slot.value + 1) & mask);
  }
}

// A vertex's number, or on which side of the share it is.
__device__ std::uint32_t numberOrSide(const CycleArrays& c, const DeviceBody& body, VertexIndex i) {
  const SceneShare& share = c.params().share;
  if (share.isWhole()) return i.value;
  const Vec3f v = posedAt(c.scene, body, i);
  const Aabb box = inflated(Aabb{v, v}, body.margin_m);
  if (share.isBelow(box)) return kBelowShare;
  return share.isAbove(box) ? kAboveShare : i.value;
}

// A thread for each vertex of the block: writes scene.vertex_id.
__device__ void identify(const CycleArrays& c, const BodyBlock& block) {
  if (threadIdx.x >= block.count) return;
  const SceneArrays& scene = c.scene;
  const DeviceBody& body = scene.bodies[block.body];
  const VertexIndex i(block.first + threadIdx.x);
  const Vec3f v = receivedAt(scene, i);
  const bool wanted = body.has_self != 0 && isFinite(v);
  const std::uint32_t number = wanted ? numberOrSide(c, body, i) : i.value;
  scene.vertex_id[i] = VertexIndex(number);
  if (!wanted || number != i.value) return;
  __threadfence();  // who finds this vertex adds to that
  const VertexIndex first = firstEqual(scene, block.body, i, v);
  if (first == i) return;
  scene.vertex_id[i] = first;
  atomicOr(reinterpret_cast<std::uint32_t*>(&scene.vertex_id[first]), kRepeated);
}

// The same: writes scene.fan_certified.
__device__ void certifyFans(const CycleArrays& c, const BodyBlock& block, Vec3f* staged) {
  const SceneArrays& scene = c.scene;
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
  const Vec3f v = posedAt(scene, body, i);
  const RingOfVertex ring(scene, body, staged, first, i);
  scene.fan_certified[i] = c.params().share.has(v) && isFanCertified(v, ring) ? 1 : 0;
}

// A block for each of scene.vertex_blocks, and where fans are asked for another one: side by side,
// for both spend their time waiting. They read scene.received, so as not to wait for scene.posed.
__global__ void __launch_bounds__(kThreads) identityKernel(CycleArrays c) {
  __shared__ Vec3f staged[kStagedPoints];
  const std::uint32_t blocks = c.scene.vertex_block_count;
  if (blockIdx.x < blocks) {
    identify(c, c.scene.vertex_blocks[Place(blockIdx.x)]);
  } else {
    certifyFans(c, c.scene.vertex_blocks[Place(blockIdx.x - blocks)], staged);
  }
}

// A vertex's id, of what scene.vertex_id has of it; with kFanCertified where that is so: no vertex
// of another index has the same place in the mesh, so its ring tells of all triangles there.
__device__ std::uint32_t idOf(const CycleArrays& c, BodyIndex body, VertexIndex v,
                              std::uint32_t id) {
  if (id >= kAboveShare) return firstEqual(c.scene, body, v, receivedAt(c.scene, v)).value;
  const bool certified = c.params().fans != 0 && id == v.value && c.scene.fan_certified[v] != 0;
  return certified ? id | kFanCertified : id & ~kRepeated;
}

// A thread for each slot of a tile: reads scene.vertex_id and scene.fan_certified; writes the ids
// of the triangle's vertices to members.ids, unless it is beside the share.
__global__ void __launch_bounds__(kThreads) slotIdsKernel(CycleArrays c) {
  const MemberIndex slot(blockIdx.x * kThreads + threadIdx.x);
  if (slot.value >= c.scene.tile_count * kWarp) return;
  const TriangleIndex t = c.scene.slot_triangle[slot];
  if (t.value == kNone) return;
  const BodyIndex body = c.scene.tile_body[TileIndex(slot.value / kWarp)];
  const VertexIndex* const row = c.scene.corners.row(t);
  const VertexIndex v[] = {row[0], row[1], row[2]};
  awaitKernelAhead();
  const uint3 id = {c.scene.vertex_id[v[0]].value, c.scene.vertex_id[v[1]].value,
                    c.scene.vertex_id[v[2]].value};
  if (id.x >= kAboveShare && id.x == id.y && id.x == id.z) return;
  c.members.ids[slot] = make_uint4(idOf(c, body, v[0], id.x), idOf(c, body, v[1], id.y),
                                   idOf(c, body, v[2], id.z), 0);
}

}  // namespace

void launchPoseIdentities(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  if (!shape.identify) return;
  if (shape.swept) return launchPoseMovingIdentities(cycle, stream);
  const unsigned blocks = (shape.fans ? 2 : 1) * cycle.scene.vertex_block_count;
  identityKernel<<<blocks, kThreads, 0, stream>>>(cycle);
}

void launchPoseIds(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  if (!shape.identify) return;
  const unsigned slots = cycle.scene.tile_count * kWarp;
  launchEarly(slotIdsKernel, (slots + kThreads - 1) / kThreads, kThreads, 0, shape.device, stream,
              cycle);
}

}  // namespace deformable_contact_monitor
