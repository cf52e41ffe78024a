// Finds the ring of triangles around each vertex when a scene is laid out. Stage transform
// certifies fans from these rings. The kernels count the triangles of each vertex, reserve places
// by a prefix sum, fill them, and order each ring.
#include <cub/device/device_scan.cuh>

#include "core/rules/fan_order.h"
#include "cuda/stages/tiles.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;

// One thread for each vertex, one block for each of scene.vertex_blocks: starts the count of
// places. A ring has one place more than triangles. Vertices of bodies that do not touch themselves
// have no ring. One more element holds the end of the last ring.
__global__ void __launch_bounds__(kThreads) beginKernel(SceneArrays scene) {
  const BodyBlock block = scene.vertex_blocks[Place(blockIdx.x)];
  if (threadIdx.x >= block.count) return;
  const VertexIndex v(block.first + threadIdx.x);
  scene.fan_count[v] = scene.bodies[block.body].has_self != 0 ? 1 : 0;
  if (blockIdx.x == gridDim.x - 1 && threadIdx.x == block.count - 1) scene.fan_count[v + 1] = 0;
}

// One thread for each triangle, one block for each of scene.triangle_blocks: adds to
// scene.fan_count.
__global__ void __launch_bounds__(kThreads) countKernel(SceneArrays scene) {
  const BodyBlock block = scene.triangle_blocks[Place(blockIdx.x)];
  if (threadIdx.x >= block.count || scene.bodies[block.body].has_self == 0) return;
  const VertexIndex* const corner = scene.corners.row(TriangleIndex(block.first + threadIdx.x));
  for (int k = 0; k < 3; ++k) atomicAdd(&scene.fan_count[corner[k]], 1U);
}

// One thread for each triangle: puts its number into the rings of its corners, in any order. Counts
// scene.fan_count down to one, which leaves the first place of each ring free.
__global__ void __launch_bounds__(kThreads) fillKernel(SceneArrays scene) {
  const BodyBlock block = scene.triangle_blocks[Place(blockIdx.x)];
  if (threadIdx.x >= block.count || scene.bodies[block.body].has_self == 0) return;
  const TriangleIndex t(block.first + threadIdx.x);
  const VertexIndex* const corner = scene.corners.row(t);
  for (int k = 0; k < 3; ++k) {
    const std::uint32_t place = atomicSub(&scene.fan_count[corner[k]], 1U) - 1;
    scene.fan_ring[scene.fan_begin[corner[k]] + place] = VertexIndex(t.value);
  }
}

// Finds the edges opposite to v of the triangles in its ring, in the order of the triangles'
// numbers, as on the host. Sorts `triangles` by insertion, because rings are short.
__device__ void findEdges(const SceneArrays& scene, VertexIndex v, std::uint32_t* triangles,
                          std::uint32_t count, FanEdge* edges) {
  for (std::uint32_t i = 1; i < count; ++i) {
    const std::uint32_t t = triangles[i];
    std::uint32_t k = i;
    for (; k > 0 && triangles[k - 1] > t; --k) triangles[k] = triangles[k - 1];
    triangles[k] = t;
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    const VertexIndex* const corner = scene.corners.row(TriangleIndex(triangles[i]));
    // A triangle that uses the vertex twice is twice in the ring, and has a different edge each
    // time.
    std::uint32_t turn = i > 0 && triangles[i - 1] == triangles[i] ? 1 : 0;
    if (i > 1 && triangles[i - 2] == triangles[i]) ++turn;
    int k = 0;
    while (corner[k] != v || turn-- > 0) ++k;
    edges[i] = {corner[(k + 1) % 3].value, corner[(k + 2) % 3].value};
  }
}

// One thread for each vertex, one block for each of scene.vertex_blocks: replaces the triangles in
// the ring by the ordered ring of vertices (core/rules/fan_order.h).
__global__ void __launch_bounds__(kThreads) orderKernel(SceneArrays scene) {
  const BodyBlock block = scene.vertex_blocks[Place(blockIdx.x)];
  if (threadIdx.x >= block.count || scene.bodies[block.body].has_self == 0) return;
  const VertexIndex v(block.first + threadIdx.x);
  const std::uint32_t begin = scene.fan_begin[v].value;
  const std::uint32_t count = scene.fan_begin[v + 1].value - begin - 1;
  auto* const ring = reinterpret_cast<std::uint32_t*>(scene.fan_ring.data()) + begin;
  std::uint32_t triangles[kMostFanTriangles];
  FanEdge edges[kMostFanTriangles];
  if (count <= kMostFanTriangles) {
    for (std::uint32_t k = 0; k < count; ++k) triangles[k] = ring[k + 1];
    findEdges(scene, v, triangles, count, edges);
  }
  putRing(v.value, edges, count, ring);
}

}  // namespace

void launchFanRings(const SceneArrays& scene, std::uint32_t vertices,
                    DeviceBuffer<unsigned char>& scratch, cudaStream_t stream) {
  beginKernel<<<scene.vertex_block_count, kThreads, 0, stream>>>(scene);
  countKernel<<<scene.triangle_block_count, kThreads, 0, stream>>>(scene);
  auto* const begins = reinterpret_cast<std::uint32_t*>(scene.fan_begin.data());
  const auto sum = [&](void* memory, std::size_t& bytes) {
    checkCuda(cub::DeviceScan::ExclusiveSum(memory, bytes, scene.fan_count.data(), begins,
                                            vertices + 1, stream),
              "cub::DeviceScan");
  };
  std::size_t bytes = 0;
  sum(nullptr, bytes);
  if (bytes > scratch.size()) scratch.grow(2 * bytes, stream);
  sum(scratch.data(), bytes);
  fillKernel<<<scene.triangle_block_count, kThreads, 0, stream>>>(scene);
  orderKernel<<<scene.vertex_block_count, kThreads, 0, stream>>>(scene);
  checkCuda(cudaGetLastError(), "a kernel of the fans' rings");
}

}  // namespace deformable_contact_monitor
