// Stage sweep: pairs of tiles. Warps take work units; what their packed boxes leave goes through a
// short queue, so that every test runs on full warps.
#include "core/rules/deduplication.h"
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/cut_off.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/tile_pairs.cuh"
#include "cuda/stages/warp_queue.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
constexpr unsigned kWarps = kThreads / kWarp;
constexpr unsigned kBlocksEach = 7;  // of a multiprocessor, as registers allow

// A row and a column of a unit that meet along the cluster's axes: lane of the row | column << 5.
using Hit = std::uint16_t;
static_assert(kMostUnitColumns << 5 <= 1U << 16);

// How many columns of each row are swept at once.
constexpr std::uint32_t kStep = 16;
constexpr unsigned kHitCapacity = kWarp * (kStep + 1);
constexpr unsigned kPairCapacity = 2 * kWarp;

struct WarpMemory {
  TilePair crowded[kPairCapacity], others[kPairCapacity];
  Hit hits[kHitCapacity];
};

// A unit takes less than a fifth of a millisecond. One in so many asks whether the cycle is cut
// off; if so, the counter of units, which every warp looks at for its next one, is set beyond all
// units.
constexpr std::uint32_t kUnitsPerAsker = 256;
constexpr std::uint32_t kGivenUp = 1U << 30;

class Sweeper {
 public:
  __device__ Sweeper(const CycleArrays& c, WarpMemory& memory)
      : c_(c), hits_{memory.hits}, crowded_{memory.crowded}, others_{memory.others} {}

  // Each part has one place in this loop: the code must fit the instruction cache.
  __device__ void run() {
    bool more_units = true;
    while (true) {
      const bool swept = step_ >= longest_;
      const bool last = swept && !more_units && hits_.size == 0;
      if (crowded_.size >= kWarp || (last && crowded_.size > 0)) {
        leave(crowded_, &c_.counters().crowded_pairs, c_.sweep.crowded_pairs);
      } else if (others_.size >= kWarp || (last && others_.size > 0)) {
        leave(others_, &c_.counters().tile_pairs, c_.sweep.tile_pairs);
      } else if (hits_.size >= kWarp || (swept && hits_.size > 0)) {
        screenHits();
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
  // The first units are dealt out; the others go to whoever is free, and not before: who asked
  // ahead would keep a unit from others that have nothing to do.
  __device__ std::uint32_t nextTurn() {
    const std::uint32_t dealt = gridDim.x * kWarps;
    std::uint32_t turn = (blockIdx.x * kThreads + threadIdx.x) / kWarp;
    if (unit_.rows() > 0) {
      if (laneId() == 0) turn = dealt + atomicAdd(&c_.counters().units_taken, 1U);
      turn = __shfl_sync(kFullWarp, turn, 0);
    }
    return turn;
  }
  // Into unit_; false if there is none left, or the cycle is cut off.
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

  // Up to a step of columns for each of the rows.
  __device__ void sweepColumns() {
    // A row that is done reads on from its end; places beyond the last member are there.
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

  // Boxes in the scene frame, and owners.
  __device__ void screenHits() {
    Hit hit = 0;
    bool kept = hits_.pop(hit);
    const SortedIndex row = unit_.first_row + (hit & 31U);
    const SortedIndex column(__shfl_sync(kFullWarp, begin_, hit & 31) + (hit >> 5));
    TilePair pair{};
    bool crowded = false;
    if (kept) {
      pair = {c_.sweep.tiles[row], c_.sweep.tiles[column]};
      const TileState a = c_.members.tiles[pair.a], b = c_.members.tiles[pair.b];
      crowded = isCrowded(a.box, b.box);
      kept = intersects(a.box, b.box) &&
             ownsPair(unit_.cluster.value, c_.members.clustersOf(a), c_.members.clustersOf(b));
    }
    crowded_.push(kept && crowded, pair);
    others_.push(kept && !crowded, pair);
  }

  // Few of the hits are kept: by full warps, or all would wait for the two counters.
  template <class Pairs>
  __device__ void leave(WarpQueue<TilePair>& queue, std::uint32_t* counter, const Pairs& to) {
    TilePair pair{};
    const bool has = queue.pop(pair);
    const Place place(warpReserve(counter, has));
    if (has && place.value < to.size()) to[place] = pair;
  }

  const CycleArrays& c_;
  WarpQueue<Hit> hits_;
  WarpQueue<TilePair> crowded_, others_;
  WorkUnit unit_{};  // of no rows before the first
  PackedBox box_{};
  std::uint32_t begin_ = 0, end_ = 0, length_ = 0;  // of this lane's row's columns
  std::uint32_t step_ = 0, longest_ = 0;
};

// Warps for sweep.units: reads the arrays of `sweep` and members.tiles, adds to
// sweep.tile_pairs and sweep.crowded_pairs.
__global__ void __launch_bounds__(kThreads, kBlocksEach) sweepKernel(CycleArrays c) {
  awaitKernelAhead();
  letNextStart();
  __shared__ WarpMemory memory[kWarps];
  Sweeper sweeper(c, memory[threadIdx.x / kWarp]);
  sweeper.run();
}

}  // namespace

void launchSweep(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  if (cycle.together()) return launchTogether(cycle, shape, stream);
  launchEarly(sweepKernel, blocksInOneWave(sweepKernel, kThreads, 0, shape.device), kThreads, 0,
              shape.device, stream, cycle);
}

}  // namespace deformable_contact_monitor
