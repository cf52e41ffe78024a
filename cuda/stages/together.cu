// Stage sweep where all tiles are in one cluster, and few: each against each other, by their boxes.
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/tile_pairs.cuh"

namespace deformable_contact_monitor {
namespace {

// A block looks at so many columns, one for each thread, and rows.
constexpr unsigned kColumns = 128, kRows = 32;

struct RowTiles {
  float4 low[kRows], high[kRows];  // boxes; empty where there is no live triangle

  // By the block's first warp.
  __device__ void fetch(const CycleArrays& c, std::uint32_t first) {
    const std::uint32_t tile = first + threadIdx.x;
    const bool there = tile < c.scene.tile_count;
    const TileState state = there ? c.members.tiles[TileIndex(tile)] : TileState{};
    const MemberBox box = MemberBox::of(state.live != 0 ? state.box : Aabb());
    low[threadIdx.x] = box.low;
    high[threadIdx.x] = box.high;
  }
  __device__ Aabb box(unsigned row) const { return MemberBox{low[row], high[row]}.box(); }
};

__device__ std::uint32_t groupOf(const CycleArrays& c, std::uint32_t tile) {
  return c.scene.bodies[c.scene.tile_body[TileIndex(tile)]].group;
}

// The rows, by bits, that come before a tile and meet it.
__device__ unsigned rowsThatMeet(const CycleArrays& c, const RowTiles& rows,
                                 std::uint32_t first_row, std::uint32_t column, const Aabb& box) {
  unsigned met = 0;
#pragma unroll
  for (unsigned k = 0; k < kRows; ++k) {
    if (intersects(box, rows.box(k))) met |= 1U << k;
  }
  const std::uint32_t before = column > first_row ? min(column - first_row, kRows) : 0;
  met &= before == 0 ? 0 : (2U << (before - 1)) - 1;
  if (met == 0 || c.params().group_count == 1) return met;
  const std::uint32_t groups = c.scene.group_mask[Place(groupOf(c, column))];
  for (unsigned rest = met; rest != 0; rest &= rest - 1) {
    const int k = __ffs(static_cast<int>(rest)) - 1;
    if ((groups >> groupOf(c, first_row + k) & 1) == 0) met &= ~(1U << k);
  }
  return met;
}

// Blocks for rows (x) and columns (y): reads members.tiles, adds to sweep.tile_pairs and
// sweep.crowded_pairs.
__global__ void __launch_bounds__(kColumns) togetherKernel(CycleArrays c) {
  awaitKernelAhead();
  __shared__ RowTiles rows;
  if (blockIdx.x == 0 && blockIdx.y == 0 && threadIdx.x == 0) {
    c.counters().members = c.counters().largest_cluster = c.counters().clustered;
  }
  const std::uint32_t first_row = blockIdx.x * kRows, column = blockIdx.y * kColumns + threadIdx.x;
  if (first_row >= (blockIdx.y + 1) * kColumns) return;  // none comes before
  if (threadIdx.x < kRows) rows.fetch(c, first_row);
  const bool there = column < c.scene.tile_count;
  const TileState state = there ? c.members.tiles[TileIndex(column)] : TileState{};
  __syncthreads();
  const unsigned met = state.live == 0 ? 0 : rowsThatMeet(c, rows, first_row, column, state.box);
  unsigned crowded = 0;
  for (unsigned rest = met; rest != 0; rest &= rest - 1) {
    const int k = __ffs(static_cast<int>(rest)) - 1;
    if (isCrowded(rows.box(k), state.box)) crowded |= 1U << k;
  }
  TilePairWriter to(c, __popc(crowded), __popc(met & ~crowded));
  for (unsigned rest = met; rest != 0; rest &= rest - 1) {
    const int k = __ffs(static_cast<int>(rest)) - 1;
    to.put((crowded >> k & 1) != 0, {TileIndex(first_row + k), TileIndex(column)});
  }
}

}  // namespace

void launchTogether(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  const unsigned tiles = cycle.scene.tile_count;
  const dim3 blocks((tiles + kRows - 1) / kRows, (tiles + kColumns - 1) / kColumns);
  launchEarly(togetherKernel, blocks, kColumns, 0, shape.device, stream, cycle);
}

}  // namespace deformable_contact_monitor
