// Stage sweep. Warps take work units; what their boxes leave goes through two short queues, so that
// every test runs on full warps.
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/cut_off.cuh"
#include "cuda/stages/screen.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/swept_pairs.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
constexpr unsigned kWarps = kThreads / kWarp;
constexpr unsigned kBlocksEach = 7;  // of a multiprocessor, as registers allow

// Of one warp, in shared memory; `size` is the same in all lanes.
template <class T, unsigned kCapacity>
struct WarpQueue {
  T* items;
  unsigned size = 0;

  // Takes an item from each lane that has one.
  __device__ void push(bool has, const T& item) {
    const unsigned mask = __ballot_sync(kFullWarp, has);
    if (has) items[size + __popc(mask & ((1U << laneId()) - 1))] = item;
    size += __popc(mask);
    __syncwarp();
  }
  // Removes up to a warp of items; true in the lanes that got one.
  __device__ bool pop(T& item) {
    const unsigned taken = min(size, kWarp);
    size -= taken;
    const bool got = laneId() < taken;
    if (got) item = items[size + laneId()];
    __syncwarp();
    return got;
  }
};

// Two members whose boxes meet along the cluster's axes and in the scene frame.
struct BoxPair {
  std::uint32_t a, b;  // members | shared vertices << kSharedBitsAt
  ClusterIndex cluster;
};
constexpr unsigned kSharedBitsAt = 29;
constexpr std::uint32_t kMemberMask = (1U << kSharedBitsAt) - 1;

constexpr unsigned kAxisPairCapacity = kWarp * (kWarp + 1);
constexpr unsigned kQueueCapacity = 2 * kWarp;

struct WarpMemory {
  // Pairs of a unit that meet along the cluster's axes: lane of the row | column in the unit << 5.
  std::uint32_t axis_pairs[kAxisPairCapacity];
  BoxPair box_pairs[kQueueCapacity];
  DeviceCandidate candidates[kQueueCapacity];
};

// A unit takes less than a fifth of a millisecond. One in so many asks whether the cycle is cut
// off; if so, the counter of units, which every warp looks at for its next one, is set beyond all
// units.
constexpr std::uint32_t kUnitsPerAsker = 256;
constexpr std::uint32_t kGivenUp = 1U << 30;

// kStates == 2 in swept motion.
template <int kStates>
class Sweeper {
 public:
  __device__ Sweeper(const CycleArrays& c, WarpMemory& memory)
      : c_(c),
        axis_pairs_{memory.axis_pairs},
        box_pairs_{memory.box_pairs},
        candidates_{memory.candidates} {}

  // Each part has one place in this loop: the code must fit the instruction cache.
  __device__ void run() {
    const std::uint32_t warps = gridDim.x * kWarps;
    // The first units are dealt out; the others go to whoever is free.
    std::uint32_t turn = (blockIdx.x * kThreads + threadIdx.x) / kWarp;
    bool more_units = true;
    while (true) {
      const bool swept = step_ >= longest_;
      if (box_pairs_.size >= kWarp ||
          (!more_units && axis_pairs_.size == 0 && box_pairs_.size > 0)) {
        screenBoxPairs();
      } else if (axis_pairs_.size >= kWarp || (swept && axis_pairs_.size > 0)) {
        screenAxisPairs();
      } else if (!swept) {
        sweepColumns();
      } else if (more_units) {
        more_units = takeUnit(turn);
        if (more_units && laneId() == 0) turn = warps + atomicAdd(&c_.counters().units_taken, 1U);
        turn = __shfl_sync(kFullWarp, turn, 0);
      } else {
        break;
      }
    }
    emitCandidates();
  }

 private:
  __device__ bool takeUnit(std::uint32_t turn) {
    const CycleParams& params = c_.params();
    const std::uint32_t index = turn * params.passes + params.pass;
    if (turn >= kGivenUp || index >= min(c_.counters().units, c_.sweep.units.size())) return false;
    if (turn % kUnitsPerAsker == 0 && turn >= gridDim.x * kWarps && warpIsCutOff(c_, true)) {
      if (laneId() == 0) atomicMax(&c_.counters().units_taken, kGivenUp);
      return false;
    }
    unit_ = c_.sweep.units[Place(index)];
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

  // Up to a warp of columns for each of the rows.
  __device__ void sweepColumns() {
    // A row that is done reads on from its end; places beyond the last member are there.
    const PackedBox* columns = c_.sweep.boxes.data() + min(begin_ + step_, end_);
    unsigned mask = 0;
#pragma unroll
    for (unsigned first = 0; first < kWarp; first += kLeastUnitColumns) {
      if (first > 0 && step_ + first >= longest_) break;
#pragma unroll
      for (unsigned k = first; k < first + kLeastUnitColumns; ++k) {
        if (intersects(box_, columns[k])) mask |= 1U << k;
      }
    }
    const std::uint32_t left = length_ > step_ ? length_ - step_ : 0;
    if (left < kWarp) mask &= (1U << left) - 1;
    std::uint32_t total;
    std::uint32_t place = axis_pairs_.size + warpPrefix(__popc(mask), total);
    for (; mask != 0; mask &= mask - 1) {
      const std::uint32_t k = __ffs(static_cast<int>(mask)) - 1;
      axis_pairs_.items[place++] = laneId() | (step_ + k) << 5;
    }
    axis_pairs_.size += total;
    step_ += kWarp;
    __syncwarp();
  }

  // Boxes in the scene frame, and shared vertices.
  __device__ void screenAxisPairs() {
    std::uint32_t pair = 0;
    bool kept = axis_pairs_.pop(pair);
    const SortedIndex row = unit_.first_row + (pair & 31);
    const SortedIndex column(__shfl_sync(kFullWarp, begin_, pair & 31) + (pair >> 5));
    BoxPair box_pair;
    if (kept) {
      const uint4 a = c_.sweep.world_boxes[row], b = c_.sweep.world_boxes[column];
      if (kStates == 1) {
        kept = intersects(PackedBox{a.x, a.y}, PackedBox{b.x, b.y}) &&
               intersects(PackedBox{a.z, a.w}, PackedBox{b.z, b.w});
      } else {
        kept = mayMeet({{a.x, a.y}, {a.z, a.w}, c_.sweep.moving_z[row]},
                       {{b.x, b.y}, {b.z, b.w}, c_.sweep.moving_z[column]});
      }
    }
    if (kept) {
      const uint4 a = c_.sweep.ids[row], b = c_.sweep.ids[column];
      const std::uint32_t shared_a = sharedBits(a, b);
      kept = shared_a == 0 ||
             (c_.params().adjacent == AdjacentPairs::kBeyondShared && !isCertified(a, shared_a));
      const std::uint32_t shared_b = shared_a == 0 ? 0 : sharedBits(b, a);
      box_pair = {a.w | shared_a << kSharedBitsAt, b.w | shared_b << kSharedBitsAt, unit_.cluster};
    }
    box_pairs_.push(kept, box_pair);
  }

  // Planes, full boxes and owners.
  __device__ void screenBoxPairs() {
    BoxPair pair;
    DeviceCandidate candidate;
    bool kept = box_pairs_.pop(pair);
    if (kept) {
      const auto screen = kStates > 1 ? screenMovingPair : screenPair;
      kept = screen(c_, pair.cluster, MemberIndex(pair.a & kMemberMask),
                    MemberIndex(pair.b & kMemberMask), pair.a >> kSharedBitsAt,
                    pair.b >> kSharedBitsAt, candidate);
    }
    candidates_.push(kept, candidate);
    if (candidates_.size >= kWarp) emitCandidates();
  }

  __device__ void emitCandidates() {
    DeviceCandidate candidate;
    const bool has = candidates_.pop(candidate);
    const unsigned long long place = warpReserve(&c_.counters().candidates, has);
    if (has && place < c_.contacts.candidates.size()) {
      c_.contacts.candidates[Place(static_cast<std::uint32_t>(place))] = candidate;
    }
  }

  const CycleArrays& c_;
  WarpQueue<std::uint32_t, kAxisPairCapacity> axis_pairs_;
  WarpQueue<BoxPair, kQueueCapacity> box_pairs_;
  WarpQueue<DeviceCandidate, kQueueCapacity> candidates_;
  WorkUnit unit_{};
  PackedBox box_{};
  std::uint32_t begin_ = 0, end_ = 0, length_ = 0;  // of this lane's row's columns
  std::uint32_t step_ = 0, longest_ = 0;
};

// Warps for sweep.units: reads the arrays of `sweep` and members.members, adds to
// contacts.candidates.
template <int kStates>
__global__ void __launch_bounds__(kThreads, kBlocksEach) sweepKernel(CycleArrays c) {
  awaitKernelAhead();
  extern __shared__ __align__(16) unsigned char shared_memory[];
  Sweeper<kStates> sweeper(c, reinterpret_cast<WarpMemory*>(shared_memory)[threadIdx.x / kWarp]);
  sweeper.run();
}

}  // namespace

void launchSweep(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  constexpr unsigned kBytes = kWarps * sizeof(WarpMemory);
  static_assert(kBytes <= 48 * 1024);
  const auto kernel = shape.swept ? sweepKernel<2> : sweepKernel<1>;
  launchEarly(kernel, blocksInOneWave(kernel, kThreads, kBytes, shape.device), kThreads, kBytes,
              shape.device, stream, cycle);
}

}  // namespace deformable_contact_monitor
