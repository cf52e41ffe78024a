// Finds the pairs of tiles that matter in each state, by boxes of bodies, regions and tiles, and
// looks at their triangles.
#include "cuda/device/warp.cuh"
#include "cuda/states/state_boxes.cuh"
#include "cuda/states/state_kernels.cuh"
#include "cuda/states/state_tiles.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;

// A body in one state: its boxes, as they come to lie there.
class StateSide {
 public:
  __device__ StateSide(const StateArrays& s, std::uint32_t body, std::uint32_t state)
      : s_(s), body_(s.bodies[body]), pose_(s, body, state), box_(pose_.boxOf(s.body_box[body])) {}

  __device__ const StateBody& body() const { return body_; }
  __device__ const QuickPose& pose() const { return pose_; }
  __device__ const Aabb& box() const { return box_; }
  __device__ StateRegion region(std::uint32_t i) const {
    return s_.regions[body_.first_region + i];
  }
  // Returns the box of region i; an empty one beyond the last region.
  __device__ Aabb regionBox(std::uint32_t i) const {
    if (i >= body_.region_count) return {};
    return pose_.boxOf(s_.region_box[body_.first_region + i]);
  }
  // Returns the box of this lane's tile of a region; an empty one if it has fewer tiles.
  __device__ Aabb tileBox(const StateRegion& region) const {
    if (laneId() >= region.tile_count) return {};
    return pose_.boxOf(s_.tile_box[region.first_tile + laneId()]);
  }

 private:
  const StateArrays& s_;
  const StateBody& body_;
  const QuickPose pose_;
  const Aabb box_;
};

// Calls visit(tile_a, tile_b, near) for all tiles of two regions that may be in reach; `near` says
// whether this lane's pair is. Called by a whole warp, which visit() is too.
template <class Visit>
__device__ void visitTiles(const StateSide& a, const StateRegion& region_a, const Aabb& own,
                           const StateSide& b, std::uint32_t region, float reach_m,
                           const Visit& visit) {
  const StateRegion region_b = b.region(region);
  const Aabb whole_a = warpBox(own), box_b = b.tileBox(region_b);
  const bool near_a = areInReach(own, warpBox(box_b), reach_m);
  unsigned left = __ballot_sync(kFullWarp, areInReach(box_b, whole_a, reach_m));
  for (; left != 0; left &= left - 1) {
    const int j = __ffs(static_cast<int>(left)) - 1;
    const Aabb box{laneVector(box_b.min, j), laneVector(box_b.max, j)};
    visit(region_a.first_tile + laneId(), region_b.first_tile + j,
          near_a && areInReach(own, box, reach_m));
  }
}

// Visits the tiles of two bodies that may be in reach in a state. reach() tells it anew for each
// pair of regions. Called by a whole warp.
template <class Reach, class Visit>
__device__ void visitBodies(const StateSide& a, const StateSide& b, const Reach& reach,
                            const Visit& visit) {
  if (!areInReach(a.box(), b.box(), reach())) return;
  for (std::uint32_t i = 0; i < a.body().region_count; ++i) {
    const Aabb box = a.regionBox(i);
    if (!areInReach(box, b.box(), reach())) continue;
    const StateRegion region = a.region(i);
    const Aabb own = a.tileBox(region);
    for (std::uint32_t first = 0; first < b.body().region_count; first += kWarp) {
      const float reach_m = reach();
      const bool near = areInReach(box, b.regionBox(first + laneId()), reach_m);
      for (unsigned left = __ballot_sync(kFullWarp, near); left != 0; left &= left - 1) {
        const std::uint32_t j = first + __ffs(static_cast<int>(left)) - 1;
        visitTiles(a, region, own, b, j, reach(), visit);
      }
    }
  }
}

// Does the same, with the body of fewer regions first: the lanes look at regions of the other one.
// visit() gets the tiles in that order, and whether they are of b and a.
template <class Reach, class Visit>
__device__ void visitPair(const StateSide& a, const StateSide& b, const Reach& reach,
                          const Visit& visit) {
  const bool flipped = a.body().region_count > b.body().region_count;
  visitBodies(
      flipped ? b : a, flipped ? a : b, reach,
      [&](std::uint32_t own, std::uint32_t other, bool near) { visit(own, other, near, flipped); });
}

// A moved body in a state: a warp looks at its pairs.
struct StateWarp {
  std::uint32_t state, moved;
  bool has_work;

  __device__ StateWarp(const StateArrays& s, std::uint32_t warp)
      : state(warp / s.moved_count), moved(warp % s.moved_count) {
    has_work = state < s.state_count && !isStopped(s, warp % kWarpsPerStopper == 0);
  }
  __device__ std::size_t place(const StateArrays& s) const {
    return std::size_t{state} * s.moved_count + moved;
  }

  // Calls look(pair, a, b) for each pair about which something is asked.
  template <class Look>
  __device__ void forPairs(const StateArrays& s, const Look& look) const {
    if (!has_work) return;
    const std::uint32_t end = s.walk_begin[moved + 1];
    for (std::uint32_t i = s.walk_begin[moved]; i < end; ++i) {
      const std::uint32_t pair = s.walk_pair[i];
      if (sameInWarp(isAnswered(s, state, pair) ? 1 : 0) != 0) continue;
      look(pair, StateSide(s, s.pairs[pair].a, state), StateSide(s, s.pairs[pair].b, state));
    }
  }
};

__device__ std::uint32_t warpNumber() { return (blockIdx.x * kThreads + threadIdx.x) / kWarp; }

// Returns an upper bound of the distance of two tiles, from a point of each [m]; infinity where
// float32 ends.
__device__ float upperGapOf(const QuickPose::Place& a, const QuickPose::Place& b) {
  const float upper_m = upperGap(a.at, b.at) + a.error_m + b.error_m;
  return upper_m < FLT_MAX / 2 ? upper_m * (1 + 1e-6F) : INFINITY;
}

// Lowers s.apart by distances of points of tiles that may be in reach, and notes the tiles with the
// nearest points as the seed of the body.
__global__ void __launch_bounds__(kThreads) boundsKernel(StateArrays s) {
  const StateWarp warp(s, warpNumber());
  float best_m = INFINITY;  // of this lane
  StateTiles best{warp.state, kNone, 0, 0};
  warp.forPairs(s, [&](std::uint32_t place, const StateSide& a, const StateSide& b) {
    const DeviceStatePair pair = s.pairs[place];
    const auto reach = [&] {
      const float found_m = __uint_as_float(~warpMost(~__float_as_uint(best_m)));
      return fminf(sameInWarp(reachOf(s, pair, warp.state)), pair.reachM(found_m));
    };
    visitPair(a, b, reach, [&](std::uint32_t own, std::uint32_t other, bool near, bool flipped) {
      if (!near) return;
      const std::uint32_t tile_a = flipped ? other : own, tile_b = flipped ? own : other;
      const float upper_m =
          upperGapOf(a.pose().at(s.tile_point[tile_a]), b.pose().at(s.tile_point[tile_b]));
      if (!(upper_m < INFINITY)) return;
      const float apart_m =
          __double2float_ru(most(upper_m - pair.radii_m, 0.0) * (1 + 1e-6) + 0x1p-149);
      if (apart_m > pair.margin_m || apart_m >= best_m) return;
      best_m = apart_m;
      best = {warp.state, place, tile_a, tile_b};
    });
    const std::uint32_t least = ~warpMost(~__float_as_uint(best_m));
    if (laneId() == 0 && least < __float_as_uint(INFINITY)) atomicMin(&s.apart[warp.state], least);
  });
  const std::uint32_t least = ~warpMost(~__float_as_uint(best_m));
  const unsigned mask =
      __ballot_sync(kFullWarp, best.pair != kNone && __float_as_uint(best_m) == least);
  if (mask == 0 || laneId() + 1 != static_cast<unsigned>(__ffs(static_cast<int>(mask)))) return;
  s.seeds[warp.place(s)] = best;
  atomicMin(&s.seed_key[warp.state], Key{least} << 32 | warp.moved);
}

// One warp for each state: looks at the triangles of the best seed, so that few tiles are listed.
__global__ void __launch_bounds__(kThreads) seedKernel(StateArrays s) {
  __shared__ StateTilesRoom room[kThreads / kWarp];
  const std::uint32_t state = warpNumber();
  if (state >= s.state_count) return;
  const Key key = s.seed_key[state];
  if (key == ~Key{0}) return;
  StateTilesSearch search(s, &room[threadIdx.x / kWarp]);
  search.run(s.seeds[std::size_t{state} * s.moved_count + static_cast<std::uint32_t>(key)]);
}

template <bool kSearchesAtOnce>
__global__ void __launch_bounds__(kThreads) tilesKernel(StateArrays s) {
  __shared__ StateTilesRoom room[kSearchesAtOnce ? kThreads / kWarp : 1];
  bool is_list_full = false;  // then the counter is left alone, so that it cannot wrap
  const StateWarp warp(s, warpNumber());
  warp.forPairs(s, [&](std::uint32_t place, const StateSide& a, const StateSide& b) {
    const DeviceStatePair pair = s.pairs[place];
    const auto reach = [&] { return sameInWarp(reachOf(s, pair, warp.state)); };
    visitPair(a, b, reach, [&](std::uint32_t own, std::uint32_t other, bool near, bool flipped) {
      if (kSearchesAtOnce) {
        StateTilesSearch search(s, &room[kSearchesAtOnce ? threadIdx.x / kWarp : 0]);
        for (unsigned left = __ballot_sync(kFullWarp, near); left != 0; left &= left - 1) {
          if (isStopped(s, warpNumber() % kWarpsPerStopper == 0)) return;
          const std::uint32_t tile = own - laneId() + __ffs(static_cast<int>(left)) - 1;
          search.run({warp.state, place, flipped ? other : tile, flipped ? tile : other});
        }
        return;
      }
      if (is_list_full) return;
      const std::uint32_t at = warpReserve(&s.counters->near_tiles, near);
      const bool listed = near && at < s.near_tiles_size;
      if (listed) {
        s.near_tiles[at] = {warp.state, place, flipped ? other : own, flipped ? own : other};
      }
      is_list_full = __any_sync(kFullWarp, near && !listed) != 0;
    });
  });
}

__global__ void __launch_bounds__(kThreads) trianglesKernel(StateArrays s) {
  __shared__ StateTilesRoom room[kThreads / kWarp];
  const std::uint32_t warps = gridDim.x * (kThreads / kWarp), warp = warpNumber();
  const std::uint32_t count = min(s.counters->near_tiles, s.near_tiles_size);
  StateTilesSearch search(s, &room[threadIdx.x / kWarp]);
  for (std::uint32_t i = warp; i < count; i += warps) {
    if (isStopped(s, warp % kWarpsPerStopper == 0)) break;
    search.run(s.near_tiles[i]);
  }
}

unsigned blocksForStates(const StateArrays& s) {
  const std::uint64_t warps = std::uint64_t{s.state_count} * s.moved_count;
  return static_cast<unsigned>((warps * kWarp + kThreads - 1) / kThreads);
}

}  // namespace

void launchStateBounds(const StateArrays& arrays, cudaStream_t stream) {
  boundsKernel<<<blocksForStates(arrays), kThreads, 0, stream>>>(arrays);
  const unsigned blocks = (arrays.state_count + kThreads / kWarp - 1) / (kThreads / kWarp);
  seedKernel<<<blocks, kThreads, 0, stream>>>(arrays);
  checkCuda(cudaGetLastError(), "the kernels that bound distances in states");
}

void launchStateTiles(const StateArrays& arrays, bool searches_at_once, cudaStream_t stream) {
  if (searches_at_once) {
    tilesKernel<true><<<blocksForStates(arrays), kThreads, 0, stream>>>(arrays);
  } else {
    tilesKernel<false><<<blocksForStates(arrays), kThreads, 0, stream>>>(arrays);
  }
  checkCuda(cudaGetLastError(), "the kernel that lists tiles in states");
}

void launchStateTriangles(const StateArrays& arrays, const DeviceTraits& device,
                          cudaStream_t stream) {
  const unsigned blocks = blocksInOneWave(trianglesKernel, kThreads, 0, device);
  trianglesKernel<<<blocks, kThreads, 0, stream>>>(arrays);
  checkCuda(cudaGetLastError(), "the kernel that looks at triangles in states");
}

}  // namespace deformable_contact_monitor
