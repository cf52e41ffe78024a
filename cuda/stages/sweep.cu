// Fourth stage: the sweep. Warps take work units; what their boxes leave goes through two short
// queues, so that every test runs on full warps.
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/screen.cuh"
#include "cuda/stages/stages.cuh"

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

struct Meeting {
  std::uint32_t a, b;  // members | shared vertices << 29
  std::uint32_t cluster;
};
constexpr unsigned kSharedBitsAt = 29;
constexpr std::uint32_t kMemberMask = (1U << kSharedBitsAt) - 1;

constexpr unsigned kHitCapacity = kWarp * (kWarp + 1);
constexpr unsigned kQueueCapacity = 2 * kWarp;

struct WarpMemory {
  std::uint32_t hits[kHitCapacity];  // lane of the row | column in the unit << 5
  Meeting meetings[kQueueCapacity];
  Candidate candidates[kQueueCapacity];
};

class Sweeper {
 public:
  __device__ Sweeper(const CycleView& c, WarpMemory& memory)
      : c_(c), hits_{memory.hits}, meetings_{memory.meetings}, candidates_{memory.candidates} {}

  // Each stage has one place in this loop: the code must fit the instruction cache.
  __device__ void run() {
    const std::uint32_t warps = gridDim.x * kWarps;
    // The first units are dealt out; the others go to whoever is free.
    std::uint32_t turn = (blockIdx.x * kThreads + threadIdx.x) / kWarp;
    bool more_units = true;
    while (true) {
      const bool swept = step_ >= longest_;
      if (meetings_.size >= kWarp || (!more_units && hits_.size == 0 && meetings_.size > 0)) {
        screenMeetings();
      } else if (hits_.size >= kWarp || (swept && hits_.size > 0)) {
        screenHits();
      } else if (!swept) {
        sweepColumns();
      } else if (more_units) {
        more_units = takeUnit(turn);
        if (more_units && laneId() == 0) turn = warps + atomicAdd(&c_.counters->units_taken, 1U);
        turn = __shfl_sync(kFullWarp, turn, 0);
      } else {
        break;
      }
    }
    emitCandidates();
  }

 private:
  __device__ bool takeUnit(std::uint32_t turn) {
    const std::uint32_t index = turn * c_.params->passes + c_.params->pass;
    if (index >= min(c_.counters->units, c_.unit_capacity)) return false;
    unit_ = c_.units[index];
    const std::uint32_t rows = unit_.rows_and_classes & 0xff;
    const std::uint32_t row = unit_.first_row + min(laneId(), rows - 1);
    const ColumnRange range =
        columnsOf(c_.bucket_begin + std::size_t{unit_.cluster} * (kBuckets + 1),
                  32768U >> c_.params->bucket_shift, unit_.rows_and_classes >> 8 & 0xff,
                  unit_.rows_and_classes >> 16, row, c_.sweep_keys[row]);
    begin_ = range.begin + unit_.first_column;
    end_ = range.end;
    length_ = 0;
    if (laneId() < rows && begin_ < end_) length_ = min(end_ - begin_, c_.params->unit_columns);
    box_ = c_.sweep_boxes[row];
    longest_ = warpMost(length_);
    step_ = 0;
    return true;
  }

  // Up to a warp of columns for each of the rows.
  __device__ void sweepColumns() {
    // A row that is done reads on from its end; places beyond the last member are there.
    const PackedBox* columns = c_.sweep_boxes + min(begin_ + step_, end_);
    unsigned mask = 0;
#pragma unroll
    for (unsigned first = 0; first < kWarp; first += kLeastUnitColumns) {
      if (first > 0 && step_ + first >= longest_) break;
#pragma unroll
      for (unsigned k = first; k < first + kLeastUnitColumns; ++k) {
        if (overlap(box_, columns[k])) mask |= 1U << k;
      }
    }
    const std::uint32_t left = length_ > step_ ? length_ - step_ : 0;
    if (left < kWarp) mask &= (1U << left) - 1;
    std::uint32_t total;
    std::uint32_t place = hits_.size + warpPrefix(__popc(mask), total);
    for (; mask != 0; mask &= mask - 1) {
      const std::uint32_t k = __ffs(static_cast<int>(mask)) - 1;
      hits_.items[place++] = laneId() | (step_ + k) << 5;
    }
    hits_.size += total;
    step_ += kWarp;
    __syncwarp();
  }

  // Boxes in the scene frame, and shared vertices.
  __device__ void screenHits() {
    std::uint32_t hit = 0;
    bool met = hits_.pop(hit);
    const std::uint32_t row = unit_.first_row + (hit & 31);
    const std::uint32_t column = __shfl_sync(kFullWarp, begin_, hit & 31) + (hit >> 5);
    Meeting meeting;
    if (met) {
      const uint4 a = c_.world_boxes[row], b = c_.world_boxes[column];
      met = overlap(PackedBox{a.x, a.y}, PackedBox{b.x, b.y}) &&
            overlap(PackedBox{a.z, a.w}, PackedBox{b.z, b.w});
    }
    if (met) {
      const uint4 a = c_.sweep_ids[row], b = c_.sweep_ids[column];
      const std::uint32_t shared_a = sharedBits(a, b);
      met = shared_a == 0 || c_.params->adjacent == AdjacentPairs::kBeyondShared;
      const std::uint32_t shared_b = shared_a == 0 ? 0 : sharedBits(b, a);
      meeting = {a.w | shared_a << kSharedBitsAt, b.w | shared_b << kSharedBitsAt, unit_.cluster};
    }
    meetings_.push(met, meeting);
  }

  __device__ void screenMeetings() {
    Meeting m;
    Candidate candidate;
    bool kept = meetings_.pop(m);
    if (kept) {
      kept = isCandidate(c_, m.cluster, m.a & kMemberMask, m.b & kMemberMask, m.a >> kSharedBitsAt,
                         m.b >> kSharedBitsAt, candidate);
    }
    candidates_.push(kept, candidate);
    if (candidates_.size >= kWarp) emitCandidates();
  }

  __device__ void emitCandidates() {
    Candidate candidate;
    const bool has = candidates_.pop(candidate);
    const unsigned long long place = warpReserve(&c_.counters->candidates, has);
    if (has && place < c_.candidate_capacity) c_.candidates[place] = candidate;
  }

  const CycleView& c_;
  WarpQueue<std::uint32_t, kHitCapacity> hits_;
  WarpQueue<Meeting, kQueueCapacity> meetings_;
  WarpQueue<Candidate, kQueueCapacity> candidates_;
  WorkUnit unit_{};
  PackedBox box_{};
  std::uint32_t begin_ = 0, end_ = 0, length_ = 0;  // of this lane's row's columns
  std::uint32_t step_ = 0, longest_ = 0;
};

__global__ void __launch_bounds__(kThreads, kBlocksEach) sweepKernel(CycleView c) {
  awaitKernelAhead();
  extern __shared__ __align__(16) unsigned char shared_memory[];
  Sweeper sweeper(c, reinterpret_cast<WarpMemory*>(shared_memory)[threadIdx.x / kWarp]);
  sweeper.run();
}

}  // namespace

void launchSweep(const CycleView& cycle, const DeviceTraits& device, cudaStream_t stream) {
  constexpr unsigned kBytes = kWarps * sizeof(WarpMemory);
  static_assert(kBytes <= 48 * 1024);
  launchEarly(sweepKernel, blocksInOneWave(sweepKernel, kThreads, kBytes, device), kThreads, kBytes,
              device, stream, cycle);
}

}  // namespace deformable_contact_monitor
