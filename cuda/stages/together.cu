// Stage sweep where all tiles are in one cluster, and few: each against each other, by their boxes.
#include <algorithm>

#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/corners.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/tile_pairs.cuh"
#include "cuda/stages/warp_queue.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
constexpr unsigned kWarps = kThreads / kWarp;
// What a warp looks at between two looks for more: so many tiles, each with so many others.
constexpr std::uint32_t kRows = 4, kPart = 4 * kWarp;

__host__ __device__ std::uint32_t partsOf(const CycleArrays& c) {
  return (c.scene.tile_count / 2 + kRows - 1 + kPart - 1) / kPart;
}
__host__ __device__ std::uint32_t unitsOf(const CycleArrays& c) {
  return (c.scene.tile_count + kRows - 1) / kRows * partsOf(c);
}

__device__ std::uint32_t groupOf(const SceneArrays& scene, TileIndex tile) {
  return scene.bodies[scene.tile_body[tile]].group;
}

// By a whole warp: up to a warp of pairs from the queue to sweep.tile_pairs.
__device__ void leavePairs(const CycleArrays& c, WarpQueue<TilePair>& met) {
  TilePair pair{};
  const bool got = met.pop(pair);
  putTilePair(c, got, pair);
}

// Some tiles that follow each other. Each is looked at with those that follow it in a ring of all,
// as far as halfway round, so that each pair is met once, and each tile has as much to do.
struct Rows {
  std::uint32_t first;
  TileState tile[kRows];
  std::uint32_t reach[kRows];   // how far round it looks
  std::uint32_t groups[kRows];  // that it meets

  __device__ Rows(const CycleArrays& c, std::uint32_t first_row) : first(first_row) {
    const std::uint32_t tiles = c.scene.tile_count;
    for (unsigned k = 0; k < kRows; ++k) {
      reach[k] = 0;
      if (first + k >= tiles) continue;
      const TileIndex at(first + k);
      tile[k] = c.members.tiles[at];
      groups[k] = c.scene.group_mask[Place(groupOf(c.scene, at))];
      const bool has_opposite = tiles % 2 != 0 || first + k < tiles / 2;
      if (tile[k].live != 0) reach[k] = has_opposite ? tiles / 2 : tiles / 2 - 1;
    }
  }

  // By a whole warp: with the tile that is 1 + `step` behind the first.
  __device__ void meet(const CycleArrays& c, std::uint32_t step, WarpQueue<TilePair>& met) const {
    const std::uint32_t tiles = c.scene.tile_count;
    const std::uint32_t at = first + 1 + step;
    const std::uint32_t round = at < tiles ? at : at - tiles;
    const TileIndex column(round < tiles ? round : 0);  // beyond the reach of all
    const TileState other = c.members.tiles[column];
    const std::uint32_t group = groupOf(c.scene, column);
    for (unsigned k = 0; k < kRows; ++k) {
      const bool meets = step - k < reach[k] && other.live != 0 &&
                         intersects(tile[k].box, other.box) && (groups[k] >> group & 1) != 0;
      if (__any_sync(kFullWarp, meets) == 0) continue;
      met.push(meets, {TileIndex(first + k), column});
      if (met.size >= kWarp) leavePairs(c, met);
    }
  }

  // By a whole warp.
  __device__ void leaveIds(const CycleArrays& c) const {
    for (unsigned k = 0; k < kRows; ++k) {
      if (first + k >= c.scene.tile_count) return;
      if ((tile[k].live >> laneId() & 1) == 0) continue;
      const MemberIndex slot((first + k) * kWarp + laneId());
      c.members.ids[slot] = idsOf(c.scene, c.members.members[slot].triangle);
    }
  }
};

// Warps for rows and parts of what these look at: reads members.tiles; writes members.ids, adds to
// sweep.tile_pairs.
__global__ void __launch_bounds__(kThreads) togetherKernel(CycleArrays c) {
  letNextStart();  // the kernel ahead has ended: this one is launched the usual way
  __shared__ TilePair queued[kWarps][2 * kWarp];
  WarpQueue<TilePair> met{queued[threadIdx.x / kWarp]};
  const std::uint32_t turn = (blockIdx.x * kThreads + threadIdx.x) / kWarp;
  if (turn == 0 && laneId() == 0) {
    c.counters().members = c.counters().largest_cluster = c.counters().clustered;
  }
  const std::uint32_t parts = partsOf(c), units = unitsOf(c);
  for (std::uint32_t unit = turn; unit < units; unit += gridDim.x * kWarps) {
    const Rows rows(c, unit / parts * kRows);
    const std::uint32_t part = unit % parts;
    if (part == 0) rows.leaveIds(c);
    for (std::uint32_t k = 0; k < kPart; k += kWarp) rows.meet(c, part * kPart + k + laneId(), met);
  }
  while (met.size > 0) leavePairs(c, met);
}

}  // namespace

void launchTogether(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  const unsigned most = blocksInOneWave(togetherKernel, kThreads, 0, shape.device);
  const unsigned blocks = std::min(most, (unitsOf(cycle) + kWarps - 1) / kWarps);
  togetherKernel<<<blocks, kThreads, 0, stream>>>(cycle);
}

}  // namespace deformable_contact_monitor
