// Stage nearest: finds the nearest triangles of two bodies by branch and bound over tiles.
//
// The tiles of a body are bounded by boxes, and 32 consecutive tiles by the box of their region.
// One kernel compares the boxes of regions, and where these are near, those of their tiles. The
// next one compares the triangles of near tiles, computes the distances of those that boxes cannot
// tell apart, and keeps the best pair so far, from which every comparison prunes. The last cycle's
// nearest triangles give the first bound; without them, single vertices of tiles do.
//
// The best pair is one number of 64 bits: the distance, then triangle a, so that atomicMin() keeps
// the nearest pair with the least a. The last kernel finds the least triangle b that is as near.
#include <algorithm>

#include "core/rules/geometry_of_pair.h"
#include "cuda/device/launch.cuh"
#include "cuda/stages/cut_off.cuh"
#include "cuda/stages/nearest.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kBoundThreads = 256, kTaskThreads = 128, kPairThreads = 128;
constexpr unsigned kBoundPairs = kBoundThreads / kLanesEach;

// Sets the first bound of a pair of bodies: the margin, or the distance of the last cycle's nearest
// triangles. These may be of other bodies by now; any two triangles that count give a bound.
// Called by a whole warp, with one pair for each half of it; kNone: none.
__device__ void setFirstBound(const CycleArrays& c, std::uint32_t pair) {
  const bool is_pair = pair != kNone;
  const NearestBodies bodies = c.nearest.pairs[Place(is_pair ? pair : 0)];
  const DeviceBody &a = c.scene.bodies[bodies.a], &b = c.scene.bodies[bodies.b];
  const uint2 last = c.nearest.last[Place(is_pair ? pair : 0)];
  const bool in_range = last.x != 0 && last.x <= a.triangle_count && last.y <= b.triangle_count;
  const TriangleIndex of_a(a.first_triangle + (in_range ? last.x - 1 : 0));
  const TriangleIndex of_b(b.first_triangle + (in_range ? last.y - 1 : 0));
  const Triangle hull_a = posedTriangle(c.scene, of_a), hull_b = posedTriangle(c.scene, of_b);
  bool counts = is_pair && in_range && isFinite(hull_a) && isFinite(hull_b);
  if (counts && c.params().parts != 0) {
    counts = partsCount(c, pair, c.scene.part[of_a], c.scene.part[of_b]);
  }
  const float distance_m = distanceBetween(hull_a, hull_b, counts);
  if (!is_pair || laneId() % kLanesEach != 0) return;
  Key key = keyOf(bodies.margin_m, kNone);
  if (distance_m <= bodies.margin_m) {
    key = keyOf(distance_m, of_a.value);
    addHit(c, pair, key, of_b);
  }
  c.nearest.best[Place(pair)] = key;
}

// One block for each of nearest.regions: writes the bounds of its tiles and its own box. Further
// blocks have half a warp for each of nearest.pairs, and set the first bounds.
__global__ void __launch_bounds__(kBoundThreads) boundKernel(CycleArrays c) {
  letNextKernelStart();  // the previous kernel has ended, for this launch is a plain one
  if (blockIdx.x >= c.nearest.region_count) {
    const std::uint32_t first = (blockIdx.x - c.nearest.region_count) * kBoundPairs;
    const std::uint32_t pair = first + threadIdx.x / kLanesEach;
    setFirstBound(c, pair < c.nearest.pair_count ? pair : kNone);
    return;
  }
  __shared__ BlockBox whole;
  whole.clear();
  const TileRegion region = c.nearest.regions[Place(blockIdx.x)];
  Aabb all;
  for (std::uint32_t i = threadIdx.x / kWarp; i < region.tile_count; i += kBoundThreads / kWarp) {
    const TileIndex tile(region.first_tile.value + i);
    const uint4 numbers = c.scene.slot_numbers[TileEntryIndex(tile.value * kWarp + laneId())];
    const TriangleIndex t(numbers.w);
    const bool there = t.value != kNone;
    const Triangle hull = posedTriangle(c.scene, numbers);
    bool finite = there && isFinite(hull);
    const bool has_parts = c.params().parts != 0;
    const std::uint32_t part = finite && has_parts ? c.scene.part[t] : kNone;
    if (has_parts) finite = part != kNone;
    const unsigned mask = __ballot_sync(kFullWarp, finite);
    const Aabb box = warpBox(finite ? boxOf(hull) : Aabb());
    const Vec3f point = laneVector(hull.v[0], max(__ffs(static_cast<int>(mask)) - 1, 0));
    const std::uint32_t least = ~warpMost(finite ? ~t.value : 0);
    if (laneId() == 0) c.nearest.tiles[tile] = {box, point, least};
    if (has_parts) {
      const std::uint32_t first =
          __shfl_sync(kFullWarp, part, max(__ffs(static_cast<int>(mask)) - 1, 0));
      const bool one = __all_sync(kFullWarp, !finite || part == first) != 0;
      if (laneId() == 0) c.nearest.tile_parts[tile] = one ? first : kNone;
    }
    if (mask != 0) all.include(box);
  }
  whole.include(all);
  if (threadIdx.x == 0) c.nearest.region_boxes[Place(blockIdx.x)] = whole.get();
}

// Returns which pair of bodies a task belongs to.
__device__ std::uint32_t pairOfTask(const NearestArrays& nearest, std::uint32_t task) {
  std::uint32_t first = 0, count = nearest.pair_count;
  while (count > 1) {
    const std::uint32_t half = count / 2;
    if (nearest.pairs[Place(first + half)].first_task <= task) first += half;
    count -= half;
  }
  return first;
}

// Lowers the bound of a pair of bodies to the least distance of points of two regions' tiles, where
// no triangles have given a bound yet. Called by a whole warp.
__device__ void boundByPoints(const CycleArrays& c, std::uint32_t pair, const TileRegion& b,
                              bool counts, TileIndex tile, const TileBound& own) {
  float least_m = INFINITY;
  const bool has_parts = c.params().parts != 0;
  for (std::uint32_t j = 0; j < b.tile_count; ++j) {
    const TileIndex of_b(b.first_tile.value + j);
    const TileBound& other = c.nearest.tiles[of_b];
    // The points of tiles of several parts may be of parts that do not count.
    if (has_parts && !partsCount(c, pair, c.nearest.tile_parts[tile], c.nearest.tile_parts[of_b])) {
      continue;
    }
    if (other.least != kNone) least_m = fminf(least_m, upperGap(own.point, other.point));
  }
  const std::uint32_t bits = ~warpMost(counts ? ~__float_as_uint(least_m) : 0);
  if (laneId() == 0 && bits < __float_as_uint(INFINITY)) {
    atomicMin(&c.nearest.best[Place(pair)], keyOf(__uint_as_float(bits), kNone));
  }
}

// One warp for each task, a pair of regions: lists the pairs of their tiles that may be nearest. If
// the list is full, it searches them itself.
__global__ void __launch_bounds__(kTaskThreads) tilesKernel(CycleArrays c) {
  awaitPreviousKernel();
  letNextKernelStart();
  __shared__ std::uint16_t queue[kTaskThreads / kWarp][TilePairSearch::kRoom];
  const std::uint32_t warps = gridDim.x * (kTaskThreads / kWarp);
  const std::uint32_t warp = (blockIdx.x * kTaskThreads + threadIdx.x) / kWarp;
  TilePairSearch search(c, queue[threadIdx.x / kWarp]);
  bool is_list_full = false;  // A full list is left alone, so that its counter cannot wrap.
  for (std::uint32_t task = warp; task < c.nearest.task_count; task += warps) {
    if (warpIsCutOff(c, warp % kWarpsPerAsker == 0)) {
      c.counters().nearest_cut_off = 1;
      break;
    }
    const std::uint32_t pair = pairOfTask(c.nearest, task);
    const NearestBodies bodies = c.nearest.pairs[Place(pair)];
    const std::uint32_t i = task - bodies.first_task;
    const Place of_a(bodies.first_region_a + i / bodies.regions_b);
    const Place of_b(bodies.first_region_b + i % bodies.regions_b);
    const Aabb box_a = c.nearest.region_boxes[of_a], box_b = c.nearest.region_boxes[of_b];
    Key key = sameInWarp(bestOf(c, pair));
    if (box_a.empty() || box_b.empty() || lowerGap(box_a, box_b) > distanceOf(key)) continue;
    const TileRegion a = c.nearest.regions[of_a], b = c.nearest.regions[of_b];
    const TileIndex tile(a.first_tile.value + min(laneId(), a.tile_count - 1));
    const TileBound own = c.nearest.tiles[tile];
    const bool counts = laneId() < a.tile_count && own.least != kNone;
    if (triangleOf(key) == kNone) {
      boundByPoints(c, pair, b, counts, tile, own);
      key = sameInWarp(bestOf(c, pair));
    }
    for (std::uint32_t j = 0; j < b.tile_count; ++j) {
      const TileIndex other(b.first_tile.value + j);
      const TileBound& bound = c.nearest.tiles[other];
      bool near =
          counts && bound.least != kNone && keyOf(lowerGap(own.box, bound.box), own.least) <= key;
      if (near && c.params().parts != 0) {
        near = tilesMayCount(c, pair, c.nearest.tile_parts[tile], c.nearest.tile_parts[other]);
      }
      bool listed = false;
      if (!is_list_full) {
        const std::uint32_t place = warpReserve(&c.counters().near_tiles, near);
        listed = near && place < c.nearest.near_tiles.size();
        if (listed) c.nearest.near_tiles[Place(place)] = {pair, tile, other};
        is_list_full = __any_sync(kFullWarp, near && !listed) != 0;
      }
      unsigned full = __ballot_sync(kFullWarp, near && !listed);
      for (; full != 0; full &= full - 1) {
        if (warpIsCutOff(c, warp % kWarpsPerAsker == 0)) {
          c.counters().nearest_cut_off = 1;
          return;
        }
        const std::uint32_t lane = __ffs(static_cast<int>(full)) - 1;
        search.run({pair, TileIndex(a.first_tile.value + lane), other});
        key = bestOf(c, pair);
      }
    }
  }
}

// Searches nearest.near_tiles. Distances take long, so several warps share two tiles where warps
// are left: each one takes some of the triangles of tile b.
__global__ void __launch_bounds__(kTaskThreads) trianglesKernel(CycleArrays c) {
  awaitPreviousKernel();
  letNextKernelStart();
  __shared__ std::uint16_t queue[kTaskThreads / kWarp][TilePairSearch::kRoom];
  const std::uint32_t warps = gridDim.x * (kTaskThreads / kWarp);
  const std::uint32_t warp = (blockIdx.x * kTaskThreads + threadIdx.x) / kWarp;
  const std::uint32_t count = min(c.counters().near_tiles, c.nearest.near_tiles.size());
  std::uint32_t sharers = 1;  // of two tiles, a power of 2
  while (sharers < kWarp && sharers * count <= warps) sharers *= 2;
  const std::uint32_t each = kWarp / sharers;
  TilePairSearch search(c, queue[threadIdx.x / kWarp]);
  for (std::uint32_t i = warp; i < count * sharers; i += warps) {
    if (warpIsCutOff(c, warp % kWarpsPerAsker == 0)) {
      c.counters().nearest_cut_off = 1;
      break;
    }
    search.run(c.nearest.near_tiles[Place(i / sharers)], kFullWarp >> (kWarp - each)
                                                                          << (i % sharers * each));
  }
}

// Finds the least triangle of body b at the best distance from one triangle of a, among the regions
// of this warp. Called by a whole warp; `least` is in shared memory.
__device__ void findPartner(const CycleArrays& c, std::uint32_t pair, TriangleIndex of_a,
                            float distance_m, std::uint32_t warp, std::uint32_t warps,
                            std::uint32_t* least) {
  const NearestBodies& bodies = c.nearest.pairs[Place(pair)];
  const Triangle a = posedTriangle(c.scene, of_a);
  const std::uint32_t part_a = c.params().parts != 0 ? c.scene.part[of_a] : kNone;
  const Aabb box = boxOf(a);
  const auto isNear = [&](const Aabb& other) { return lowerGap(box, other) <= distance_m; };
  for (std::uint32_t first = warp * kWarp; first < bodies.regions_b; first += warps * kWarp) {
    const std::uint32_t own = first + laneId();
    const bool in_reach = own < bodies.regions_b;
    const Aabb region_box =
        in_reach ? c.nearest.region_boxes[Place(bodies.first_region_b + own)] : Aabb();
    unsigned regions =
        __ballot_sync(kFullWarp, in_reach && !region_box.empty() && isNear(region_box));
    for (; regions != 0; regions &= regions - 1) {
      const std::uint32_t r = first + __ffs(static_cast<int>(regions)) - 1;
      const TileRegion region = c.nearest.regions[Place(bodies.first_region_b + r)];
      bool near = false;
      if (laneId() < region.tile_count) {
        const TileBound& tile = c.nearest.tiles[TileIndex(region.first_tile.value + laneId())];
        near = tile.least != kNone && isNear(tile.box);
      }
      for (unsigned tiles = __ballot_sync(kFullWarp, near); tiles != 0; tiles &= tiles - 1) {
        const std::uint32_t tile = region.first_tile.value + __ffs(static_cast<int>(tiles)) - 1;
        for (unsigned lane = 0; lane < kWarp;
             lane += 2) {  // one triangle for each half of the warp
          const uint4 numbers =
              c.scene.slot_numbers[TileEntryIndex(tile * kWarp + lane + laneId() / kLanesEach)];
          const TriangleIndex t(numbers.w);
          const bool there = t.value != kNone;
          const Triangle b = posedTriangle(c.scene, numbers);
          bool counts = there && isFinite(b) && isNear(boxOf(b));
          if (counts && c.params().parts != 0) {
            counts = partsCount(c, pair, part_a, c.scene.part[t]);
          }
          if (__any_sync(kFullWarp, counts) == 0) continue;
          if (distanceBetween(a, b, counts) == distance_m) atomicMin(least, t.value);
        }
      }
    }
  }
}

// Lowers `least`, in shared memory, to the least triangle of body b in the hits of a pair with that
// key. Called by a whole block.
__device__ void partnerInHits(const CycleArrays& c, Place pair, Key key, std::uint32_t* least) {
  const std::uint32_t count = min(c.counters().nearest_hits, c.nearest.hits.size());
  for (std::uint32_t i = threadIdx.x; i < count; i += kPairThreads) {
    const NearestHit hit = c.nearest.hits[Place(i)];
    if (hit.key == key && hit.pair == pair.value) atomicMin(least, hit.triangle_b);
  }
}

// One block for each of nearest.pairs: writes its result to the host's memory, and keeps its
// triangles for the next cycle.
__global__ void __launch_bounds__(kPairThreads) resultKernel(CycleArrays c) {
  awaitPreviousKernel();
  __shared__ std::uint32_t least;
  if (threadIdx.x == 0) least = kNone;
  __syncthreads();
  const Place pair(blockIdx.x);
  const NearestBodies bodies = c.nearest.pairs[pair];
  const Key key = c.nearest.best[pair];
  const bool cut_off = c.counters().nearest_cut_off != 0;
  const TriangleIndex t(triangleOf(key));
  const bool found = t.value != kNone && !cut_off;
  // Each pair reads all hits. Where both are many, it takes less to search its own regions.
  constexpr std::uint64_t kMostReads = 1U << 24;
  const std::uint32_t hits = c.counters().nearest_hits;
  if (found && hits <= c.nearest.hits.size() && std::uint64_t{hits} * gridDim.x <= kMostReads) {
    partnerInHits(c, pair, key, &least);
  } else if (found) {
    findPartner(c, pair.value, t, distanceOf(key), threadIdx.x / kWarp, kPairThreads / kWarp,
                &least);
  }
  __syncthreads();
  if (threadIdx.x != 0) return;
  NearestFound result{};
  result.state = cut_off ? NearestFound::kCutOff : NearestFound::kBeyond;
  if (found) {
    result.state = NearestFound::kFound;
    result.triangle_a = t.value - c.scene.bodies[bodies.a].first_triangle;
    result.triangle_b = least - c.scene.bodies[bodies.b].first_triangle;
    result.distance_m = distanceOf(key);
    c.nearest.last[pair] = {result.triangle_a + 1, result.triangle_b + 1};
  }
  NearestFound& to = c.nearest.found.onHost()[pair.value];
  to = result;
  if (!found || bodies.points_on_device == 0) return;
  const PairGeometry geometry = generalGeometryOf(
      posedTriangle(c.scene, t), posedTriangle(c.scene, TriangleIndex(least)), result.distance_m);
  to.point_a = geometry.point_a;
  to.point_b = result.distance_m > 0 ? geometry.point_b : geometry.point_a;
  if (result.distance_m > 0) to.normal = geometry.normal;
}

}  // namespace

void launchNearest(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  const NearestArrays& nearest = cycle.nearest;
  if (nearest.pair_count == 0) return;
  constexpr unsigned kWarps = kTaskThreads / kWarp, kMostBlocksEach = 16;
  const unsigned pair_blocks = (nearest.pair_count + kBoundPairs - 1) / kBoundPairs;
  boundKernel<<<nearest.region_count + pair_blocks, kBoundThreads, 0, stream>>>(cycle);
  const unsigned task_blocks = std::min((nearest.task_count + kWarps - 1) / kWarps,
                                        kMostBlocksEach * shape.device.multiprocessors);
  launchDependent(tilesKernel, task_blocks, kTaskThreads, 0, shape.device, stream, cycle);
  launchDependent(trianglesKernel, 8 * shape.device.multiprocessors, kTaskThreads, 0, shape.device,
                  stream, cycle);
  launchDependent(resultKernel, nearest.pair_count, kPairThreads, 0, shape.device, stream, cycle);
}

}  // namespace deformable_contact_monitor
