// Stage pose, once vertices have their places and identities: which fans are certified.
#include "core/predicates/vertex_fan.h"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;

__device__ Vec3f posedAt(const SceneArrays& scene, VertexIndex i) {
  const float4 p = scene.posed[i];
  return {p.x, p.y, p.z};
}

// As isFanCertified() wants it.
class RingOfVertex {
 public:
  __device__ RingOfVertex(const SceneArrays& scene, VertexIndex i)
      : scene_(scene), begin_(scene.fan_begin[i]), end_(scene.fan_begin[i + 1]) {}
  __device__ std::uint32_t size() const { return end_.value - begin_.value; }
  __device__ Vec3f ring(std::uint32_t k) const {
    return posedAt(scene_, scene_.fan_ring[begin_ + k]);
  }
  __device__ bool closed() const {
    return scene_.fan_ring[begin_] == scene_.fan_ring[Place(end_.value - 1)];
  }

 private:
  const SceneArrays& scene_;
  Place begin_, end_;
};

// A thread for each vertex, a block for each of scene.vertex_blocks: reads scene.posed and
// scene.repeated, which is zero again; adds to scene.vertex_id. No vertex of another index has the
// same place in the mesh: so the ring tells of all triangles there.
__global__ void __launch_bounds__(kThreads) fanKernel(CycleArrays c) {
  const BodyBlock block = c.scene.vertex_blocks[Place(blockIdx.x)];
  if (threadIdx.x >= block.count || c.scene.bodies[block.body].has_self == 0) return;
  const VertexIndex i(block.first + threadIdx.x);
  const bool repeated = c.scene.repeated[i] != 0;
  if (repeated) c.scene.repeated[i] = 0;
  if (repeated || c.scene.vertex_id[i] != i) return;
  const Vec3f v = posedAt(c.scene, i);
  if (!c.params().share.has(v) || !isFanCertified(v, RingOfVertex(c.scene, i))) return;
  c.scene.vertex_id[i] = VertexIndex(i.value | kFanCertified);
}

}  // namespace

void launchPoseFans(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  if (!shape.fans) return;
  fanKernel<<<cycle.scene.vertex_block_count, kThreads, 0, stream>>>(cycle);
}

}  // namespace deformable_contact_monitor
