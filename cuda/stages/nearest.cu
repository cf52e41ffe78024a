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
#include <cfloat>

#include "core/predicates/triangle_distance.h"
#include "core/predicates/triangle_intersection.h"
#include "core/rules/geometry_of_pair.h"
#include "core/rules/nearest.h"
#include "cuda/device/boxes.cuh"
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/corners.cuh"
#include "cuda/stages/cut_off.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

using Key = unsigned long long;

constexpr unsigned kBoundThreads = 256, kTaskThreads = 128, kPairThreads = 128;

// Returns the key of a pair of triangles, or of the pairs of a tile with that least triangle.
__device__ Key keyOf(float distance_m, std::uint32_t triangle_a) {
  return Key{__float_as_uint(distance_m)} << 32 | triangle_a;
}
__device__ float distanceOf(Key key) {
  return __uint_as_float(static_cast<std::uint32_t>(key >> 32));
}
__device__ std::uint32_t triangleOf(Key key) { return static_cast<std::uint32_t>(key); }

__device__ Key bestOf(const CycleArrays& c, std::uint32_t pair) {
  return static_cast<volatile Key&>(c.nearest.best[Place(pair)]);
}

// Returns a lower bound of the distance of two boxes that are not empty [m]. It is less than the
// true one by more than what comparedDistance() may round down. Squares of lengths near the ends of
// the range of float32 could overflow or vanish; there the greatest gap along an axis is the bound.
__device__ float lowerGap(const Aabb& a, const Aabb& b) {
  constexpr float kRounding = 1 - 0x1p-21F, kLeast = 1e-15F, kMost = 1e15F;
  const float x = fmaxf(fmaxf(b.min.x - a.max.x, a.min.x - b.max.x), 0.0F);
  const float y = fmaxf(fmaxf(b.min.y - a.max.y, a.min.y - b.max.y), 0.0F);
  const float z = fmaxf(fmaxf(b.min.z - a.max.z, a.min.z - b.max.z), 0.0F);
  const float most = fmaxf(x, fmaxf(y, z));
  if (!(most > kLeast && most < kMost)) return fminf(most, FLT_MAX) * kRounding;
  return sqrtf(x * x + y * y + z * z) * kRounding;
}

// Returns the least distance by which triangles in these boxes may be compared [m]. It is sharper
// than lowerGap(), so that among triangles that are equally near the key decides.
__device__ float leastCompared(const Aabb& a, const Aabb& b) {
  constexpr double kRounding = 1 - 0x1p-27;  // separation() is right to 2^-28 of itself
  const double gap = sqrt(squaredGap(a, b)) * kRounding;
  return gap > 0 ? comparedDistance(gap) : 0;
}

// Returns an upper bound of the distance between bodies with these two points [m].
__device__ float upperGap(const Vec3f& a, const Vec3f& b) {
  const Vec3d way = toDouble(b) - toDouble(a);
  const double most = sqrt(dot(way, way)) * (1 + 1e-6) + 0x1p-149;
  return most < FLT_MAX ? toFloat(most) : FLT_MAX;
}

// Returns whether two triangles intersect, which they do only if their boxes do.
__device__ __noinline__ bool meet(const Triangle& a, const Triangle& b) {
  PredicateState state;
  return intersects(boxOf(a), boxOf(b)) && trianglesIntersect(a, b, state);
}

constexpr unsigned kLanesEach = 16;  // that compute one distance
constexpr unsigned kBoundPairs = kBoundThreads / kLanesEach;
static_assert(detail::kFeatures <= kLanesEach);

// Returns the distance by which pairs are compared [m]; infinity unless the pair `counts`. Half a
// warp computes it together, because one lane alone takes several times as long; its lanes give the
// same triangles. Called by a whole warp.
__device__ float distanceBetween(const Triangle& a, const Triangle& b, bool counts) {
  const bool swap = detail::precedes(b, a);
  const int feature = static_cast<int>(laneId() % kLanesEach);
  double least2 = counts && feature < detail::kFeatures
                      ? detail::squaredFeatureDistance(swap ? b : a, swap ? a : b, feature)
                      : INFINITY;
  for (unsigned o = kLanesEach / 2; o > 0; o /= 2) {
    least2 = least(least2, __shfl_xor_sync(kFullWarp, least2, o));
  }
  bool intersect = counts && feature == 0 && meet(a, b);
  intersect = (__ballot_sync(kFullWarp, intersect) >> (laneId() & kLanesEach) & 1) != 0;
  if (intersect) return 0;
  return counts ? comparedDistance(sqrt(least2)) : INFINITY;
}

// Notes a pair of triangles that is as near as the best one so far.
__device__ void addHit(const CycleArrays& c, std::uint32_t pair, Key key, TriangleIndex b) {
  const std::uint32_t place = atomicAdd(&c.counters().nearest_hits, 1U);
  if (place < c.nearest.hits.size()) c.nearest.hits[Place(place)] = {key, pair, b.value};
}

// Sets the first bound of a pair of bodies: the margin, or the distance of the last cycle's nearest
// triangles. These may be of other bodies by now; any two triangles of the two bodies give a bound.
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
  const bool counts = is_pair && in_range && isFinite(hull_a) && isFinite(hull_b);
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
    const TriangleIndex t = c.scene.slot_triangle[TileEntryIndex(tile.value * kWarp + laneId())];
    const bool there = t.value != kNone;
    const Triangle hull = posedTriangle(c.scene, there ? t : TriangleIndex(0));
    const bool finite = there && isFinite(hull);
    const unsigned mask = __ballot_sync(kFullWarp, finite);
    const Aabb box = warpBox(finite ? boxOf(hull) : Aabb());
    const Vec3f point = laneVector(hull.v[0], max(__ffs(static_cast<int>(mask)) - 1, 0));
    const std::uint32_t least = ~warpMost(finite ? ~t.value : 0);
    if (laneId() == 0) c.nearest.tiles[tile] = {box, point, least};
    if (mask != 0) all.include(box);
  }
  whole.include(all);
  if (threadIdx.x == 0) c.nearest.region_boxes[Place(blockIdx.x)] = whole.get();
}

// The triangles of two near tiles, one pair of triangles at a time in the lanes of a warp. Pairs
// that boxes leave are collected in shared memory, so that all lanes compute a distance.
class TilePairSearch {
 public:
  static constexpr unsigned kRoom = 2 * kWarp;

  // `queue`: kRoom places in shared memory, of this warp.
  __device__ TilePairSearch(const CycleArrays& c, std::uint16_t* queue) : c_(c), queue_(queue) {}

  // Searches two tiles. Called by a whole warp.
  __device__ void run(const NearTiles& tiles) {
    tiles_ = tiles;
    key_ = bestOf(c_, tiles.pair);
    const TileBound &bound_a = c_.nearest.tiles[tiles.a], &bound_b = c_.nearest.tiles[tiles.b];
    if (keyOf(lowerGap(bound_a.box, bound_b.box), bound_a.least) > key_) return;
    const Side a(c_, tiles.a), b(c_, tiles.b);
    const bool near_a = a.counts && keyOf(lowerGap(a.box, bound_b.box), a.triangle.value) <= key_;
    const bool near_b = b.counts && lowerGap(b.box, bound_a.box) <= distanceOf(key_);
    queued_ = 0;
    for (unsigned left = __ballot_sync(kFullWarp, near_b); left != 0; left &= left - 1) {
      const int j = __ffs(static_cast<int>(left)) - 1;
      const Aabb box{laneVector(b.box.min, j), laneVector(b.box.max, j)};
      add(near_a && keyOf(lowerGap(a.box, box), a.triangle.value) <= key_, j);
      if (queued_ >= kWarp) decide(kWarp);
    }
    if (queued_ > 0) decide(queued_);
  }

 private:
  // One tile, of which each lane has a triangle.
  struct Side {
    TriangleIndex triangle;
    bool counts;
    Aabb box;

    __device__ Side(const CycleArrays& c, TileIndex tile)
        : triangle(c.scene.slot_triangle[TileEntryIndex(tile.value * kWarp + laneId())]) {
      counts = triangle.value != kNone;
      const Triangle hull = posedTriangle(c.scene, counts ? triangle : TriangleIndex(0));
      counts = counts && isFinite(hull);
      box = boxOf(hull);
    }
  };

  // Queues this lane's triangle of a with triangle j of b.
  __device__ void add(bool wanted, int j) {
    const unsigned mask = __ballot_sync(kFullWarp, wanted);
    if (wanted) {
      const unsigned place = queued_ + __popc(mask & ((1U << laneId()) - 1));
      queue_[place] = static_cast<std::uint16_t>(laneId() << 8 | static_cast<unsigned>(j));
    }
    queued_ += __popc(mask);
    __syncwarp();
  }

  // Decides the last `count` <= kWarp queued pairs. Each lane filters one of them by its box and
  // planes. If many are left, each lane computes a distance; else half a warp computes each.
  __device__ void decide(unsigned count) {
    constexpr int kFew = 12;
    queued_ -= count;
    const bool open = laneId() < count && mayBeBest(queued_ + laneId());
    unsigned left = __ballot_sync(kFullWarp, open);
    if (__popc(left) > kFew) {
      if (open) measureAlone(queued_ + laneId());
      left = 0;
    }
    while (left != 0) {
      const unsigned first = __ffs(static_cast<int>(left)) - 1;
      left &= left - 1;
      const bool has_second = left != 0;
      const unsigned second = has_second ? __ffs(static_cast<int>(left)) - 1 : first;
      left &= left - 1;
      const bool is_second = laneId() >= kLanesEach;
      measure(queued_ + (is_second ? second : first), !is_second || has_second);
    }
    __syncwarp();
    key_ = bestOf(c_, tiles_.pair);
  }

  __device__ TriangleIndex queuedA(unsigned place) const {
    return triangleAt(tiles_.a, queue_[place] >> 8);
  }
  __device__ TriangleIndex queuedB(unsigned place) const {
    return triangleAt(tiles_.b, queue_[place] & 0xffU);
  }
  __device__ TriangleIndex triangleAt(TileIndex tile, unsigned lane) const {
    return c_.scene.slot_triangle[TileEntryIndex(tile.value * kWarp + lane)];
  }

  // Returns whether a queued pair may be as near as the best one, by boxes and planes.
  __device__ bool mayBeBest(unsigned place) const {
    const TriangleIndex t = queuedA(place);
    const Triangle a = posedTriangle(c_.scene, t), b = posedTriangle(c_.scene, queuedB(place));
    const double most_m = distanceOf(key_) * (1 + 1e-6) + 0x1p-149;
    return keyOf(leastCompared(boxOf(a), boxOf(b)), t.value) <= key_ &&
           !arePlanesApart(a, b, most_m);
  }

  // Computes the distance of a queued pair, and makes it the best one if it is. Called by a whole
  // warp, with one pair for each half of it.
  __device__ void measure(unsigned place, bool counts) {
    const TriangleIndex t = queuedA(place), u = queuedB(place);
    const float distance_m =
        distanceBetween(posedTriangle(c_.scene, t), posedTriangle(c_.scene, u), counts);
    if (counts && laneId() % kLanesEach == 0) take(keyOf(distance_m, t.value), u);
  }

  // Does the same for a pair of this lane alone.
  __device__ void measureAlone(unsigned place) {
    const TriangleIndex t = queuedA(place), u = queuedB(place);
    const Triangle a = posedTriangle(c_.scene, t), b = posedTriangle(c_.scene, u);
    take(keyOf(meet(a, b) ? 0 : comparedDistance(separation(a, b)), t.value), u);
  }

  __device__ void take(Key key, TriangleIndex b) {
    if (key > bestOf(c_, tiles_.pair)) return;
    atomicMin(&c_.nearest.best[Place(tiles_.pair)], key);
    addHit(c_, tiles_.pair, key, b);
  }

  const CycleArrays& c_;
  std::uint16_t* queue_;
  NearTiles tiles_{};
  Key key_ = 0;
  unsigned queued_ = 0;
};

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
                              bool counts, const TileBound& own) {
  float least_m = INFINITY;
  for (std::uint32_t j = 0; j < b.tile_count; ++j) {
    const TileBound& other = c.nearest.tiles[TileIndex(b.first_tile.value + j)];
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
    Key key = bestOf(c, pair);
    if (box_a.empty() || box_b.empty() || lowerGap(box_a, box_b) > distanceOf(key)) continue;
    const TileRegion a = c.nearest.regions[of_a], b = c.nearest.regions[of_b];
    const TileIndex tile(a.first_tile.value + min(laneId(), a.tile_count - 1));
    const TileBound own = c.nearest.tiles[tile];
    const bool counts = laneId() < a.tile_count && own.least != kNone;
    if (triangleOf(key) == kNone) {
      boundByPoints(c, pair, b, counts, own);
      key = bestOf(c, pair);
    }
    for (std::uint32_t j = 0; j < b.tile_count; ++j) {
      const TileIndex other(b.first_tile.value + j);
      const TileBound& bound = c.nearest.tiles[other];
      const bool near =
          counts && bound.least != kNone && keyOf(lowerGap(own.box, bound.box), own.least) <= key;
      const std::uint32_t place = warpReserve(&c.counters().near_tiles, near);
      const bool listed = near && place < c.nearest.near_tiles.size();
      if (listed) c.nearest.near_tiles[Place(place)] = {pair, tile, other};
      unsigned full = __ballot_sync(kFullWarp, near && !listed);
      for (; full != 0; full &= full - 1) {
        const std::uint32_t lane = __ffs(static_cast<int>(full)) - 1;
        search.run({pair, TileIndex(a.first_tile.value + lane), other});
        key = bestOf(c, pair);
      }
    }
  }
}

// One warp for each of nearest.near_tiles: searches them.
__global__ void __launch_bounds__(kTaskThreads) trianglesKernel(CycleArrays c) {
  awaitPreviousKernel();
  letNextKernelStart();
  __shared__ std::uint16_t queue[kTaskThreads / kWarp][TilePairSearch::kRoom];
  const std::uint32_t warps = gridDim.x * (kTaskThreads / kWarp);
  const std::uint32_t warp = (blockIdx.x * kTaskThreads + threadIdx.x) / kWarp;
  const std::uint32_t count = min(c.counters().near_tiles, c.nearest.near_tiles.size());
  TilePairSearch search(c, queue[threadIdx.x / kWarp]);
  for (std::uint32_t i = warp; i < count; i += warps) {
    if (warpIsCutOff(c, warp % kWarpsPerAsker == 0)) {
      c.counters().nearest_cut_off = 1;
      break;
    }
    search.run(c.nearest.near_tiles[Place(i)]);
  }
}

// Finds the least triangle of body b at the best distance from one triangle of a, among the regions
// of this warp. Called by a whole warp; `least` is in shared memory.
__device__ void findPartner(const CycleArrays& c, const NearestBodies& bodies, const Triangle& a,
                            float distance_m, std::uint32_t warp, std::uint32_t warps,
                            std::uint32_t* least) {
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
          const TriangleIndex t =
              c.scene.slot_triangle[TileEntryIndex(tile * kWarp + lane + laneId() / kLanesEach)];
          const bool there = t.value != kNone;
          const Triangle b = posedTriangle(c.scene, there ? t : TriangleIndex(0));
          const bool counts = there && isFinite(b) && isNear(boxOf(b));
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
  if (found && c.counters().nearest_hits <= c.nearest.hits.size()) {
    partnerInHits(c, pair, key, &least);
  } else if (found) {
    findPartner(c, bodies, posedTriangle(c.scene, t), distanceOf(key), threadIdx.x / kWarp,
                kPairThreads / kWarp, &least);
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
  const PairGeometry geometry = geometryOf(
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
  launchDependent(trianglesKernel, 4 * shape.device.multiprocessors, kTaskThreads, 0, shape.device,
                  stream, cycle);
  launchDependent(resultKernel, nearest.pair_count, kPairThreads, 0, shape.device, stream, cycle);
}

}  // namespace deformable_contact_monitor
