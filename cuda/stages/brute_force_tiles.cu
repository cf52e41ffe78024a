// Stage sweep for scenes with one cluster of few tiles: tests the box of each tile against that of
// every other tile. A block tests kRows rows against kColumns columns. Each thread tests one column
// against all rows; the hits of a warp are then listed, so that further tests run on full warps.
#include "cuda/device/boxes.cuh"
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/sweep_parts.cuh"

namespace deformable_contact_monitor {
namespace {

// Writes a warp's pairs of tiles to the two lists. The constructor reserves room for `dense` pairs
// and `others`.
class TilePairWriter {
 public:
  __device__ TilePairWriter(const CycleArrays& c, std::uint32_t dense, std::uint32_t others)
      : c_(c) {
    // Two lanes add to both counters at the same time, so that the warp waits only once.
    std::uint32_t first = 0;
    if (laneId() == 0 && dense != 0) first = atomicAdd(&c.counters().dense_pairs, dense);
    if (laneId() == 1 && others != 0) first = atomicAdd(&c.counters().tile_pairs, others);
    dense_ = __shfl_sync(kFullWarp, first, 0);
    others_ = __shfl_sync(kFullWarp, first, 1);
  }

  // Writes the pairs of the lanes in which `keep` is set, as far as there is room. Called by the
  // whole warp.
  __device__ void put(bool keep, bool dense, const TilePair& pair) {
    const unsigned before = (1U << laneId()) - 1;
    const unsigned of_dense = __ballot_sync(kFullWarp, keep && dense);
    const unsigned of_others = __ballot_sync(kFullWarp, keep && !dense);
    const Place place(dense ? dense_ + __popc(of_dense & before)
                            : others_ + __popc(of_others & before));
    const auto& to = dense ? c_.sweep.dense_pairs : c_.sweep.tile_pairs;
    if (keep && place.value < to.size()) to[place] = pair;
    dense_ += __popc(of_dense);
    others_ += __popc(of_others);
  }

 private:
  const CycleArrays& c_;
  std::uint32_t dense_, others_;  // the next free places
};

// The columns and rows of a block. Rows are few, because small scenes have few blocks, and the time
// of a block grows with its rows.
constexpr unsigned kColumns = 128, kRows = 16;

// A row and a column that meet: the row | the column's lane << 5 | a bit for the list to which the
// pair belongs.
using Hit = std::uint16_t;
constexpr unsigned kColumnShift = 5;
constexpr Hit kDense = 1U << 10, kOther = 1U << 11;

// A box [m], which is read by two wide loads.
struct alignas(16) WideBox {
  float4 low, high;

  __device__ static WideBox of(const Aabb& box) {
    return {make_float4(box.min.x, box.min.y, box.min.z, 0),
            make_float4(box.max.x, box.max.y, box.max.z, 0)};
  }
  __device__ Aabb box() const { return {{low.x, low.y, low.z}, {high.x, high.y, high.z}}; }
};

struct BlockTiles {
  WideBox rows[kRows], columns[kColumns];  // empty if the tile has no live triangle
  WideBox all_rows;
  std::uint32_t row_group[kRows];
  std::uint32_t column_mask[kColumns];  // groups that the column's group may touch
  Hit hits[kColumns / kWarp][kWarp * kRows];
};

__device__ std::uint32_t groupOf(const CycleArrays& c, std::uint32_t tile) {
  if (tile >= c.scene.tile_count) return 0;
  return c.scene.bodies[c.scene.tile_body[TileIndex(tile)]].group;
}

__device__ WideBox boxOfTile(const CycleArrays& c, std::uint32_t tile) {
  const bool there = tile < c.scene.tile_count;
  const TileState state = there ? c.tiles.states[TileIndex(tile)] : TileState{};
  return WideBox::of(state.live != 0 ? state.box : Aabb());
}

// Tests rows against the columns that come after them. Run by a whole block.
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

  // Reads groups, which the previous kernel does not write.
  __device__ void fetchGroups() const {
    if (c_.params().group_count == 1) return;
    if (threadIdx.x < kRows) tiles_.row_group[threadIdx.x] = groupOf(c_, first_row_ + threadIdx.x);
    tiles_.column_mask[threadIdx.x] =
        c_.scene.group_mask[Place(groupOf(c_, first_column_ + threadIdx.x))];
  }

  __device__ void run() const {
    if (threadIdx.x < kWarp) fetchRows();
    const WideBox column = boxOfTile(c_, first_column_ + threadIdx.x);
    __syncthreads();
    // Tiles close to each other have numbers close to each other, so most warps meet no row.
    if (__any_sync(kFullWarp, intersects(column.box(), tiles_.all_rows.box())) == 0) return;
    tiles_.columns[threadIdx.x] = column;
    const std::uint32_t count = listHits(rowsThatMeet(column.box()));
    if (count == 0) return;
    std::uint32_t dense, others;
    markHits(count, dense, others);
    TilePairWriter to(c_, dense, others);
    for (std::uint32_t first = 0; first < count; first += kWarp) {
      const Hit hit = first + laneId() < count ? hits_[first + laneId()] : 0;
      to.put((hit & (kDense | kOther)) != 0, (hit & kDense) != 0,
             {TileIndex(first_row_ + rowOf(hit)), TileIndex(first_column_ + columnOf(hit))});
    }
  }

 private:
  __device__ std::uint32_t rowOf(Hit hit) const { return hit % kRows; }
  __device__ std::uint32_t columnOf(Hit hit) const {
    return first_of_warp_ + (hit >> kColumnShift) % kWarp;
  }

  // Reads the rows' boxes, and finds the box of all rows. Called by the first warp.
  __device__ void fetchRows() const {
    static_assert(kRows <= kWarp);
    const bool mine = laneId() < kRows;
    const WideBox row = mine ? boxOfTile(c_, first_row_ + laneId()) : WideBox::of(Aabb());
    if (mine) tiles_.rows[laneId()] = row;
    const Aabb all = warpBox(row.box());
    if (laneId() == 0) tiles_.all_rows = WideBox::of(all);
  }
  // Returns the rows, as bits, that come before this thread's column and whose boxes meet its box.
  __device__ unsigned rowsThatMeet(const Aabb& box) const {
    unsigned met = 0;
#pragma unroll
    for (unsigned k = 0; k < kRows; ++k) {
      if (intersects(box, tiles_.rows[k].box())) met |= 1U << k;
    }
    const std::uint32_t column = first_column_ + threadIdx.x;
    const std::uint32_t before = column > first_row_ ? min(column - first_row_, kRows) : 0;
    return before == 0 ? 0 : met & ((2U << (before - 1)) - 1);
  }
  // Writes the hits of all lanes to hits_ and returns their number. A few lanes often have most of
  // the hits; the list divides them evenly among the lanes. Called by a whole warp.
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
  // Returns whether a hit is a pair of tiles: the groups may touch, and the tiles are not apart
  // along a diagonal.
  __device__ bool isPair(std::uint32_t row, std::uint32_t column) const {
    const bool one_group = c_.params().group_count == 1;
    if (!one_group && (tiles_.column_mask[column] >> tiles_.row_group[row] & 1) == 0) return false;
    return intersects(c_.tiles.states[TileIndex(first_row_ + row)].diagonals,
                      c_.tiles.states[TileIndex(first_column_ + column)].diagonals);
  }
  // Marks each of hits_ that is a pair of tiles with its list, and counts both lists. Called by a
  // whole warp.
  __device__ void markHits(std::uint32_t count, std::uint32_t& dense, std::uint32_t& others) const {
    dense = others = 0;
    for (std::uint32_t first = 0; first < count; first += kWarp) {
      const bool there = first + laneId() < count;
      const Hit hit = there ? hits_[first + laneId()] : 0;
      const std::uint32_t row = rowOf(hit), column = columnOf(hit);
      const bool meet = there && isPair(row, column);
      const bool many = isDense(tiles_.rows[row].box(), tiles_.columns[column].box());
      if (meet) hits_[first + laneId()] = hit | (many ? kDense : kOther);
      dense += __popc(__ballot_sync(kFullWarp, meet && many));
      others += __popc(__ballot_sync(kFullWarp, meet && !many));
    }
  }

  const CycleArrays& c_;
  BlockTiles& tiles_;
  Hit* const hits_;  // of this warp
  const std::uint32_t first_row_, first_column_, first_of_warp_;
};

// Blocks are numbered from left to right: first those of the first kColumns columns, then those of
// the next ones. The blocks of some columns cover all rows that come before the last of them.
constexpr std::uint32_t kRowsOfColumns = kColumns / kRows;

// Returns the number of blocks before the first one of these columns.
__host__ __device__ std::uint32_t blocksBefore(std::uint32_t columns) {
  return kRowsOfColumns * columns * (columns + 1) / 2;
}

// Returns the columns of a block: solves blocksBefore() for `columns`, and corrects the rounding.
__device__ std::uint32_t columnsOfBlock(std::uint32_t block) {
  auto columns =
      static_cast<std::uint32_t>(sqrtf(2.0F / kRowsOfColumns * static_cast<float>(block)));
  while (blocksBefore(columns) > block) --columns;
  while (blocksBefore(columns + 1) <= block) ++columns;
  return columns;
}

// Reads tiles.states; adds to sweep.tile_pairs and sweep.dense_pairs.
__global__ void __launch_bounds__(kColumns) bruteForceTilesKernel(CycleArrays c) {
  __shared__ BlockTiles tiles;
  const std::uint32_t columns = columnsOfBlock(blockIdx.x);
  const std::uint32_t rows = blockIdx.x - blocksBefore(columns);
  const RowsByColumns block(c, tiles, kRows * rows, kColumns * columns);
  block.fetchGroups();
  awaitPreviousKernel();
  letNextKernelStart();
  if (blockIdx.x == 0 && threadIdx.x == 0) {
    c.counters().cluster_entries = c.counters().largest_cluster = c.counters().clustered;
  }
  block.run();
}

}  // namespace

void launchBruteForceTiles(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  const unsigned blocks = blocksBefore((cycle.scene.tile_count + kColumns - 1) / kColumns);
  launchDependent(bruteForceTilesKernel, blocks, kColumns, 0, shape.device, stream, cycle);
}

}  // namespace deformable_contact_monitor
