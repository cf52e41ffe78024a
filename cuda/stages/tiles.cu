// Makes the tiles before a cycle: groups of up to 32 triangles of a body that lie close to each
// other. Tiles are made when a scene is laid out, and now and then anew, because bodies deform.
// Triangles are first sorted along a space-filling curve. Each 2048 consecutive ones are then
// halved again and again, because tiles cut directly from the curve overlap more.
#include <cub/device/device_radix_sort.cuh>

#include "core/rules/space_curve.h"
#include "cuda/device/bitonic_sort.cuh"
#include "cuda/device/boxes.cuh"
#include "cuda/stages/tile_halving.cuh"
#include "cuda/stages/tiles.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;

// A key has the triangle's number in its lowest bits. Above are its body and its place on the curve
// through its body, with 2^kStepBits steps for each triangle.
constexpr int kTriangleBits = 27, kStepBits = 7;

__device__ TriangleIndex triangleOf(std::uint64_t key) {
  return TriangleIndex(static_cast<std::uint32_t>(key) & ((1U << kTriangleBits) - 1));
}

__device__ Vec3f receivedAt(const SceneArrays& scene, VertexIndex i) {
  const float* const v = scene.received.row(i);
  return {v[0], v[1], v[2]};
}

// Returns the centroid of a triangle as received. It is not finite if a vertex is not.
__device__ Vec3f centroidOf(const SceneArrays& scene, TriangleIndex t) {
  const VertexIndex* const corner = scene.corners.row(t);
  constexpr float kThird = 1 / 3.0F;  // applied to each vertex, because their sum may overflow
  return receivedAt(scene, corner[0]) * kThird + receivedAt(scene, corner[1]) * kThird +
         receivedAt(scene, corner[2]) * kThird;
}

struct Stretch {
  float low, high;
};

constexpr unsigned kRangeThreads = 512, kMostSampled = 2 * kRangeThreads;

// Returns the range along an axis that holds seven eighths of a body's vertices, estimated from up
// to kMostSampled of them. `key`: shared memory for the sort. Called by a whole block.
__device__ Stretch stretchOfMost(const SceneArrays& scene, const DeviceBody& body, int axis,
                                 std::uint32_t* key) {
  const std::uint32_t every = body.vertex_count / kMostSampled + 1;
  unsigned finite = 0;
  for (unsigned place = threadIdx.x; place < kMostSampled; place += kRangeThreads) {
    const std::uint32_t i = place * every;
    const bool there = i < body.vertex_count;
    const float x = there ? receivedAt(scene, VertexIndex(body.first_vertex + i))[axis] : INFINITY;
    const bool counts = fabsf(x) < INFINITY;
    key[place] = counts ? orderedBits(x) : ~std::uint32_t{0};
    finite += static_cast<unsigned>(__syncthreads_count(counts ? 1 : 0));
  }
  bitonicSort(key, kMostSampled, kMostSampled);
  Stretch most{0, 0};
  if (finite > 0) {
    const unsigned few = finite / 16;
    most.low = fromOrderedBits(key[few]);
    most.high = fromOrderedBits(key[finite - 1 - few]);
  }
  __syncthreads();
  return most;
}

// One block for each body from `first` on: writes scene.body_ranges. Vertices outside the range are
// ignored by the curve: a single far-off vertex would leave only few cells for all others.
__global__ void __launch_bounds__(kRangeThreads) rangeKernel(SceneArrays scene, BodyIndex first) {
  __shared__ std::uint32_t key[kMostSampled];
  const BodyIndex b(first.value + blockIdx.x);
  const DeviceBody& body = scene.bodies[b];
  if (body.triangle_count <= TileHalving::kMost) return;  // it needs no curve
  const Stretch x = stretchOfMost(scene, body, 0, key);
  const Stretch y = stretchOfMost(scene, body, 1, key);
  const Stretch z = stretchOfMost(scene, body, 2, key);
  const float more = fmaxf(x.high - x.low, fmaxf(y.high - y.low, z.high - z.low));
  if (threadIdx.x != 0) return;
  scene.body_ranges[b] = {{x.low - more, y.low - more, z.low - more},
                          {x.high + more, y.high + more, z.high + more}};
}

// One thread for each vertex, one block for each of scene.vertex_blocks: adds vertices within the
// range to scene.body_boxes, in which the curve runs.
__global__ void __launch_bounds__(kThreads) boxKernel(SceneArrays scene, BodyIndex first) {
  const BodyBlock block = scene.vertex_blocks[Place(blockIdx.x)];
  if (block.body < first) return;
  if (scene.bodies[block.body].triangle_count <= TileHalving::kMost) return;
  __shared__ BlockBox box;
  box.clear();
  Aabb own;
  if (threadIdx.x < block.count) {
    const Vec3f v = receivedAt(scene, VertexIndex(block.first + threadIdx.x));
    if (intersects({v, v}, scene.body_ranges[block.body])) own = {v, v};
  }
  box.include(own);
  box.addTo(scene.body_boxes.row(block.body));
}

// One thread for each triangle, one block for each of scene.triangle_blocks: writes
// scene.curve_keys.
__global__ void __launch_bounds__(kThreads) keyKernel(SceneArrays scene, BodyIndex first) {
  const BodyBlock block = scene.triangle_blocks[Place(blockIdx.x)];
  if (block.body < first || threadIdx.x >= block.count) return;
  const TriangleIndex t(block.first + threadIdx.x);
  const CurveCells cells(boxOf(scene.body_boxes.row(block.body)));
  const std::uint64_t on_curve = cells.placeOf(centroidOf(scene, t));
  const DeviceBody& body = scene.bodies[block.body];
  const std::uint64_t step = on_curve * body.triangle_count >> (3 * kCurveBits - kStepBits);
  const std::uint64_t place = (std::uint64_t{body.first_triangle} << kStepBits) + step;
  scene.curve_keys[Place(t.value)] = place << kTriangleBits | t.value;
}

// The most tiles that one block makes. The triangles of these tiles are a chunk of a body; chunks
// are numbered through all bodies.
constexpr unsigned kChunkTiles = TileHalving::kMost / kWarp;

__device__ std::uint32_t firstChunk(const SceneArrays& scene, std::uint32_t body) {
  return scene.bodies[BodyIndex(body)].first_tile / kChunkTiles + body;
}
__device__ BodyIndex bodyOfChunk(const SceneArrays& scene, std::uint32_t chunk) {
  std::uint32_t first = 0;
  for (std::uint32_t count = scene.body_count; count > 1;) {
    const std::uint32_t half = count / 2;
    if (firstChunk(scene, first + half) <= chunk) first += half;
    count -= half;
  }
  return BodyIndex(first);
}

// One block for each chunk from `first_chunk` on: writes scene.tile_body and scene.slot_triangle.
// `sorted`: the sorted keys from triangle `first_triangle` on; null if all bodies have one chunk
// only.
__global__ void __launch_bounds__(TileHalving::kThreads)
    tileKernel(SceneArrays scene, std::uint32_t first_chunk, const std::uint64_t* sorted,
               std::uint32_t first_triangle) {
  __shared__ TileHalving halving;
  const std::uint32_t number = first_chunk + blockIdx.x;
  const BodyIndex b = bodyOfChunk(scene, number);
  const DeviceBody& body = scene.bodies[b];
  const std::uint32_t chunk = number - firstChunk(scene, b.value);
  const std::uint32_t first = chunk * TileHalving::kMost;  // its first triangle, along the curve
  if (first >= body.triangle_count) return;
  const std::uint32_t count = min(body.triangle_count - first, TileHalving::kMost);
  const auto triangleAt = [&](std::uint32_t i) {
    const std::uint32_t place = body.first_triangle + first + i;
    return sorted == nullptr ? TriangleIndex(place) : triangleOf(sorted[place - first_triangle]);
  };
  for (std::uint32_t i = threadIdx.x; i < count; i += TileHalving::kThreads) {
    halving.put(i, centroidOf(scene, triangleAt(i)));
  }
  halving.halve(count);
  const std::uint32_t first_tile = body.first_tile + chunk * kChunkTiles;
  const std::uint32_t slots = (count + kWarp - 1) / kWarp * kWarp;
  for (std::uint32_t slot = threadIdx.x; slot < slots; slot += TileHalving::kThreads) {
    const std::uint32_t i = halving.triangleAt(slot);
    const TriangleIndex triangle = i < count ? triangleAt(i) : TriangleIndex(kNone);
    scene.slot_triangle[TileEntryIndex(first_tile * kWarp + slot)] = triangle;
    if (slot % kWarp == 0) scene.tile_body[TileIndex(first_tile + slot / kWarp)] = b;
  }
}

// Computes the keys of these bodies and sorts them. Returns the one of the two key arrays that has
// the result.
const std::uint64_t* sortAlongCurves(const SceneArrays& scene, const UntiledBodies& bodies,
                                     DeviceBuffer<unsigned char>& scratch, cudaStream_t stream) {
  checkCuda(cudaMemsetAsync(scene.body_boxes.data(), 0,
                            scene.body_count * kSides * sizeof(std::uint32_t), stream),
            "cudaMemsetAsync");
  const BodyIndex first = bodies.first;
  rangeKernel<<<scene.body_count - first.value, kRangeThreads, 0, stream>>>(scene, first);
  boxKernel<<<scene.vertex_block_count, kThreads, 0, stream>>>(scene, first);
  keyKernel<<<scene.triangle_block_count, kThreads, 0, stream>>>(scene, first);
  int bits = kTriangleBits + kStepBits;
  while (scene.triangle_count >> (bits - kTriangleBits - kStepBits) != 0) ++bits;
  cub::DoubleBuffer<std::uint64_t> keys(scene.curve_keys.data() + bodies.first_triangle,
                                        scene.sorted_keys.data() + bodies.first_triangle);
  const auto count = static_cast<int>(scene.triangle_count - bodies.first_triangle);
  const auto sort = [&](void* memory, std::size_t& bytes) {
    checkCuda(
        cub::DeviceRadixSort::SortKeys(memory, bytes, keys, count, kTriangleBits, bits, stream),
        "cub::DeviceRadixSort");
  };
  std::size_t bytes = 0;
  sort(nullptr, bytes);
  if (bytes > scratch.size()) scratch.grow(2 * bytes, stream);
  sort(scratch.data(), bytes);
  return keys.Current();
}

}  // namespace

void launchTiles(const SceneArrays& scene, const UntiledBodies& bodies,
                 DeviceBuffer<unsigned char>& scratch, cudaStream_t stream) {
  if (bodies.first_triangle == scene.triangle_count) return;
  const std::uint64_t* sorted = nullptr;
  if (bodies.most_triangles > TileHalving::kMost) {
    sorted = sortAlongCurves(scene, bodies, scratch, stream);
  }
  const std::uint32_t first_chunk = bodies.first_tile / kChunkTiles + bodies.first.value;
  const std::uint32_t chunks = scene.tile_count / kChunkTiles + scene.body_count;
  tileKernel<<<chunks - first_chunk, TileHalving::kThreads, 0, stream>>>(scene, first_chunk, sorted,
                                                                         bodies.first_triangle);
  checkCuda(cudaGetLastError(), "a kernel of the tiles");
}

}  // namespace deformable_contact_monitor
