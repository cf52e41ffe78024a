// Stage oversized: finds the pairs with a very large or far-off triangle. Its box would be in many
// clusters, so it is tested by brute force: against the tiles, against the triangles of the tiles
// that it meets, and against other oversized triangles.
#include <algorithm>

#include "core/rules/common_motion.h"
#include "cuda/device/boxes.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/cut_off.cuh"
#include "cuda/stages/found_pairs.cuh"
#include "cuda/stages/pair_filter.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/swept_pairs.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 256;
constexpr unsigned kTilesEach = kThreads / kWarp;  // tiles that a block works on at a time
// The number of blocks for pairs of oversized triangles, and the most blocks for all other pairs.
constexpr std::uint32_t kBlocksAmong = 64, kMostTileBlocks = 1024;

// Returns the box of all that a tile entry passes, minus the common motion and grown by its body's
// margin [m].
template <int kStates>
__device__ Aabb passedBoxAt(const CycleArrays& c, TileEntryIndex at) {
  if (kStates == 1) return tileEntryBox(c, c.tiles.at(at));
  return sweptBox(movingBoxAt(c, at), c.scene.common_motion[Place(0)]);
}

// Filters a pair of tile entries whose boxes meet. Adds it to contacts.contacts if float32 is
// certain of a contact, and to contacts.candidates if it stays open.
template <int kStates>
__device__ void filterBoxPair(const CycleArrays& c, TileEntryIndex at_a, TileEntryIndex at_b) {
  const TileEntry a = c.tiles.at(at_a), b = c.tiles.at(at_b);
  if (!c.scene.pairEnabled(a.part, b.part)) return;
  std::uint32_t shared_a = 0, shared_b = 0;
  if (const uint4* const ids = vertexIds(c)) {
    const uint4 ids_a = ids[at_a.value], ids_b = ids[at_b.value];
    shared_a = sharedBits(ids_a, ids_b);
    shared_b = sharedBits(ids_b, ids_a);
    const bool decided =
        c.params().adjacent == AdjacentPairs::kSkip || (shared_a & certifiedBits(ids_a)) != 0;
    if (shared_a != 0 && decided) return;
  }
  DeviceCandidate candidate;
  const auto filter = kStates > 1 ? filterMovingPair : filterPair;
  if (!filter(c, at_a, at_b, shared_a, shared_b, candidate)) return;
  if (kStates == 1 && !isCandidateHere(c, a, b, candidate)) return;
  if (kStates == 1 && c.params().decides != 0) {
    const PartVerdict verdict = certainVerdict(a.posed, b.posed, unpackFacts(candidate.facts));
    if (verdict != PartVerdict::kOpen) atomicAdd(&c.counters().decided, 1ULL);
    if (verdict == PartVerdict::kMeet) {
      putContact(c, atomicAdd(&c.counters().contacts, 1ULL), a.triangle, b.triangle, 0);
    }
    if (verdict != PartVerdict::kOpen) return;
  }
  const unsigned long long place = atomicAdd(&c.counters().candidates, 1ULL);
  if (!putCandidate(c, place, candidate) || c.params().leaves_few == 0) return;
  const bool adjacent = sharedBitsOf(candidate) != 0;
  putOpen(c, adjacent, atomicAdd(adjacent ? &c.counters().open_adjacent : &c.counters().open, 1U),
          Place(static_cast<std::uint32_t>(place)));
}

// Tests each triangle of the oversized list from `first` on, in steps of kBlocksAmong, against the
// later ones. The threads of a block divide the later ones. Returns how many pairs of boxes this
// thread tested.
template <int kStates>
__device__ unsigned long long sweepAmong(const CycleArrays& c, std::uint32_t oversized_count,
                                         std::uint32_t first) {
  unsigned long long pairs = 0;
  PacedCutOff pace(c, threadIdx.x == 0);
  for (std::uint32_t i = first; i < oversized_count; i += kBlocksAmong) {
    const TileEntryIndex at = c.tiles.oversized[Place(i)];
    const Aabb box = passedBoxAt<kStates>(c, at);
    for (std::uint32_t j = i + 1 + threadIdx.x; j < oversized_count; j += kThreads) {
      if (pace.isOver(1)) return pairs;
      ++pairs;
      const TileEntryIndex other = c.tiles.oversized[Place(j)];
      if (intersects(box, passedBoxAt<kStates>(c, other))) filterBoxPair<kStates>(c, at, other);
    }
  }
  return pairs;
}

// Tests the oversized list against the live triangles of kTilesEach tiles, from `first` on, one
// thread for each triangle. The block first collects the oversized triangles that meet the box of
// all its triangles. Adds how many pairs of boxes this thread tested to `pairs`. Returns false if
// the cycle is cut off.
template <int kStates>
__device__ bool sweepTiles(const CycleArrays& c, std::uint32_t oversized_count, std::uint32_t first,
                           unsigned long long& pairs) {
  __shared__ TileEntryIndex near[kThreads];
  __shared__ std::uint32_t near_count;
  __shared__ BlockBox shared_box;
  const TileIndex tile(first + threadIdx.x / kWarp);
  const TileEntryIndex member(tile.value * kWarp + laneId());
  const bool live =
      tile.value < c.scene.tile_count && (c.tiles.states[tile].live >> laneId() & 1) != 0;
  const Aabb box = live ? passedBoxAt<kStates>(c, member) : Aabb();
  shared_box.clear();
  shared_box.include(box);
  const Aabb all = shared_box.get();
  PacedCutOff pace(c, threadIdx.x == 0);
  for (std::uint32_t from = 0; from < oversized_count; from += kThreads) {
    __syncthreads();  // other threads may still read the last triangles
    if (threadIdx.x == 0) near_count = 0;
    __syncthreads();
    if (from + threadIdx.x < oversized_count) {
      const TileEntryIndex at = c.tiles.oversized[Place(from + threadIdx.x)];
      if (intersects(all, passedBoxAt<kStates>(c, at))) near[atomicAdd(&near_count, 1U)] = at;
    }
    __syncthreads();
    if (live && !pace.isOver(near_count)) {
      pairs += near_count;
      for (std::uint32_t k = 0; k < near_count; ++k) {
        if (!intersects(box, passedBoxAt<kStates>(c, near[k]))) continue;
        filterBoxPair<kStates>(c, member, near[k]);
      }
    }
    if (__syncthreads_or(pace.wasOver() ? 1 : 0) != 0) return false;
  }
  return true;
}

// The first kBlocksAmong blocks work on pairs of oversized triangles, the others on the tiles.
// Reads tiles.entries and tiles.states; adds to contacts.candidates and contacts.contacts.
template <int kStates>
__global__ void __launch_bounds__(kThreads) oversizedKernel(CycleArrays c) {
  const std::uint32_t oversized_count = c.counters().oversized;
  const CycleParams& params = c.params();
  if (oversized_count == 0 || blockIdx.x % params.passes != params.pass) return;
  unsigned long long pairs = 0;
  if (blockIdx.x < kBlocksAmong) {
    pairs = sweepAmong<kStates>(c, oversized_count, blockIdx.x);
  } else {
    const std::uint32_t stride = (gridDim.x - kBlocksAmong) * kTilesEach;
    for (std::uint32_t first = (blockIdx.x - kBlocksAmong) * kTilesEach; first < c.scene.tile_count;
         first += stride) {
      if (!sweepTiles<kStates>(c, oversized_count, first, pairs)) break;
    }
  }
  // Counts the work only in a cycle of one pass, because passes test the same pairs again.
  if (pairs != 0 && params.passes == 1) atomicAdd(&c.counters().interval_overlaps, pairs);
}

}  // namespace

std::uint32_t oversizedBlocks(const CycleArrays& cycle) {
  return kBlocksAmong +
         std::min(kMostTileBlocks, (cycle.scene.tile_count + kTilesEach - 1) / kTilesEach);
}

void launchOversized(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  const auto kernel = shape.swept ? oversizedKernel<2> : oversizedKernel<1>;
  kernel<<<oversizedBlocks(cycle), kThreads, 0, stream>>>(cycle);
}

}  // namespace deformable_contact_monitor
