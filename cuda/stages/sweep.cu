// Stage sweep, first part: finds pairs of tiles whose boxes meet. Each warp takes work units, tests
// packed boxes along the cluster's axes, and puts the hits into a short queue. Full warps then test
// boxes in the scene frame and apply the deduplication rule.
#include "core/rules/deduplication.h"
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/cut_off.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/sweep_parts.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
constexpr unsigned kWarps = kThreads / kWarp;
// Blocks on each multiprocessor, as far as registers allow.
constexpr unsigned kBlocksEach = 7;

// A row and a column of a unit that meet along the cluster's axes: the row's lane in the lowest
// five bits, and the column above them.
using Hit = std::uint16_t;
static_assert(kMostUnitColumns << 5 <= 1U << 16);

// The number of columns of each row that are swept at once.
constexpr std::uint32_t kStep = 16;
constexpr unsigned kHitCapacity = kWarp * (kStep + 1);
constexpr unsigned kPairCapacity = 2 * kWarp;

struct WarpMemory {
  TilePair dense[kPairCapacity], others[kPairCapacity];
  Hit hits[kHitCapacity];
};

// One unit in so many asks whether the cycle is cut off; a unit takes less than 0.2 ms. If it is
// cut off, the counter from which all warps take their next unit is set beyond all units.
constexpr std::uint32_t kUnitsPerAsker = 256;
constexpr std::uint32_t kGivenUp = 1U << 30;

// The work of one warp. All lanes make each call.
class Sweeper {
 public:
  __device__ Sweeper(const CycleArrays& c, WarpMemory& memory)
      : c_(c), hits_{memory.hits}, dense_{memory.dense}, others_{memory.others} {}

  // Runs the part that has enough work for a full warp, until nothing is left. Each part is called
  // from one place only, so that the code fits the instruction cache.
  __device__ void run() {
    bool more_units = true;
    while (true) {
      const bool swept = step_ >= longest_;
      const bool last = swept && !more_units && hits_.size == 0;
      if (dense_.size >= kWarp || (last && dense_.size > 0)) {
        leave(dense_, &c_.counters().dense_pairs, c_.sweep.dense_pairs);
      } else if (others_.size >= kWarp || (last && others_.size > 0)) {
        leave(others_, &c_.counters().tile_pairs, c_.sweep.tile_pairs);
      } else if (hits_.size >= kWarp || (swept && hits_.size > 0)) {
        filterHits();
      } else if (!swept) {
        sweepColumns();
      } else if (more_units) {
        more_units = takeUnit();
      } else {
        break;
      }
    }
  }

 private:
  // Returns the number of the next unit. The first units are assigned in a fixed way, the others go
  // to any warp that is free. A warp does not ask in advance, because it would keep a unit from
  // warps that have nothing to do.
  __device__ std::uint32_t nextTurn() {
    const std::uint32_t dealt = gridDim.x * kWarps;
    std::uint32_t turn = (blockIdx.x * kThreads + threadIdx.x) / kWarp;
    if (unit_.rows() > 0) {
      if (laneId() == 0) turn = dealt + atomicAdd(&c_.counters().units_taken, 1U);
      turn = __shfl_sync(kFullWarp, turn, 0);
    }
    return turn;
  }
  // Reads the next unit into unit_. Returns false if none is left or the cycle is cut off.
  __device__ bool fetchUnit() {
    const std::uint32_t turn = nextTurn();
    const std::uint32_t all = min(c_.counters().units, c_.sweep.units.size());
    if (turn >= all) return false;
    if (turn % kUnitsPerAsker == 0 && turn >= gridDim.x * kWarps && warpIsCutOff(c_, true)) {
      if (laneId() == 0) atomicMax(&c_.counters().units_taken, kGivenUp);
      return false;
    }
    unit_ = c_.sweep.units[Place(turn)];
    return true;
  }
  // Takes the next unit: each lane gets one row and its range of columns. Returns false if there is
  // none.
  __device__ bool takeUnit() {
    if (!fetchUnit()) return false;
    const CycleParams& params = c_.params();
    const SortedIndex row = unit_.first_row + min(laneId(), unit_.rows() - 1);
    const ColumnRange range =
        columnsOf(c_.sweep.bucket_begin.row(unit_.cluster), params.bucketsOfGroup(),
                  unit_.rowGroup(), unit_.columnGroup(), row, c_.sweep.keys[row]);
    begin_ = range.begin + unit_.first_column;
    end_ = range.end;
    length_ = 0;
    if (laneId() < unit_.rows() && begin_ < end_) length_ = min(end_ - begin_, params.unit_columns);
    box_ = c_.sweep.boxes[row];
    longest_ = warpMost(length_);
    step_ = 0;
    return true;
  }

  // Tests up to kStep columns of each row, one row for each lane, and queues the hits.
  __device__ void sweepColumns() {
    // A row that is done reads beyond its end; the array has places beyond the last entry.
    const PackedBox* columns = c_.sweep.boxes.data() + min(begin_ + step_, end_);
    unsigned mask = 0;
#pragma unroll
    for (unsigned first = 0; first < kStep; first += kLeastUnitColumns) {
      if (first > 0 && step_ + first >= longest_) break;
#pragma unroll
      for (unsigned k = first; k < first + kLeastUnitColumns; ++k) {
        if (intersects(box_, columns[k])) mask |= 1U << k;
      }
    }
    const std::uint32_t left = length_ > step_ ? length_ - step_ : 0;
    if (left < kStep) mask &= (1U << left) - 1;
    std::uint32_t total;
    std::uint32_t place = hits_.size + warpPrefix(__popc(mask), total);
    for (; mask != 0; mask &= mask - 1) {
      const std::uint32_t k = __ffs(static_cast<int>(mask)) - 1;
      hits_.items[place++] = static_cast<Hit>(laneId() | (step_ + k) << 5);
    }
    hits_.size += total;
    step_ += kStep;
    __syncwarp();
  }

  // Tests the boxes of queued hits in the scene frame, and whether this cluster reports the pair.
  __device__ void filterHits() {
    Hit hit = 0;
    bool kept = hits_.pop(hit);
    const SortedIndex row = unit_.first_row + (hit & 31U);
    const SortedIndex column(__shfl_sync(kFullWarp, begin_, hit & 31) + (hit >> 5));
    TilePair pair{};
    bool dense = false;
    if (kept) {
      pair = {c_.sweep.tiles[row], c_.sweep.tiles[column]};
      const TileState a = c_.tiles.states[pair.a], b = c_.tiles.states[pair.b];
      dense = isDense(a.box, b.box);
      kept = a.mayMeet(b) &&
             reportsPair(unit_.cluster.value, c_.tiles.clustersOf(a), c_.tiles.clustersOf(b));
    }
    dense_.push(kept && dense, pair);
    others_.push(kept && !dense, pair);
  }

  // Writes up to a warp of queued pairs to their list. Few hits are kept, so the queue makes one
  // addition to the counter serve many pairs.
  template <class Pairs>
  __device__ void leave(WarpQueue<TilePair, kPairCapacity>& queue, std::uint32_t* counter,
                        const Pairs& to) {
    TilePair pair{};
    const bool has = queue.pop(pair);
    const Place place(warpReserve(counter, has));
    if (has && place.value < to.size()) to[place] = pair;
  }

  const CycleArrays& c_;
  WarpQueue<Hit, kHitCapacity> hits_;
  WarpQueue<TilePair, kPairCapacity> dense_, others_;
  WorkUnit unit_{};  // has no rows before the first unit
  PackedBox box_{};
  std::uint32_t begin_ = 0, end_ = 0, length_ = 0;  // columns of this lane's row
  std::uint32_t step_ = 0, longest_ = 0;
};

// Warps take sweep.units. Reads the arrays of `sweep` and tiles.states; adds to sweep.tile_pairs
// and sweep.dense_pairs.
__global__ void __launch_bounds__(kThreads, kBlocksEach) sweepKernel(CycleArrays c) {
  awaitPreviousKernel();
  letNextKernelStart();
  __shared__ WarpMemory memory[kWarps];
  Sweeper sweeper(c, memory[threadIdx.x / kWarp]);
  sweeper.run();
}

}  // namespace

void launchSweep(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  if (cycle.usesBruteForce()) return launchBruteForceTiles(cycle, shape, stream);
  launchDependent(sweepKernel, blocksInOneWave(sweepKernel, kThreads, 0, shape.device), kThreads, 0,
                  shape.device, stream, cycle);
}

}  // namespace deformable_contact_monitor
