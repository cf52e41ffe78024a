// Stage sweep. Warps take work units; what their boxes leave goes through short queues, so that
// every test runs on full warps.
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/cut_off.cuh"
#include "cuda/stages/report.cuh"
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

// A row and a column of a unit that meet along the cluster's axes: lane of the row | column << 5.
using Hit = std::uint16_t;
static_assert(kMostUnitColumns << 5 <= 1U << 16);

// Two members whose boxes meet along the cluster's axes and in the scene frame.
struct BoxPair {
  std::uint32_t a, b;  // members | shared vertices << kSharedBitsAt
  ClusterIndex cluster;
};
constexpr unsigned kSharedBitsAt = 29;
constexpr std::uint32_t kMemberMask = (1U << kSharedBitsAt) - 1;

// How many columns of each row are swept at once.
constexpr std::uint32_t kStep = 16;
constexpr unsigned kHitCapacity = kWarp * (kStep + 1);
constexpr unsigned kQueueCapacity = 2 * kWarp;

struct WarpMemory {
  Hit hits[kHitCapacity];
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
      : c_(c), hits_{memory.hits}, box_pairs_{memory.box_pairs}, candidates_{memory.candidates} {}

  // Each part has one place in this loop: the code must fit the instruction cache.
  __device__ void run() {
    bool more_units = true;
    while (true) {
      const bool swept = step_ >= longest_;
      const bool no_more_hits = !more_units && hits_.size == 0;
      if (candidates_.size >= kWarp ||
          (no_more_hits && box_pairs_.size == 0 && candidates_.size > 0)) {
        settleCandidates();
      } else if (box_pairs_.size >= kWarp || (no_more_hits && box_pairs_.size > 0)) {
        screenBoxPairs();
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
    const CycleParams& params = c_.params();
    const std::uint32_t turn = nextTurn();
    const std::uint32_t all = min(c_.counters().units, c_.sweep.units.size());
    // The pass has as many as there are numbers turn * passes + pass below `all`.
    if (all <= params.pass || turn > (all - params.pass - 1) / params.passes) return false;
    if (turn % kUnitsPerAsker == 0 && turn >= gridDim.x * kWarps && warpIsCutOff(c_, true)) {
      if (laneId() == 0) atomicMax(&c_.counters().units_taken, kGivenUp);
      return false;
    }
    unit_ = c_.sweep.units[Place(turn * params.passes + params.pass)];
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

  // Boxes in the scene frame.
  __device__ bool boxesMeet(SortedIndex row, SortedIndex column) const {
    const uint4 a = c_.sweep.world_boxes[row], b = c_.sweep.world_boxes[column];
    if (kStates == 1) {
      return intersects(PackedBox{a.x, a.y}, PackedBox{b.x, b.y}) &
             intersects(PackedBox{a.z, a.w}, PackedBox{b.z, b.w});
    }
    return mayMeet({{a.x, a.y}, {a.z, a.w}, c_.sweep.moving_z[row]},
                   {{b.x, b.y}, {b.z, b.w}, c_.sweep.moving_z[column]});
  }

  // Boxes, and shared vertices. Both are fetched at once: one after the other would be waited for.
  __device__ void screenHits() {
    Hit hit = 0;
    bool kept = hits_.pop(hit);
    const SortedIndex row = unit_.first_row + (hit & 31U);
    const SortedIndex column(__shfl_sync(kFullWarp, begin_, hit & 31) + (hit >> 5));
    BoxPair pair;
    if (kept) {
      const bool meet = boxesMeet(row, column);
      const uint4 a = c_.sweep.ids[row], b = c_.sweep.ids[column];
      const std::uint32_t shared_a = sharedBits(a, b);
      const std::uint32_t shared_b = shared_a == 0 ? 0 : sharedBits(b, a);
      kept = meet && (shared_a == 0 || (c_.params().adjacent == AdjacentPairs::kBeyondShared &&
                                        !isCertified(a, shared_a)));
      pair = {a.w | shared_a << kSharedBitsAt, b.w | shared_b << kSharedBitsAt, unit_.cluster};
    }
    box_pairs_.push(kept, pair);
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
  }

  // Verdicts of which float32 is certain; the other candidates are for the judge.
  __device__ void settleCandidates() {
    DeviceCandidate candidate;
    bool open = candidates_.pop(candidate);
    if (kStates == 1 && c_.params().settles != 0) {
      PartVerdict verdict = PartVerdict::kOpen;
      TriangleIndex a(0), b(0);
      if (open) {
        const Member member_a = c_.members.members[candidate.a];
        const Member member_b = c_.members.members[candidate.b];
        a = member_a.triangle;
        b = member_b.triangle;
        verdict = certainVerdict(member_a.posed, member_b.posed, unpackFacts(candidate.facts));
      }
      const unsigned settled = __ballot_sync(kFullWarp, verdict != PartVerdict::kOpen);
      if (laneId() == 0) atomicAdd(&c_.counters().settled, 1ULL * __popc(settled));
      reportContacts(c_, verdict == PartVerdict::kMeet, a, b, 0);
      open = open && verdict == PartVerdict::kOpen;
    }
    const unsigned long long place = warpReserve(&c_.counters().candidates, open);
    if (open && place < c_.contacts.candidates.size()) {
      c_.contacts.candidates[Place(static_cast<std::uint32_t>(place))] = candidate;
    }
  }

  const CycleArrays& c_;
  WarpQueue<Hit, kHitCapacity> hits_;
  WarpQueue<BoxPair, kQueueCapacity> box_pairs_;
  WarpQueue<DeviceCandidate, kQueueCapacity> candidates_;
  WorkUnit unit_{};  // of no rows before the first
  PackedBox box_{};
  std::uint32_t begin_ = 0, end_ = 0, length_ = 0;  // of this lane's row's columns
  std::uint32_t step_ = 0, longest_ = 0;
};

// Warps for sweep.units: reads the arrays of `sweep` and members.members, adds to
// contacts.candidates and contacts.contacts.
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
