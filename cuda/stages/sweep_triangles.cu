// Stage sweep, second part: tests triangles against triangles within the pairs of tiles that the
// first part found. One warp works on each pair. It also gives verdicts: with exact predicates and
// no margins, float32 decides most pairs here, with a proven error bound. Only the others become
// candidates for the narrow phase. The pairs that a test leaves go through a short queue, so that
// every test runs on full warps.
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/memory/cycle_arrays.cuh"
#include "cuda/stages/cut_off.cuh"
#include "cuda/stages/found_pairs.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/sweep_parts.cuh"
#include "cuda/stages/swept_pairs.cuh"

namespace deformable_contact_monitor {
namespace {

// Numbers the pieces of work: first each tile against itself, if any body may have contacts with
// itself, then dense pairs of tiles, then other pairs. If pairs are halved, each half has a number.
// The struct lies in shared memory, because registers are scarce.
struct ScheduleNumbers {
  std::uint32_t tiles, dense_end, end;
  std::uint32_t halves_dense, halves_others;  // 1 if these pairs are halved, otherwise 0

  // Computes the numbers for a grid of `warps` warps.
  __device__ void set(const CycleArrays& c, std::uint32_t warps) {
    tiles = c.params().any_self != 0 ? c.scene.tile_count : 0;
    const std::uint32_t dense = min(c.counters().dense_pairs, c.sweep.dense_pairs.size());
    const std::uint32_t others = min(c.counters().tile_pairs, c.sweep.tile_pairs.size());
    // If there are at most so many pairs for each warp, they are halved. Otherwise the last pair
    // would keep one warp busy when the others have ended. Each half repeats the work at the
    // beginning of a pair.
    constexpr std::uint32_t kFewEach = 2;
    const bool divides = c.params().passes == 1;  // passes divide pairs too
    halves_dense = divides && dense <= kFewEach * warps ? 1 : 0;
    halves_others = divides && tiles + dense + others <= kFewEach * warps ? 1 : 0;
    dense_end = tiles + (dense << halves_dense);
    end = dense_end + (others << halves_others);
  }
};

// Hands out numbers to one warp of a grid. The grid has one dimension; all lanes make each call.
class PairSchedule {
 public:
  __device__ PairSchedule(const CycleArrays& c, ScheduleNumbers& numbers)
      : c_(c), numbers_(numbers), turn_((blockIdx.x * blockDim.x + threadIdx.x) / kWarp) {
    if (laneId() == 0) numbers.set(c, warps());
    __syncwarp();
    halves_pairs_ = (numbers.halves_dense | numbers.halves_others) != 0;
  }

  // Returns whether some pairs are done in two parts.
  __device__ bool halvesPairs() const { return halves_pairs_; }

  // Requests the next number. The first numbers are assigned in a fixed way, the others go to any
  // warp that is free. Some pairs have hundreds of triangles that meet; most have few, and those
  // come last. Call it when the last pair's triangles have been taken, so that other work hides the
  // latency.
  __device__ void askForNext() {
    if (laneId() == 0 && number_ + 1 >= run_end_) {
      turn_ = warps() + atomicAdd(&c_.counters().pairs_taken, 1U);
    }
  }
  // Moves on to the next number of this run, or to another run. Returns false if none is left.
  __device__ bool take() {
    if (++number_ >= run_end_) beginRun();
    return number_ < numbers_.end;
  }

  __device__ std::uint32_t number() const { return number_; }
  // Returns whether the work is tile() against itself. Otherwise it is part() of the parts() parts
  // of pair(), which are one or two.
  __device__ bool isSelf() const { return number_ < numbers_.tiles; }
  __device__ TileIndex tile() const { return TileIndex(number_); }
  __device__ TilePair pair() const {
    const Place place(numberOfKind() >> halves());
    const TilePair& at = isDense() ? c_.sweep.dense_pairs[place] : c_.sweep.tile_pairs[place];
    const auto both = reinterpret_cast<const uint2&>(at);  // the compiler would make two loads
    return {TileIndex(both.x), TileIndex(both.y)};
  }
  __device__ std::uint32_t part() const { return isSelf() ? 0 : numberOfKind() & (parts() - 1); }
  __device__ std::uint32_t parts() const { return 1U + halves(); }

 private:
  // Other pairs are taken in runs of kRun, except the last kRun * warps() of them, which are taken
  // singly. Additions to one counter are made one after the other, so a hundred thousand of them
  // would make all warps wait.
  static constexpr std::uint32_t kRun = 4;

  __device__ static std::uint32_t warps() { return gridDim.x * (blockDim.x / kWarp); }
  __device__ bool isDense() const { return number_ < numbers_.dense_end; }
  __device__ std::uint32_t numberOfKind() const {
    return number_ - (isDense() ? numbers_.tiles : numbers_.dense_end);
  }
  __device__ std::uint32_t halves() const {
    if (!halves_pairs_ || isSelf()) return 0;
    return isDense() ? numbers_.halves_dense : numbers_.halves_others;
  }

  __device__ void beginRun() {
    number_ = __shfl_sync(kFullWarp, turn_, 0);
    run_end_ = number_ + 1;
    if (isDense()) return;
    const std::uint32_t others = numbers_.end - numbers_.dense_end;
    const std::uint32_t runs = (others - min(others, kRun * warps())) / kRun;
    const std::uint32_t ahead = min(number_ - numbers_.dense_end, runs);
    number_ += ahead * (kRun - 1);
    run_end_ = number_ + (ahead < runs ? kRun : 1);
  }

  const CycleArrays& c_;
  const ScheduleNumbers& numbers_;
  // The next turn of this warp, in the first lane. It is a number, except that a run counts as one.
  std::uint32_t turn_;
  std::uint32_t number_ = 0, run_end_ = 0;
  bool halves_pairs_;
};

constexpr unsigned kThreads = 128;
constexpr unsigned kWarps = kThreads / kWarp;
constexpr unsigned kLogWarp = 5;
static_assert(1U << kLogWarp == kWarp);
// Blocks on each multiprocessor, as far as registers allow.
constexpr unsigned kBlocksEach = 7;

// Two tile entries whose boxes meet.
struct alignas(8) EntryPair {
  TileEntryIndex a, b;
};

constexpr unsigned kHitCapacity = 8 * kWarp;
constexpr unsigned kMetCapacity = 2 * kWarp, kAdjacentCapacity = 2 * kWarp;
constexpr unsigned kCandidateCapacity = 3 * kWarp;  // less than a warp, and what both filters add

struct WarpMemory {
  SlotBox boxes[2 * kWarp];  // the rows, then the columns; of a tile with itself a whole ring
  EntryPair hits[kHitCapacity];
  EntryPair met[kMetCapacity], adjacent[kAdjacentCapacity];
  DeviceCandidate candidates[kCandidateCapacity];
  ScheduleNumbers turns;
};

// A warp asks once in so many pairs of tiles whether the cycle is cut off; a pair takes some
// microseconds.
constexpr std::uint32_t kPairsPerAsker = 64;

// The work of one warp. All lanes make each call. kStates == 2 in swept motion; kAdjacent:
// triangles that share vertices may be contacts.
template <int kStates, bool kAdjacent>
class PairFilter {
 public:
  __device__ PairFilter(const CycleArrays& c, WarpMemory& memory)
      : c_(c),
        memory_(memory),
        hits_{memory.hits},
        met_{memory.met},
        adjacent_{memory.adjacent},
        candidates_{memory.candidates},
        lane_(laneId()),
        ids_(vertexIds(c)),
        passes_(c.params().passes),
        schedule_(c, memory.turns),
        divides_(passes_ != 1 || schedule_.halvesPairs()) {}

  // Runs each part when it has enough work for a full warp, until nothing is left. Each part is
  // called from one place only, so that the code fits the instruction cache.
  __device__ void run() {
    bool more = true;
    while (true) {
      while (more && hits_.size < kWarp) more = takePair();
      if (hits_.size > 0) takeHits();
      const bool last_met = hits_.size == 0 && !more;
      if (met_.size >= kWarp || (last_met && met_.size > 0)) filterMet();
      if (kAdjacent && (adjacent_.size >= kWarp || (last_met && adjacent_.size > 0))) {
        filterAdjacent();
      }
      const bool last = last_met && met_.size == 0 && adjacent_.size == 0;
      // Less than a warp must be left, because both filters may add a warp before the next time.
      while (candidates_.size >= kWarp || (last && candidates_.size > 0)) decideCandidates();
      if (last) break;
    }
    addOverlaps();
  }

 private:
  // Takes the next pair of tiles, or a tile against itself. Returns false if there is none or the
  // cycle is cut off.
  __device__ bool takePair() {
    if (resumed_ == 0 && !schedule_.take()) return false;
    if (++taken_ % kPairsPerAsker == 0) {
      addOverlaps();
      if (warpIsCutOff(c_, schedule_.number() % kWarpsPerAsker == 0)) return false;
    }
    if (!schedule_.isSelf()) {
      layOut(schedule_.pair());
    } else if (c_.scene.bodies[c_.scene.tile_body[schedule_.tile()]].has_self != 0) {
      layOutSelf(schedule_.tile());
    }
    if (resumed_ == 0) schedule_.askForNext();
    return true;
  }
  // Adds the tested pairs to the counter, except in cycles of several passes, which test the same
  // pairs again.
  __device__ void addOverlaps() {
    if (lane_ == 0 && overlaps_ != 0 && passes_ == 1) {
      atomicAdd(&c_.counters().interval_overlaps, 1ULL * overlaps_);
    }
    overlaps_ = 0;
  }

  // Selects the triangles of each tile that meet the other tile's box and diagonals, and tests
  // their boxes against each other. Those of the first tile are rows; each row is assigned to 32 /
  // (rows, rounded up to a power of two) lanes. Those of the second tile are columns; the lanes of
  // a row divide them.
  __device__ void layOut(const TilePair& pair) {
    const TileState a = c_.tiles.states[pair.a], b = c_.tiles.states[pair.b];
    const TileBounds &bounds_a = c_.tiles.bounds[pair.a], &bounds_b = c_.tiles.bounds[pair.b];
    const SlotBox box_a = bounds_a.boxes[lane_], box_b = bounds_b.boxes[lane_];
    const DiagonalBox diagonals_a = bounds_a.diagonals[lane_];
    const DiagonalBox diagonals_b = bounds_b.diagonals[lane_];
    // The loads do not depend on each other: && would start some after the others have arrived.
    bool reaches_b = intersects(b.axes, box_a.box()), reaches_a = intersects(a.axes, box_b.box());
    reaches_b &= intersects(diagonals_a, b.diagonals);
    reaches_a &= intersects(diagonals_b, a.diagonals);
    const unsigned in_a = a.live & __ballot_sync(kFullWarp, reaches_b);
    const unsigned in_b = b.live & __ballot_sync(kFullWarp, reaches_a);
    const std::uint32_t rows = __popc(in_a), columns = __popc(in_b);
    if (rows == 0 || columns == 0) return;
    if (resumed_ == 0 && (!divides_ || schedule_.part() == 0)) overlaps_ += rows * columns;
    leave(in_a, box_a);
    const unsigned shift = rows > 1 ? 32 - __clz(static_cast<int>(rows - 1)) : 0;
    const std::uint32_t row = lane_ & ((1U << shift) - 1);
    const SlotBox box = memory_.boxes[row];
    leave(in_b, box_b);
    const unsigned stride = kWarp >> shift, log_stride = kLogWarp - shift, first = lane_ >> shift;
    const std::uint32_t own_steps = (columns + stride - 1 - first) >> log_stride;
    listHits(box, first, stride, row < rows ? own_steps : 0, (columns + stride - 1) >> log_stride);
  }
  // Tests the triangles of a tile against each other. Places them on a ring and tests each against
  // those up to halfway round, so that each pair is tested once and all lanes have equal work.
  // Pairs that share a vertex by its number are left out at once, if they cannot be contacts or if
  // all three vertices of one have certified fans, which decide them.
  __device__ void layOutSelf(TileIndex tile) {
    constexpr unsigned kSteps = kWarp / 2;
    const unsigned live = c_.tiles.states[tile].live;
    const std::uint32_t count = __popc(live);
    if (count == 0) return;
    if (resumed_ == 0) overlaps_ += count * (count - 1) / 2;
    const std::uint32_t at = tile.value * kWarp + lane_;
    const bool mine = (live >> lane_ & 1) != 0;
    const SlotBox box = c_.tiles.bounds[tile].boxes[lane_];
    __syncwarp();
    memory_.boxes[lane_] = memory_.boxes[lane_ + kWarp] = box;
    __syncwarp();
    unsigned wanted = mine ? live : 0;
    const bool by_fans = kAdjacent && kStates == 1 && ids_ != nullptr;
    const bool decided = !kAdjacent || (by_fans && certifiedBits(ids_[at]) == kAllVertices);
    if (decided) wanted &= ~c_.scene.slot_neighbours[TileEntryIndex(at)];
    listHits(box, lane_ + 1, 1, lane_ < kSteps ? kSteps : kSteps - 1, kSteps,
             __funnelshift_r(wanted, wanted, lane_ + 1));
  }
  // Writes the boxes of the lanes in the bit mask `in` to the first places of memory_.boxes.
  __device__ void leave(unsigned in, const SlotBox& box) {
    __syncwarp();
    if ((in >> lane_ & 1) != 0) {
      const std::uint32_t place = __popc(in & ((1U << lane_) - 1));
      memory_.boxes[place] = box;
    }
    __syncwarp();
  }

  // Lists the columns that meet the box of this lane's row. The lane tests the columns `first`,
  // `first` + `stride` and so on, `own_steps` in all; `steps` is the most that a lane tests.
  // Several parts or passes divide the steps. If the list gets full, the rest is left to another
  // call. `wanted` has a bit for each step that counts.
  __device__ void listHits(const SlotBox& row, std::uint32_t first, std::uint32_t stride,
                           std::uint32_t own_steps, std::uint32_t steps,
                           unsigned wanted = kFullWarp) {
    std::uint32_t every = 1, step = resumed_;
    if (divides_) {
      every = passes_ == 1 ? schedule_.parts() : passes_;
      if (step == 0) step = firstStep();
    }
    const TurnedAxisBox box(row.box());
    const SlotBox* other = memory_.boxes + first + step * stride;
    // A step beyond the last one reads some other box, and hits nothing.
    const std::uint32_t next = min(every, steps) * stride;
    const unsigned below = lanesBelow();
    constexpr unsigned kAtOnce = 2;
    while (step < steps && hits_.size <= kHitCapacity - kAtOnce * kWarp) {
#pragma unroll
      for (unsigned k = 0; k < kAtOnce; ++k) {
        const bool hit = (step < own_steps) & intersects(box, other->box()) &
                         ((wanted >> (step % kWarp) & 1) != 0);
        const unsigned mask = __ballot_sync(kFullWarp, hit);
        if (hit) {
          hits_.items[hits_.size + __popc(mask & below)] = {row.slot, other->slot};
        }
        hits_.size += __popc(mask);
        step += every;
        other += next;
      }
    }
    resumed_ = step < steps ? step : 0;
    __syncwarp();
  }

  // Returns the first step of this part of a pair, or of this pass.
  __device__ std::uint32_t firstStep() const {
    if (passes_ == 1) return schedule_.part();
    return (c_.params().pass + passes_ - schedule_.number() % passes_) % passes_;
  }

  // Takes a warp of hits, and drops those that are apart along a diagonal. Pairs that share
  // vertices are dropped too, or go to a queue of their own.
  __device__ void takeHits() {
    EntryPair pair{TileEntryIndex(0), TileEntryIndex(0)};
    const bool has = hits_.pop(pair);
    // All loads are started before any of them is waited for.
    DiagonalBox diagonals_a{}, diagonals_b{};
    uint4 a{}, b{};
    if (has) {
      diagonals_a = c_.tiles.diagonalsOf(pair.a);
      diagonals_b = c_.tiles.diagonalsOf(pair.b);
      if (ids_ != nullptr) {
        a = ids_[pair.a.value];
        b = ids_[pair.b.value];
      }
    }
    const bool meet = has && intersects(diagonals_a, diagonals_b);
    std::uint32_t shared = 0;
    bool certified = false;
    if (ids_ != nullptr && meet) {
      if (kAdjacent) {
        shared = sharedBits(a, b);
        certified = (shared & certifiedBits(a)) != 0;
      } else {
        shared = shareVertices(a, b) ? 1 : 0;
      }
    }
    met_.push(meet && shared == 0, pair);
    if (!kAdjacent) return;
    const bool open = meet && shared != 0 && !certified;
    if (__any_sync(kFullWarp, open) != 0) adjacent_.push(open, pair);
  }

  // Filters queued pairs by planes. In swept motion it uses moving boxes instead, and the partition
  // to which the pair belongs.
  __device__ void filterMet() {
    EntryPair pair{TileEntryIndex(0), TileEntryIndex(0)};
    DeviceCandidate candidate{};
    bool kept = met_.pop(pair);
    if (kept) kept = filter(pair, 0, 0, candidate);
    candidates_.push(kept, candidate);
  }
  // Does the same for pairs that share vertices.
  __device__ void filterAdjacent() {
    EntryPair pair{TileEntryIndex(0), TileEntryIndex(0)};
    DeviceCandidate candidate{};
    bool kept = adjacent_.pop(pair);
    if (kept) {
      const uint4 a = c_.tiles.ids[pair.a], b = c_.tiles.ids[pair.b];
      kept = filter(pair, sharedBits(a, b), sharedBits(b, a), candidate);
    }
    candidates_.push(kept, candidate);
  }
  __device__ bool filter(const EntryPair& pair, std::uint32_t shared_a, std::uint32_t shared_b,
                         DeviceCandidate& candidate) const {
    const auto filter = kStates > 1 ? filterMovingPair : filterPair;
    return filter(c_, pair.a, pair.b, shared_a, shared_b, candidate);
  }

  // Makes the last tests of the filters, decides the pairs of which float32 is certain, and leaves
  // the others to the narrow phase as candidates. Few pairs come this far.
  __device__ void decideCandidates() {
    DeviceCandidate candidate;
    bool open = candidates_.pop(candidate);
    if (kStates == 1) {
      const bool decides = c_.params().decides != 0;
      PartVerdict verdict = PartVerdict::kOpen;
      TriangleIndex a(0), b(0);
      if (open) {
        const TileEntry entry_a = c_.tiles.at(candidate.a);
        const TileEntry entry_b = c_.tiles.at(candidate.b);
        a = entry_a.triangle;
        b = entry_b.triangle;
        open = isCandidateHere(c_, entry_a, entry_b, candidate);
        if (open && decides) {
          verdict = certainVerdict(entry_a.posed, entry_b.posed, unpackFacts(candidate.facts));
        }
      }
      const unsigned decided = __ballot_sync(kFullWarp, verdict != PartVerdict::kOpen);
      if (decided != 0) {
        if (laneId() == 0) atomicAdd(&c_.counters().decided, 1ULL * __popc(decided));
        reportContacts(c_, verdict == PartVerdict::kMeet, a, b, 0);
      }
      open = open && verdict == PartVerdict::kOpen;
    }
    const unsigned long long place = warpReserve(&c_.counters().candidates, open);
    const bool has_room = open && putCandidate(c_, place, candidate);
    if (c_.params().leaves_few != 0) {
      const bool adjacent = sharedBitsOf(candidate) != 0;
      reportOpen(c_, has_room, adjacent, Place(static_cast<std::uint32_t>(place)));
    }
  }

  const CycleArrays& c_;
  WarpMemory& memory_;
  WarpQueue<EntryPair, kHitCapacity> hits_;
  WarpQueue<EntryPair, kMetCapacity> met_;
  WarpQueue<EntryPair, kAdjacentCapacity> adjacent_;
  WarpQueue<DeviceCandidate, kCandidateCapacity> candidates_;
  const std::uint32_t lane_;
  const uint4* const ids_;
  const std::uint32_t passes_;
  PairSchedule schedule_;
  const bool divides_;  // pairs of tiles are done in several parts, or in several passes
  std::uint32_t taken_ = 0;
  std::uint32_t resumed_ = 0;  // the step from which this pair is to be taken up again; 0: none
  std::uint32_t overlaps_ = 0;
};

// Warps take the tiles, sweep.dense_pairs and sweep.tile_pairs. Reads the arrays of `tiles`; adds
// to contacts.candidates and contacts.contacts.
template <int kStates, bool kAdjacent>
__global__ void __launch_bounds__(kThreads, kBlocksEach) sweepTrianglesKernel(CycleArrays c) {
  __shared__ WarpMemory memory[kWarps];
  awaitPreviousKernel();
  PairFilter<kStates, kAdjacent> filter(c, memory[threadIdx.x / kWarp]);
  filter.run();
}

}  // namespace

void launchSweepTriangles(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  const auto of = [&shape](auto plain, auto adjacent) { return shape.adjacent ? adjacent : plain; };
  const auto kernel = shape.swept
                          ? of(sweepTrianglesKernel<2, false>, sweepTrianglesKernel<2, true>)
                          : of(sweepTrianglesKernel<1, false>, sweepTrianglesKernel<1, true>);
  const unsigned blocks = blocksInOneWave(kernel, kThreads, 0, shape.device);
  launchDependent(kernel, blocks, kThreads, 0, shape.device, stream, cycle);
}

}  // namespace deformable_contact_monitor
