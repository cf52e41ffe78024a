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

// Calls look(a, b, pair) for the pairs of one moved body in one state: one warp for each of them.
template <class Look>
__device__ void forPairsOfWarp(const StateArrays& s, std::uint32_t warp, const Look& look) {
  const std::uint32_t state = warp / s.moved_count, moved = warp % s.moved_count;
  if (state >= s.state_count || isStopped(s, warp % kWarpsPerStopper == 0)) return;
  const std::uint32_t end = s.walk_begin[moved + 1];
  for (std::uint32_t i = s.walk_begin[moved]; i < end; ++i) {
    const std::uint32_t pair = s.walk_pair[i];
    if (isAnswered(s, state, pair)) continue;
    look(state, pair, StateSide(s, s.pairs[pair].a, state), StateSide(s, s.pairs[pair].b, state));
  }
}

__device__ std::uint32_t warpNumber() { return (blockIdx.x * kThreads + threadIdx.x) / kWarp; }

// Lowers s.apart by distances of points of tiles that may be in reach.
__global__ void __launch_bounds__(kThreads) boundsKernel(StateArrays s) {
  forPairsOfWarp(
      s, warpNumber(),
      [&s](std::uint32_t state, std::uint32_t place, const StateSide& a, const StateSide& b) {
        const DeviceStatePair pair = s.pairs[place];
        float least_m = INFINITY;
        visitPair(
            a, b, [&] { return reachOf(s, pair, state); },
            [&](std::uint32_t own, std::uint32_t other, bool near, bool flipped) {
              if (!near) return;
              const Vec3f from = a.pose().at(s.tile_point[flipped ? other : own]);
              const Vec3f to = b.pose().at(s.tile_point[flipped ? own : other]);
              const float more = (fabsf(from.x) + fabsf(from.y) + fabsf(from.z) + fabsf(to.x) +
                                  fabsf(to.y) + fabsf(to.z)) *
                                 4e-6F;
              least_m = fminf(least_m, upperGap(from, to) + more);
            });
        for (unsigned o = kWarp / 2; o > 0; o /= 2) {
          least_m = fminf(least_m, __shfl_xor_sync(kFullWarp, least_m, o));
        }
        const float apart_m =
            __double2float_ru(most(least_m - pair.radii_m, 0.0) * (1 + 1e-6) + 0x1p-149);
        if (laneId() == 0 && apart_m <= pair.margin_m) {
          atomicMin(&s.apart[state], __float_as_uint(apart_m));
        }
      });
}

template <bool kSearchesAtOnce>
__global__ void __launch_bounds__(kThreads) tilesKernel(StateArrays s) {
  __shared__ StateTilesRoom room[kSearchesAtOnce ? kThreads / kWarp : 1];
  bool is_list_full = false;  // then the counter is left alone, so that it cannot wrap
  forPairsOfWarp(
      s, warpNumber(),
      [&](std::uint32_t state, std::uint32_t place, const StateSide& a, const StateSide& b) {
        const DeviceStatePair pair = s.pairs[place];
        visitPair(
            a, b, [&] { return reachOf(s, pair, state); },
            [&](std::uint32_t own, std::uint32_t other, bool near, bool flipped) {
              if (kSearchesAtOnce) {
                StateTilesSearch search(s, &room[kSearchesAtOnce ? threadIdx.x / kWarp : 0]);
                for (unsigned left = __ballot_sync(kFullWarp, near); left != 0; left &= left - 1) {
                  const std::uint32_t tile = own - laneId() + __ffs(static_cast<int>(left)) - 1;
                  search.run({state, place, flipped ? other : tile, flipped ? tile : other});
                }
                return;
              }
              const std::uint32_t tile_a = flipped ? other : own, tile_b = flipped ? own : other;
              if (is_list_full) return;
              const std::uint32_t at = warpReserve(&s.counters->near_tiles, near);
              const bool listed = near && at < s.near_tiles_size;
              if (listed) s.near_tiles[at] = {state, place, tile_a, tile_b};
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
  checkCuda(cudaGetLastError(), "the kernel that bounds distances in states");
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
