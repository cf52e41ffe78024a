// Stage large: the pairs with a very large or far-off triangle: boxes against tiles, their
// triangles, and each other.
#include <algorithm>

#include "cuda/device/boxes.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/cut_off.cuh"
#include "cuda/stages/report.cuh"
#include "cuda/stages/screen.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/swept_pairs.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 256;
constexpr unsigned kTilesEach = kThreads / kWarp;  // that a block works on at a time
// For the large triangles among themselves; and the most for all the others.
constexpr std::uint32_t kBlocksAmong = 64, kMostTileBlocks = 1024;

__device__ bool groupsMeet(const SceneArrays& scene, const Member& a, const Member& b) {
  return (scene.group_mask[Place(a.group)] >> b.group & 1) != 0;
}

// Two members whose boxes meet: adds to contacts.contacts or contacts.candidates if they are one.
template <int kStates>
__device__ void screenBoxPair(const CycleArrays& c, MemberIndex at_a, MemberIndex at_b) {
  const Member a = c.members.at(at_a), b = c.members.at(at_b);
  if (!groupsMeet(c.scene, a, b)) return;
  std::uint32_t shared_a = 0, shared_b = 0;
  if (c.params().any_self != 0) {
    const uint4 ids_a = c.members.ids[at_a], ids_b = c.members.ids[at_b];
    shared_a = sharedBits(ids_a, ids_b);
    shared_b = sharedBits(ids_b, ids_a);
    const bool settled =
        c.params().adjacent == AdjacentPairs::kSkip || (shared_a & certifiedBits(ids_a)) != 0;
    if (shared_a != 0 && settled) return;
  }
  DeviceCandidate candidate;
  const auto screen = kStates > 1 ? screenMovingPair : screenPair;
  if (!screen(c, at_a, at_b, shared_a, shared_b, candidate)) return;
  if (kStates == 1 && c.params().settles != 0) {
    const PartVerdict verdict = certainVerdict(a.posed, b.posed, unpackFacts(candidate.facts));
    if (verdict != PartVerdict::kOpen) atomicAdd(&c.counters().settled, 1ULL);
    if (verdict == PartVerdict::kMeet) {
      putContact(c, atomicAdd(&c.counters().contacts, 1ULL), a.triangle, b.triangle, 0);
    }
    if (verdict != PartVerdict::kOpen) return;
  }
  const unsigned long long place = atomicAdd(&c.counters().candidates, 1ULL);
  if (!putCandidate(c, place, candidate) || c.params().leaves_few == 0) return;
  const bool sharing = shared_a != 0;
  putOpen(c, sharing, atomicAdd(sharing ? &c.counters().sharing : &c.counters().open, 1U),
          Place(static_cast<std::uint32_t>(place)));
}

// Each row of the large list from `first` on, in steps of kBlocksAmong, against the later ones.
// Returns how many pairs of boxes this thread looked at.
template <int kStates>
__device__ unsigned long long sweepAmong(const CycleArrays& c, std::uint32_t large_count,
                                         std::uint32_t first) {
  unsigned long long pairs = 0;
  PacedCutOff pace(c, threadIdx.x == 0);
  for (std::uint32_t i = first; i < large_count; i += kBlocksAmong) {
    const MemberIndex at = c.members.large[Place(i)];
    const Aabb box = c.members.boxes[at].box();
    for (std::uint32_t j = i + 1 + threadIdx.x; j < large_count; j += kThreads) {
      if (pace.isOver(1)) return pairs;
      ++pairs;
      const MemberIndex other = c.members.large[Place(j)];
      if (intersects(box, c.members.boxes[other].box())) screenBoxPair<kStates>(c, at, other);
    }
  }
  return pairs;
}

// The large list against the live triangles of as many tiles as the block has warps, from `first`
// on. Adds how many pairs of boxes this thread looked at to `pairs`; false if the cycle is cut off.
template <int kStates>
__device__ bool sweepTiles(const CycleArrays& c, std::uint32_t large_count, std::uint32_t first,
                           unsigned long long& pairs) {
  __shared__ MemberIndex near[kThreads];
  __shared__ std::uint32_t near_count;
  __shared__ BlockBox shared_box;
  const TileIndex tile(first + threadIdx.x / kWarp);
  const MemberIndex member(tile.value * kWarp + laneId());
  const bool live =
      tile.value < c.scene.tile_count && (c.members.tiles[tile].live >> laneId() & 1) != 0;
  const Aabb box = live ? c.members.boxes[member].box() : Aabb();
  shared_box.clear();
  shared_box.include(box);
  const Aabb all = shared_box.get();
  PacedCutOff pace(c, threadIdx.x == 0);
  for (std::uint32_t from = 0; from < large_count; from += kThreads) {
    __syncthreads();  // who still reads those before
    if (threadIdx.x == 0) near_count = 0;
    __syncthreads();
    if (from + threadIdx.x < large_count) {
      const MemberIndex at = c.members.large[Place(from + threadIdx.x)];
      if (intersects(all, c.members.boxes[at].box())) near[atomicAdd(&near_count, 1U)] = at;
    }
    __syncthreads();
    if (live && !pace.isOver(near_count)) {
      pairs += near_count;
      for (std::uint32_t k = 0; k < near_count; ++k) {
        if (!intersects(box, c.members.boxes[near[k]].box())) continue;
        screenBoxPair<kStates>(c, member, near[k]);
      }
    }
    if (__syncthreads_or(pace.wasOver() ? 1 : 0) != 0) return false;
  }
  return true;
}

// kBlocksAmong blocks for the large list itself, the others for the tiles: reads members.members
// and members.tiles, adds to contacts.candidates.
template <int kStates>
__global__ void __launch_bounds__(kThreads) largeKernel(CycleArrays c) {
  const std::uint32_t large_count = c.counters().large;
  const CycleParams& params = c.params();
  if (large_count == 0 || blockIdx.x % params.passes != params.pass) return;
  unsigned long long pairs = 0;
  if (blockIdx.x < kBlocksAmong) {
    pairs = sweepAmong<kStates>(c, large_count, blockIdx.x);
  } else {
    const std::uint32_t stride = (gridDim.x - kBlocksAmong) * kTilesEach;
    for (std::uint32_t first = (blockIdx.x - kBlocksAmong) * kTilesEach; first < c.scene.tile_count;
         first += stride) {
      if (!sweepTiles<kStates>(c, large_count, first, pairs)) break;
    }
  }
  // Passes over the same pairs again are the same work to who reads the counters.
  if (pairs != 0 && params.passes == 1) atomicAdd(&c.counters().interval_overlaps, pairs);
}

}  // namespace

std::uint32_t largeBlocks(const CycleArrays& cycle) {
  return kBlocksAmong +
         std::min(kMostTileBlocks, (cycle.scene.tile_count + kTilesEach - 1) / kTilesEach);
}

void launchLarge(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  const auto kernel = shape.swept ? largeKernel<2> : largeKernel<1>;
  kernel<<<largeBlocks(cycle), kThreads, 0, stream>>>(cycle);
}

}  // namespace deformable_contact_monitor
