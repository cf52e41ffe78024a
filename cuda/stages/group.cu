// Which triangles share a tile: found on the device when a scene was laid out, and now and then
// anew, for bodies deform.
#include <cub/device/device_radix_sort.cuh>

#include "core/rules/space_curve.h"
#include "cuda/device/boxes.cuh"
#include "cuda/stages/group.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
constexpr unsigned kWarps = kThreads / kWarp;

// A key: the triangle's number in the lowest bits; above, its place on the curve through its body,
// in so many steps for each triangle, behind all of the bodies ahead.
constexpr int kTriangleBits = 27, kStepBits = 10;

__device__ Vec3f receivedAt(const SceneArrays& scene, VertexIndex i) {
  const float* const v = scene.received.row(i);
  return {v[0], v[1], v[2]};
}

// A thread for each vertex, a block for each of scene.vertex_blocks: adds to scene.received_boxes.
__global__ void __launch_bounds__(kThreads) boxKernel(SceneArrays scene) {
  const BodyBlock block = scene.vertex_blocks[Place(blockIdx.x)];
  __shared__ BlockBox box;
  box.clear();
  Aabb own;
  if (threadIdx.x < block.count) {
    const Vec3f v = receivedAt(scene, VertexIndex(block.first + threadIdx.x));
    if (isFinite(v)) own = {v, v};
  }
  box.include(own);
  box.addTo(scene.received_boxes.row(block.body));
}

// A thread for each triangle, a block for each of scene.triangle_blocks: writes scene.curve_keys.
__global__ void __launch_bounds__(kThreads) keyKernel(SceneArrays scene) {
  const BodyBlock block = scene.triangle_blocks[Place(blockIdx.x)];
  if (threadIdx.x >= block.count) return;
  const TriangleIndex t(block.first + threadIdx.x);
  const VertexIndex* const corner = scene.corners.row(t);
  const Vec3f centroid = receivedAt(scene, corner[0]) * (1 / 3.0F) +
                         receivedAt(scene, corner[1]) * (1 / 3.0F) +
                         receivedAt(scene, corner[2]) * (1 / 3.0F);
  const CurveCells cells(boxOf(scene.received_boxes.row(block.body)));
  const std::uint64_t on_curve = cells.placeOf(centroid);
  const DeviceBody& body = scene.bodies[block.body];
  const std::uint64_t step = on_curve * body.triangle_count >> (3 * kCurveBits - kStepBits);
  const std::uint64_t place = (std::uint64_t{body.first_triangle} << kStepBits) + step;
  scene.curve_keys[Place(t.value)] = place << kTriangleBits | t.value;
}

// Of the bodies, whose tiles are numbered through: the one that a tile is of.
__device__ BodyIndex bodyOfTile(const SceneArrays& scene, std::uint32_t tile) {
  std::uint32_t first = 0;
  for (std::uint32_t count = scene.body_count; count > 1;) {
    const std::uint32_t half = count / 2;
    if (scene.bodies[BodyIndex(first + half)].first_tile <= tile) first += half;
    count -= half;
  }
  return BodyIndex(first);
}

// A warp for each tile: from the sorted keys to scene.tile_body and scene.slot_triangle.
__global__ void __launch_bounds__(kThreads)
    fileKernel(SceneArrays scene, const std::uint64_t* sorted) {
  const std::uint32_t tile = blockIdx.x * kWarps + threadIdx.x / kWarp;
  if (tile >= scene.tile_count) return;
  const BodyIndex b = bodyOfTile(scene, tile);
  const DeviceBody& body = scene.bodies[b];
  const std::uint32_t i = (tile - body.first_tile) * kWarp + laneId();
  TriangleIndex triangle(kNone);
  if (i < body.triangle_count) {
    constexpr std::uint64_t kTriangles = (std::uint64_t{1} << kTriangleBits) - 1;
    triangle.value = static_cast<std::uint32_t>(sorted[body.first_triangle + i] & kTriangles);
  }
  scene.slot_triangle[MemberIndex(tile * kWarp + laneId())] = triangle;
  if (laneId() == 0) scene.tile_body[TileIndex(tile)] = b;
}

}  // namespace

void launchGroup(const SceneArrays& scene, DeviceBuffer<unsigned char>& scratch,
                 cudaStream_t stream) {
  const std::uint32_t count = scene.triangle_count;
  checkCuda(cudaMemsetAsync(scene.received_boxes.data(), 0,
                            scene.body_count * kSides * sizeof(std::uint32_t), stream),
            "cudaMemsetAsync");
  boxKernel<<<scene.vertex_block_count, kThreads, 0, stream>>>(scene);
  keyKernel<<<scene.triangle_block_count, kThreads, 0, stream>>>(scene);
  int bits = kTriangleBits + kStepBits;
  while (count >> (bits - kTriangleBits - kStepBits) != 0) ++bits;
  cub::DoubleBuffer<std::uint64_t> keys(scene.curve_keys.data(), scene.sorted_keys.data());
  const auto sort = [&](void* memory, std::size_t& bytes) {
    checkCuda(cub::DeviceRadixSort::SortKeys(memory, bytes, keys, static_cast<int>(count),
                                             kTriangleBits, bits, stream),
              "cub::DeviceRadixSort");
  };
  std::size_t bytes = 0;
  sort(nullptr, bytes);
  if (bytes > scratch.size()) scratch.grow(2 * bytes);
  sort(scratch.data(), bytes);
  fileKernel<<<(scene.tile_count + kWarps - 1) / kWarps, kThreads, 0, stream>>>(scene,
                                                                                keys.Current());
  checkCuda(cudaGetLastError(), "a kernel of the tiles");
}

}  // namespace deformable_contact_monitor
