// Parts of stage nearest: how pairs are compared, how their distance is computed, and the search of
// two tiles.
#pragma once

#include <cfloat>
#include <cstdint>

#include "core/predicates/triangle_distance.h"
#include "core/predicates/triangle_intersection.h"
#include "core/rules/nearest.h"
#include "cuda/device/boxes.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/memory/cycle_arrays.cuh"
#include "cuda/stages/corners.cuh"

namespace deformable_contact_monitor {

using Key = unsigned long long;

// Returns the key of a pair of triangles, or of the pairs of a tile with that least triangle.
__device__ inline Key keyOf(float distance_m, std::uint32_t triangle_a) {
  return Key{__float_as_uint(distance_m)} << 32 | triangle_a;
}
__device__ inline float distanceOf(Key key) {
  return __uint_as_float(static_cast<std::uint32_t>(key >> 32));
}
__device__ inline std::uint32_t triangleOf(Key key) { return static_cast<std::uint32_t>(key); }

__device__ inline Key bestOf(const CycleArrays& c, std::uint32_t pair) {
  return static_cast<volatile Key&>(c.nearest.best[Place(pair)]);
}

// Returns whether triangles of these two parts count for a pair of bodies. kNone, a part that takes
// no part, never does. Needed only if CycleParams::parts is set.
__device__ inline bool partsCount(const CycleArrays& c, std::uint32_t pair, std::uint32_t part_a,
                                  std::uint32_t part_b) {
  if (part_a == kNone || part_b == kNone) return false;
  const NearestBodies& bodies = c.nearest.pairs[Place(pair)];
  return (bodies.part_a == kNone || bodies.part_a == part_a) &&
         (bodies.part_b == kNone || bodies.part_b == part_b) && c.scene.pairEnabled(part_a, part_b);
}

// Returns whether some triangles of two tiles may count for a pair of bodies, given by their
// NearestArrays::tile_parts.
__device__ inline bool tilesMayCount(const CycleArrays& c, std::uint32_t pair, std::uint32_t part_a,
                                     std::uint32_t part_b) {
  return part_a == kNone || part_b == kNone || partsCount(c, pair, part_a, part_b);
}

// Returns a lower bound of the distance of two boxes that are not empty [m]. It is less than the
// true one by more than what comparedDistance() may round down. Squares of lengths near the ends of
// the range of float32 could overflow or vanish; there the greatest gap along an axis is the bound.
__device__ inline float lowerGap(const Aabb& a, const Aabb& b) {
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
__device__ inline float leastCompared(const Aabb& a, const Aabb& b) {
  return leastCompared(sqrt(squaredGap(a, b)));
}

// Returns an upper bound of the distance between bodies with these two points [m].
__device__ inline float upperGap(const Vec3f& a, const Vec3f& b) {
  const Vec3d way = toDouble(b) - toDouble(a);
  const double most = sqrt(dot(way, way)) * (1 + 1e-6) + 0x1p-149;
  return most < FLT_MAX ? toFloat(most) : FLT_MAX;
}

// Returns whether two triangles intersect, which they do only if their boxes do.
__device__ __noinline__ inline bool meet(const Triangle& a, const Triangle& b) {
  PredicateState state;
  return intersects(boxOf(a), boxOf(b)) && trianglesIntersect(a, b, state);
}

constexpr unsigned kLanesEach = 16;  // that compute one distance
static_assert(detail::kFeatures <= kLanesEach);

// Returns the distance by which pairs are compared [m]; infinity unless the pair `counts`. Half a
// warp computes it together, because one lane alone takes several times as long; its lanes give the
// same triangles. Called by a whole warp.
__device__ inline float distanceBetween(const Triangle& a, const Triangle& b, bool counts) {
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
__device__ inline void addHit(const CycleArrays& c, std::uint32_t pair, Key key, TriangleIndex b) {
  const std::uint32_t place = reserve(&c.counters().nearest_hits, 1);
  if (place < c.nearest.hits.size()) c.nearest.hits[Place(place)] = {key, pair, b.value};
}

// The triangles of two near tiles, one pair of triangles at a time in the lanes of a warp. Pairs
// that boxes leave are collected in shared memory, so that all lanes compute a distance.
class TilePairSearch {
 public:
  static constexpr unsigned kRoom = 2 * kWarp;

  // `queue`: kRoom places in shared memory, of this warp.
  __device__ TilePairSearch(const CycleArrays& c, std::uint16_t* queue) : c_(c), queue_(queue) {}

  // Searches two tiles, of the second one the triangles in `lanes_of_b`. Called by a whole warp.
  __device__ void run(const NearTiles& tiles, unsigned lanes_of_b = kFullWarp) {
    tiles_ = tiles;
    key_ = sameInWarp(bestOf(c_, tiles.pair));
    const TileBound &bound_a = c_.nearest.tiles[tiles.a], &bound_b = c_.nearest.tiles[tiles.b];
    if (keyOf(lowerGap(bound_a.box, bound_b.box), bound_a.least) > key_) return;
    const Side a(c_, tiles.a), b(c_, tiles.b);
    const bool has_parts = c_.params().parts != 0;
    const bool near_a = a.counts && keyOf(lowerGap(a.box, bound_b.box), a.triangle.value) <= key_;
    const bool near_b = b.counts && lowerGap(b.box, bound_a.box) <= distanceOf(key_);
    queued_ = 0;
    unsigned left = __ballot_sync(kFullWarp, near_b) & lanes_of_b;
    for (; left != 0; left &= left - 1) {
      const int j = __ffs(static_cast<int>(left)) - 1;
      const Aabb box{laneVector(b.box.min, j), laneVector(b.box.max, j)};
      bool wanted = near_a && keyOf(lowerGap(a.box, box), a.triangle.value) <= key_;
      if (has_parts) {
        const std::uint32_t part_b = __shfl_sync(kFullWarp, b.part, j);
        wanted = wanted && partsCount(c_, tiles_.pair, a.part, part_b);
      }
      add(wanted, j);
      if (queued_ >= kWarp) decide(kWarp);
    }
    if (queued_ > 0) decide(queued_);
  }

 private:
  // One tile, of which each lane has a triangle.
  struct Side {
    TriangleIndex triangle;
    bool counts;
    std::uint32_t part = kNone;  // only if some body has parts
    Aabb box;

    __device__ Side(const CycleArrays& c, TileIndex tile) {
      const uint4 numbers = c.scene.slot_numbers[TileEntryIndex(tile.value * kWarp + laneId())];
      triangle = TriangleIndex(numbers.w);
      counts = triangle.value != kNone;
      const Triangle hull = posedTriangle(c.scene, numbers);
      counts = counts && isFinite(hull);
      if (counts && c.params().parts != 0) {
        part = c.scene.part[triangle];
        counts = part != kNone;
      }
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
    return TriangleIndex(c_.scene.slot_numbers[TileEntryIndex(tile.value * kWarp + lane)].w);
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

}  // namespace deformable_contact_monitor
