// Stage transform, on a branch beside the transformation: finds which vertices are equal and which
// fans are certified, and gives tile entries the ids of their vertices.
#include "core/predicates/vertex_fan.h"
#include "core/rules/fan_order.h"
#include "core/rules/posed_vertex.h"
#include "core/rules/vertex_hash.h"
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/transform_parts.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
// The room for ring points of a block. A closed ring of a usual mesh has seven points; points
// beyond the room are computed again each time that they are needed.
constexpr std::uint32_t kStagedPoints = 10 * kThreads;

__device__ Vec3f posedAt(const SceneArrays& scene, const DeviceBody& body, VertexIndex i) {
  return posedVertex(body.pose, body.identity_pose != 0, receivedAt(scene, i));
}

// The ring of a vertex, as isFanCertified() needs it. The rings of a block are consecutive in
// memory, and all their points are fetched at once, because the latencies of single reads would add
// up.
class RingOfVertex {
 public:
  // `staged`: the points of the ring places from `first` on.
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

// Returns the vertex that stands for all vertices that equal `v`. Searches scene.identity_table, an
// open-addressing hash table, and enters `i` itself if there is none yet. Slots are filled once and
// never emptied, so the search is correct while other threads add vertices.
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

// Returns a vertex's number, or kBelowPartition or kAbovePartition if it lies outside the
// partition.
__device__ std::uint32_t numberOrSide(const CycleArrays& c, const DeviceBody& body, VertexIndex i) {
  const ScenePartition& partition = c.params().partition;
  if (partition.isWhole()) return i.value;
  const Vec3f v = posedAt(c.scene, body, i);
  const Aabb box = inflated(Aabb{v, v}, body.margin_m);
  if (partition.isBelow(box)) return kBelowPartition;
  return partition.isAbove(box) ? kAbovePartition : i.value;
}

// One thread for each vertex of the block: writes scene.vertex_id.
__device__ void identify(const CycleArrays& c, const BodyBlock& block) {
  if (threadIdx.x >= block.count) return;
  const SceneArrays& scene = c.scene;
  const DeviceBody& body = scene.bodies[block.body];
  const VertexIndex i(block.first + threadIdx.x);
  const Vec3f v = receivedAt(scene, i);
  const bool wanted = body.has_self != 0 && isFinite(v);
  const std::uint32_t number = wanted ? numberOrSide(c, body, i) : i.value;
  const bool is_searched = wanted && number == i.value;
  const VertexIndex first = is_searched ? firstEqual(scene, block.body, i, v) : VertexIndex(number);
  const bool marks = c.params().fans != 0;
  const auto addBits = [&scene](VertexIndex to, std::uint32_t bits) {
    atomicOr(reinterpret_cast<std::uint32_t*>(&scene.vertex_id[to]), bits);
  };
  if (marks && first == i) {
    addBits(i, i.value);  // another thread may have set kRepeated before
  } else {
    scene.vertex_id[i] = first;
  }
  if (!is_searched || first == i) return;
  atomicAdd(&c.counters().repeated_vertices, 1U);
  if (marks) addBits(first, kRepeated);
}

// One thread for each vertex of the block: writes scene.fan_certified. If no vertex of the block
// has two triangles, no fan can decide a pair.
__device__ void certifyFans(const CycleArrays& c, const BodyBlock& block, Vec3f* staged) {
  const SceneArrays& scene = c.scene;
  const DeviceBody& body = scene.bodies[block.body];
  if (body.has_self == 0) return;
  const bool mine = threadIdx.x < block.count;
  const VertexIndex i(block.first + (mine ? threadIdx.x : 0));
  constexpr std::uint32_t kRingOfOne = 2;
  const bool has_pair = scene.fan_begin[i + 1].value - scene.fan_begin[i].value > kRingOfOne;
  if (__syncthreads_or(mine && has_pair ? 1 : 0) == 0) {
    if (mine) scene.fan_certified[i] = 0;
    return;
  }
  const Place first = scene.fan_begin[VertexIndex(block.first)];
  const Place end = scene.fan_begin[VertexIndex(block.first + block.count)];
  const std::uint32_t count = min(end.value - first.value, kStagedPoints);
#pragma unroll 4
  for (std::uint32_t k = threadIdx.x; k < count; k += kThreads) {
    staged[k] = posedAt(scene, body, scene.fan_ring[first + k]);
  }
  __syncthreads();
  if (!mine) return;
  const Vec3f v = posedAt(scene, body, i);
  const RingOfVertex ring(scene, body, staged, first, i);
  // putRing() leaves the rings of larger fans without an order.
  const bool may_be = ring.size() <= kMostFanTriangles + 1 && c.params().partition.has(v);
  scene.fan_certified[i] = may_be && isFanCertified(v, ring) ? 1 : 0;
}

// One block for each of scene.vertex_blocks, and if fans are needed a second one. Both kinds of
// blocks run side by side, because they spend most time waiting for memory. They read
// scene.received, so that they do not have to wait for scene.posed.
__global__ void __launch_bounds__(kThreads) identityKernel(CycleArrays c) {
  extern __shared__ unsigned char memory[];  // for kStagedPoints points, if fans are needed
  auto* const staged = reinterpret_cast<Vec3f*>(memory);
  const std::uint32_t blocks = c.scene.vertex_block_count;
  if (blockIdx.x < blocks) {
    identify(c, c.scene.vertex_blocks[Place(blockIdx.x)]);
  } else {
    certifyFans(c, c.scene.vertex_blocks[Place(blockIdx.x - blocks)], staged);
  }
}

// Returns a vertex's id from its entry in scene.vertex_id, with kFanCertified if its fan is
// `certified` by its own ring. A certified fan counts only if no other vertex is equal to this one:
// then its ring has all triangles at that place.
__device__ std::uint32_t idOf(const CycleArrays& c, BodyIndex body, VertexIndex v, std::uint32_t id,
                              bool certified) {
  if (id >= kAbovePartition) return firstEqual(c.scene, body, v, receivedAt(c.scene, v)).value;
  return certified && id == v.value ? id | kFanCertified : id & ~kRepeated;
}

// One thread for each slot of a tile: reads scene.vertex_id and scene.fan_certified; writes the ids
// of the triangle's vertices to tiles.ids, unless the triangle lies beside the partition.
__global__ void __launch_bounds__(kThreads) slotIdsKernel(CycleArrays c) {
  const TileEntryIndex slot(blockIdx.x * kThreads + threadIdx.x);
  if (slot.value >= c.scene.tile_count * kWarp) return;
  const uint4 numbers = c.scene.slot_numbers[slot];
  if (numbers.w == kNone) return;
  const BodyIndex body = c.scene.tile_body[TileIndex(slot.value / kWarp)];
  const VertexIndex v[] = {VertexIndex(numbers.x), VertexIndex(numbers.y), VertexIndex(numbers.z)};
  const bool fans = c.params().fans != 0;
  awaitPreviousKernel();
  const uint3 id = {c.scene.vertex_id[v[0]].value, c.scene.vertex_id[v[1]].value,
                    c.scene.vertex_id[v[2]].value};
  bool certified[3];
  for (int k = 0; k < 3; ++k) certified[k] = fans && c.scene.fan_certified[v[k]] != 0;
  if (id.x >= kAbovePartition && id.x == id.y && id.x == id.z) return;
  c.tiles.ids[slot] =
      make_uint4(idOf(c, body, v[0], id.x, certified[0]), idOf(c, body, v[1], id.y, certified[1]),
                 idOf(c, body, v[2], id.z, certified[2]), 0);
}

}  // namespace

void launchVertexIdentities(const CycleArrays& cycle, const CycleShape& shape,
                            cudaStream_t stream) {
  if (!shape.identify) return;
  if (shape.swept) return launchMovingVertexIdentities(cycle, stream);
  const unsigned blocks = (shape.fans ? 2 : 1) * cycle.scene.vertex_block_count;
  const std::size_t staged_bytes = shape.fans ? kStagedPoints * sizeof(Vec3f) : 0;
  identityKernel<<<blocks, kThreads, staged_bytes, stream>>>(cycle);
}

void launchEntryIds(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  if (!shape.identify) return;
  const unsigned slots = cycle.scene.tile_count * kWarp;
  launchDependent(slotIdsKernel, (slots + kThreads - 1) / kThreads, kThreads, 0, shape.device,
                  stream, cycle);
}

}  // namespace deformable_contact_monitor
