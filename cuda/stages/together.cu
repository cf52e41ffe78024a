// Stage sweep where all tiles are in one cluster, and few: each against each other, by their boxes.
#include <algorithm>

#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/corners.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/warp_queue.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
constexpr unsigned kWarps = kThreads / kWarp;

__device__ std::uint32_t groupOf(const SceneArrays& scene, TileIndex tile) {
  return scene.bodies[scene.tile_body[tile]].group;
}

// By a whole warp: up to a warp of pairs from the queue to sweep.tile_pairs.
__device__ void leavePairs(const CycleArrays& c, WarpQueue<TilePair>& met) {
  TilePair pair{};
  const bool got = met.pop(pair);
  const Place place(warpReserve(&c.counters().tile_pairs, got));
  if (got && place.value < c.sweep.tile_pairs.size()) c.sweep.tile_pairs[place] = pair;
}

// By a whole warp: a tile against those that follow it in a ring of all, as far as halfway round,
// so that each pair is met once, and each tile has as much to do.
__device__ void sweepRow(const CycleArrays& c, TileIndex row, const TileState& state,
                         WarpQueue<TilePair>& met) {
  const std::uint32_t tiles = c.scene.tile_count;
  const bool has_last = tiles % 2 != 0 || row.value < tiles / 2;
  const std::uint32_t columns = has_last ? tiles / 2 : tiles / 2 - 1;
  const std::uint32_t groups = c.scene.group_mask[Place(groupOf(c.scene, row))];
  for (std::uint32_t first = 0; first < columns; first += kWarp) {
    const std::uint32_t step = first + laneId();
    const std::uint32_t at = row.value + 1 + step;
    const TileIndex column(at < tiles ? at : at - tiles);
    bool meets = false;
    if (step < columns) {
      const TileState other = c.members.tiles[column];
      meets = other.live != 0 && intersects(state.box, other.box) &&
              (groups >> groupOf(c.scene, column) & 1) != 0;
    }
    met.push(meets, {row, column});
    if (met.size >= kWarp) leavePairs(c, met);
  }
}

// Warps for the tiles: reads members.tiles; writes members.ids, adds to sweep.tile_pairs.
__global__ void __launch_bounds__(kThreads) togetherKernel(CycleArrays c) {
  letNextStart();  // the kernel ahead has ended: this one is launched the usual way
  __shared__ TilePair queued[kWarps][2 * kWarp];
  WarpQueue<TilePair> met{queued[threadIdx.x / kWarp]};
  const std::uint32_t turn = (blockIdx.x * kThreads + threadIdx.x) / kWarp;
  if (turn == 0 && laneId() == 0) {
    c.counters().members = c.counters().largest_cluster = c.counters().clustered;
  }
  for (std::uint32_t i = turn; i < c.scene.tile_count; i += gridDim.x * kWarps) {
    const TileIndex tile(i);
    const TileState state = c.members.tiles[tile];
    if (state.live == 0) continue;
    const MemberIndex slot(i * kWarp + laneId());
    if ((state.live >> laneId() & 1) != 0) {
      c.members.ids[slot] = idsOf(c.scene, c.members.members[slot].triangle);
    }
    sweepRow(c, tile, state, met);
  }
  while (met.size > 0) leavePairs(c, met);
}

}  // namespace

void launchTogether(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  const unsigned most = blocksInOneWave(togetherKernel, kThreads, 0, shape.device);
  const unsigned blocks = std::min(most, (cycle.scene.tile_count + kWarps - 1) / kWarps);
  togetherKernel<<<blocks, kThreads, 0, stream>>>(cycle);
}

}  // namespace deformable_contact_monitor
