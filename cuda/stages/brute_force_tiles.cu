// Stage sweep where all tiles are in one cluster, and few: each against each other, by their boxes.
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/tile_pairs.cuh"

namespace deformable_contact_monitor {
namespace {

// Room for a warp's pairs of tiles, so many crowded ones and others.
class TilePairWriter {
 public:
  __device__ TilePairWriter(const CycleArrays& c, std::uint32_t crowded, std::uint32_t others)
      : c_(c) {
    // Both counters at once: their answers are waited for.
    std::uint32_t first = 0;
    if (laneId() == 0 && crowded != 0) first = atomicAdd(&c.counters().crowded_pairs, crowded);
    if (laneId() == 1 && others != 0) first = atomicAdd(&c.counters().tile_pairs, others);
    crowded_ = __shfl_sync(kFullWarp, first, 0);
    others_ = __shfl_sync(kFullWarp, first, 1);
  }

  // By the whole warp: the pairs of the lanes that `keep` one, as far as there is room.
  __device__ void put(bool keep, bool crowded, const TilePair& pair) {
    const unsigned before = (1U << laneId()) - 1;
    const unsigned of_crowded = __ballot_sync(kFullWarp, keep && crowded);
    const unsigned of_others = __ballot_sync(kFullWarp, keep && !crowded);
    const Place place(crowded ? crowded_ + __popc(of_crowded & before)
                              : others_ + __popc(of_others & before));
    const auto& to = crowded ? c_.sweep.crowded_pairs : c_.sweep.tile_pairs;
    if (keep && place.value < to.size()) to[place] = pair;
    crowded_ += __popc(of_crowded);
    others_ += __popc(of_others);
  }

 private:
  const CycleArrays& c_;
  std::uint32_t crowded_, others_;  // the next places
};

// A block looks at so many columns, one for each thread, and rows: few, for small scenes have few
// blocks, and each of those takes its time.
constexpr unsigned kColumns = 128, kRows = 16;

// A row and a column of a warp that meet: the row | the column's lane << 5; and which list it is
// for.
using Hit = std::uint16_t;
constexpr unsigned kColumnShift = 5;
constexpr Hit kCrowded = 1U << 10, kOther = 1U << 11;

struct BlockTiles {
  MemberBox rows[kRows], columns[kColumns];  // empty where there is no live triangle
  std::uint32_t row_group[kRows];
  std::uint32_t column_mask[kColumns];  // groups that the column's meets
  Hit hits[kColumns / kWarp][kWarp * kRows];
};

__device__ std::uint32_t groupOf(const CycleArrays& c, std::uint32_t tile) {
  if (tile >= c.scene.tile_count) return 0;
  return c.scene.bodies[c.scene.tile_body[TileIndex(tile)]].group;
}

__device__ MemberBox boxOfTile(const CycleArrays& c, std::uint32_t tile) {
  const bool there = tile < c.scene.tile_count;
  const TileState state = there ? c.members.tiles[TileIndex(tile)] : TileState{};
  return MemberBox::of(state.live != 0 ? state.box : Aabb());
}

// By a block: rows against the columns that they come before.
class RowsByColumns {
 public:
  __device__ RowsByColumns(const CycleArrays& c, BlockTiles& tiles, std::uint32_t first_row,
                           std::uint32_t first_column)
      : c_(c),
        tiles_(tiles),
        hits_(tiles.hits[threadIdx.x / kWarp]),
        first_row_(first_row),
        first_column_(first_column),
        first_of_warp_(threadIdx.x / kWarp * kWarp) {}

  // What the kernel ahead does not write.
  __device__ void fetchGroups() const {
    if (c_.params().group_count == 1) return;
    if (threadIdx.x < kRows) tiles_.row_group[threadIdx.x] = groupOf(c_, first_row_ + threadIdx.x);
    tiles_.column_mask[threadIdx.x] =
        c_.scene.group_mask[Place(groupOf(c_, first_column_ + threadIdx.x))];
  }

  __device__ void run() const {
    if (threadIdx.x < kRows) tiles_.rows[threadIdx.x] = boxOfTile(c_, first_row_ + threadIdx.x);
    tiles_.columns[threadIdx.x] = boxOfTile(c_, first_column_ + threadIdx.x);
    __syncthreads();
    const std::uint32_t count = listHits(rowsThatMeet());
    if (count == 0) return;
    std::uint32_t crowded, others;
    markHits(count, crowded, others);
    TilePairWriter to(c_, crowded, others);
    for (std::uint32_t first = 0; first < count; first += kWarp) {
      const Hit hit = first + laneId() < count ? hits_[first + laneId()] : 0;
      to.put((hit & (kCrowded | kOther)) != 0, (hit & kCrowded) != 0,
             {TileIndex(first_row_ + rowOf(hit)), TileIndex(first_column_ + columnOf(hit))});
    }
  }

 private:
  __device__ std::uint32_t rowOf(Hit hit) const { return hit % kRows; }
  __device__ std::uint32_t columnOf(Hit hit) const {
    return first_of_warp_ + (hit >> kColumnShift) % kWarp;
  }

  // The rows, by bits, that come before this thread's column and meet it.
  __device__ unsigned rowsThatMeet() const {
    const Aabb box = tiles_.columns[threadIdx.x].box();
    unsigned met = 0;
#pragma unroll
    for (unsigned k = 0; k < kRows; ++k) {
      if (intersects(box, tiles_.rows[k].box())) met |= 1U << k;
    }
    const std::uint32_t column = first_column_ + threadIdx.x;
    const std::uint32_t before = column > first_row_ ? min(column - first_row_, kRows) : 0;
    return before == 0 ? 0 : met & ((2U << (before - 1)) - 1);
  }
  // By a whole warp: the bits of all lanes to hits_, for few lanes have most of them; returns how
  // many they are.
  __device__ std::uint32_t listHits(unsigned met) const {
    std::uint32_t total;
    std::uint32_t place = warpPrefix(__popc(met), total);
    for (; met != 0; met &= met - 1) {
      const auto row = static_cast<std::uint32_t>(__ffs(static_cast<int>(met)) - 1);
      hits_[place++] = static_cast<Hit>(row | laneId() << kColumnShift);
    }
    __syncwarp();
    return total;
  }
  // By a whole warp: which list each of hits_ is for, if their groups meet, and how many of each.
  __device__ void markHits(std::uint32_t count, std::uint32_t& crowded,
                           std::uint32_t& others) const {
    const bool one_group = c_.params().group_count == 1;
    crowded = others = 0;
    for (std::uint32_t first = 0; first < count; first += kWarp) {
      const bool there = first + laneId() < count;
      const Hit hit = there ? hits_[first + laneId()] : 0;
      const std::uint32_t row = rowOf(hit), column = columnOf(hit);
      const bool meet =
          there && (one_group || (tiles_.column_mask[column] >> tiles_.row_group[row] & 1) != 0);
      const bool many = isCrowded(tiles_.rows[row].box(), tiles_.columns[column].box());
      if (meet) hits_[first + laneId()] = hit | (many ? kCrowded : kOther);
      crowded += __popc(__ballot_sync(kFullWarp, meet && many));
      others += __popc(__ballot_sync(kFullWarp, meet && !many));
    }
  }

  const CycleArrays& c_;
  BlockTiles& tiles_;
  Hit* const hits_;  // of this warp
  const std::uint32_t first_row_, first_column_, first_of_warp_;
};

// Blocks are numbered columns by columns, each with the rows before its last one.
constexpr std::uint32_t kRowsOfColumns = kColumns / kRows;

__host__ __device__ std::uint32_t blocksAhead(std::uint32_t columns) {
  return kRowsOfColumns * columns * (columns + 1) / 2;
}

__device__ std::uint32_t columnsOfBlock(std::uint32_t block) {
  auto columns =
      static_cast<std::uint32_t>(sqrtf(2.0F / kRowsOfColumns * static_cast<float>(block)));
  while (blocksAhead(columns) > block) --columns;
  while (blocksAhead(columns + 1) <= block) ++columns;
  return columns;
}

// Reads members.tiles, adds to sweep.tile_pairs and sweep.crowded_pairs.
__global__ void __launch_bounds__(kColumns) togetherKernel(CycleArrays c) {
  __shared__ BlockTiles tiles;
  const std::uint32_t columns = columnsOfBlock(blockIdx.x);
  const std::uint32_t rows = blockIdx.x - blocksAhead(columns);
  const RowsByColumns block(c, tiles, kRows * rows, kColumns * columns);
  block.fetchGroups();
  awaitKernelAhead();
  letNextStart();
  if (blockIdx.x == 0 && threadIdx.x == 0) {
    c.counters().members = c.counters().largest_cluster = c.counters().clustered;
  }
  block.run();
}

}  // namespace

void launchTogether(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  const unsigned blocks = blocksAhead((cycle.scene.tile_count + kColumns - 1) / kColumns);
  launchEarly(togetherKernel, blocks, kColumns, 0, shape.device, stream, cycle);
}

}  // namespace deformable_contact_monitor
