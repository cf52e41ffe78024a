// Makes the tiles before a cycle: groups of up to 32 triangles of a body that lie close to each
// other. Tiles are made when a scene is laid out, and now and then anew, because bodies deform.
// Triangles are first sorted along a space-filling curve. Each 2048 consecutive ones are then
// halved again and again, because tiles cut directly from the curve overlap more.
#include <cstdint>
#include <cub/device/device_radix_sort.cuh>

#include "core/rules/space_curve.h"
#include "core/vector3.h"
#include "cuda/device/boxes.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/tiles.cuh"

namespace deformable_contact_monitor {
namespace {

// Compares the key of this lane with that of the lane `apart` from it, and returns the one that
// this lane keeps. Called by a whole warp.
__device__ inline std::uint32_t exchanged(std::uint32_t key, unsigned apart, bool ascends) {
  const std::uint32_t other = __shfl_xor_sync(kFullWarp, key, apart);
  return ((laneId() & apart) == 0) == ascends ? min(key, other) : max(key, other);
}

// Sorts each `part` of the first `whole` keys in ascending order, by K. Batcher's bitonic sort.
// Both numbers are powers of two, part >= 64. All threads of the block call it with the same
// arguments; the block has at least whole / 2 threads. It synchronises the block before the first
// read and after the last write of the keys. Each lane holds two keys, 32 places apart: a warp
// sorts its 64 places in registers, which is faster than in shared memory.
__device__ inline void bitonicSort(std::uint32_t* key, unsigned whole, unsigned part) {
  const unsigned at = 2 * (threadIdx.x - laneId()) + laneId();
  const bool mine = at < whole;  // the same for all lanes of a warp
  const auto ascends = [part](unsigned run, unsigned i) { return run == part || (i & run) == 0; };
  std::uint32_t low = 0, high = 0;
  const auto load = [&] {
    __syncthreads();
    if (!mine) return;
    low = key[at];
    high = key[at + kWarp];
  };
  const auto store = [&] {
    if (mine) {
      key[at] = low;
      key[at + kWarp] = high;
    }
    __syncthreads();
  };
  load();
  for (unsigned run = 2; run <= part; run *= 2) {
    // Partners that are more than 32 places apart are exchanged in shared memory.
    if (run > 2 * kWarp) {
      store();
      for (unsigned apart = run / 2; apart > kWarp; apart /= 2) {
        const unsigned i = 2 * threadIdx.x - (threadIdx.x & (apart - 1));
        if (i < whole) {
          const std::uint32_t a = key[i], b = key[i + apart];
          if ((a > b) == ascends(run, i)) {
            key[i] = b;
            key[i + apart] = a;
          }
        }
        if (apart > 2 * kWarp) __syncthreads();
      }
      load();
    }
    // Partners that are 32 places apart are the two keys of one lane.
    if (run > kWarp && (low > high) == ascends(run, at)) {
      const std::uint32_t swapped = low;
      low = high;
      high = swapped;
    }
    const bool low_ascends = ascends(run, at), high_ascends = ascends(run, at + kWarp);
#pragma unroll
    for (unsigned apart = kWarp / 2; apart > 0; apart /= 2) {
      if (!mine || apart >= run) continue;
      low = exchanged(low, apart, low_ascends);
      high = exchanged(high, apart, high_ascends);
    }
  }
  store();
}

// Lies in shared memory of a block of kThreads threads, all of which make each call. All sets of
// one size are halved at the same time, by one sort.
struct TileHalving {
  static constexpr unsigned kMost = 2048;  // triangles
  static constexpr unsigned kThreads = kMost / 2;

  // The keys to sort by: the rank of the coordinate, and in the lowest bits the triangle's number.
  std::uint32_t key[kMost];
  float at[3][kMost];  // centroids of the triangles
  std::uint32_t sides[kMost / (2 * kWarp)][kSides];

  // Returns the number of the triangle in a place. Places beyond the number of triangles have
  // numbers beyond it too.
  __device__ std::uint32_t triangleAt(std::uint32_t place) const { return key[place] % kMost; }

  // Sets the centroid of triangle i. A coordinate that is not finite counts as zero, because any
  // tile is right for such a triangle.
  __device__ void put(std::uint32_t i, const Vec3f& centroid) {
    for (int k = 0; k < 3; ++k) at[k][i] = fabsf(centroid[k]) < INFINITY ? centroid[k] : 0;
  }

  // Sorts the first `count` triangles. Every 32 consecutive places then form a tile.
  __device__ void halve(std::uint32_t count) {
    for (unsigned i = threadIdx.x; i < kMost; i += kThreads) key[i] = i;
    unsigned whole = kWarp;
    while (whole < count) whole *= 2;
    for (unsigned part = whole; part > kWarp; part /= 2) {
      __syncthreads();
      rank(count, whole, part);
      bitonicSort(key, whole, part);
    }
    __syncthreads();
  }

 private:
  static constexpr std::uint32_t kRanks = ~std::uint32_t{0} / kMost;  // the last rank: no triangle

  // Returns the position of x in [low, high], as a rank below kRanks.
  __device__ static std::uint32_t rankOf(float x, float low, float high) {
    const float from = low / 2, length = high / 2 - from;  // high - low may overflow
    if (!(length > 0)) return 0;
    constexpr auto kMostRank = static_cast<float>(kRanks - 1);
    return static_cast<std::uint32_t>(fminf((x / 2 - from) / length * kMostRank, kMostRank));
  }

  // Sets the keys to the rank of the coordinate along the longest side of each set; places without
  // a triangle come last.
  __device__ void rank(std::uint32_t count, unsigned whole, unsigned part) {
    for (unsigned i = threadIdx.x; i < whole / part * kSides; i += kThreads) (&sides[0][0])[i] = 0;
    __syncthreads();
    for (unsigned i = threadIdx.x; i < whole; i += kThreads) {  // a warp lies in one set
      const std::uint32_t t = triangleAt(i);
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t bits = orderedBits(at[k][t]);
        const std::uint32_t low = warpMost(t < count ? ~bits : 0);
        const std::uint32_t high = warpMost(t < count ? bits : 0);
        if (laneId() != 0) continue;
        atomicMax(&sides[i / part][k], low);
        atomicMax(&sides[i / part][3 + k], high);
      }
    }
    __syncthreads();
    for (unsigned i = threadIdx.x; i < whole; i += kThreads) {
      const Aabb box = boxOf(sides[i / part]);
      const Vec3f side = box.max - box.min;
      const int k = side.x >= fmaxf(side.y, side.z) ? 0 : side.y >= side.z ? 1 : 2;
      const std::uint32_t t = triangleAt(i);
      const std::uint32_t rank = t < count ? rankOf(at[k][t], box.min[k], box.max[k]) : kRanks;
      key[i] = rank * kMost + t;
    }
  }
};

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

// Writes the numbers of a slot, and which lanes' triangles share a vertex with this lane's by its
// number. `t` is kNone in lanes without a triangle. Called by a whole warp.
__device__ void putNumbers(const SceneArrays& scene, TileEntryIndex at, TriangleIndex t) {
  VertexIndex own[3] = {VertexIndex(kNone), VertexIndex(kNone), VertexIndex(kNone)};
  for (int k = 0; t.value != kNone && k < 3; ++k) own[k] = scene.corners.row(t)[k];
  std::uint32_t neighbours = 0;
  for (unsigned lane = 0; lane < kWarp; ++lane) {
    bool shares = false;
    for (const VertexIndex& corner : own) {
      const std::uint32_t other = __shfl_sync(kFullWarp, corner.value, lane);
      for (const VertexIndex& v : own) shares = shares || v.value == other;
    }
    if (shares) neighbours |= 1U << lane;
  }
  scene.slot_neighbours[at] = neighbours;
  const bool there = t.value != kNone;
  scene.slot_numbers[at] = there ? make_uint4(own[0].value, own[1].value, own[2].value, t.value)
                                 : make_uint4(0, 0, 0, kNone);
}

// One block for each chunk from `first_chunk` on: writes scene.tile_body, scene.slot_numbers and
// scene.slot_neighbours. `sorted`: the sorted keys from triangle `first_triangle` on; null if all
// bodies have one chunk only.
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
    const TileEntryIndex at(first_tile * kWarp + slot);
    putNumbers(scene, at, triangle);
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
