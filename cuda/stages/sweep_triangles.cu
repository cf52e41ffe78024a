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
// itself, then dense pairs of tiles, then other pairs. If pairs are divided into parts, each part
// has a number. The struct lies in shared memory, because registers are scarce.
struct ScheduleNumbers {
  std::uint32_t tiles, dense_end, end;
  std::uint32_t log_dense_parts, log_parts;

  // Computes the numbers for a grid of `warps` warps.
  __device__ void set(const CycleArrays& c, std::uint32_t warps) {
    tiles = c.params().any_self != 0 ? c.scene.tile_count : 0;
    const std::uint32_t dense = min(c.counters().dense_pairs, c.sweep.dense_pairs.size());
    const std::uint32_t others = min(c.counters().tile_pairs, c.sweep.tile_pairs.size());
    const std::uint32_t most = kPartsEach * warps / max(tiles + dense + others, 1U);
    const std::uint32_t log_most = most == 0 ? 0 : 31 - __clz(static_cast<int>(most));
    log_parts = min(log_most, kMostLogParts);
    log_dense_parts = max(log_parts, dense <= kDenseEach * warps ? 1U : 0U);
    dense_end = tiles + (dense << log_dense_parts);
    end = dense_end + (others << log_parts);
  }

 private:
  // If pairs are few, they are divided into parts, at most kPartsEach for each warp. Otherwise the
  // last pair would keep one warp busy when the others have ended. A pair has at most
  // 2^kMostLogParts parts, because each part repeats the work at the beginning of a pair.
  static constexpr std::uint32_t kPartsEach = 4, kMostLogParts = 3;
  // Dense pairs are divided into at least two parts, unless there are more than so many for each
  // warp.
  static constexpr std::uint32_t kDenseEach = 2;
};

// Hands out numbers to one warp of a grid. The grid has one dimension; all lanes make each call.
class PairSchedule {
 public:
  __device__ PairSchedule(const CycleArrays& c, ScheduleNumbers& numbers)
      : c_(c), numbers_(numbers), turn_((blockIdx.x * blockDim.x + threadIdx.x) / kWarp) {
    if (laneId() == 0) numbers.set(c, warps());
    __syncwarp();
  }

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
  // of pair().
  __device__ bool isSelf() const { return number_ < numbers_.tiles; }
  __device__ TileIndex tile() const { return TileIndex(number_); }
  __device__ const TilePair& pair() const {
    const Place place(numberOfKind() >> logParts());
    return isDense() ? c_.sweep.dense_pairs[place] : c_.sweep.tile_pairs[place];
  }
  __device__ std::uint32_t part() const { return numberOfKind() & (parts() - 1); }
  __device__ std::uint32_t parts() const { return 1U << logParts(); }

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
  __device__ std::uint32_t logParts() const {
    return isDense() ? numbers_.log_dense_parts : numbers_.log_parts;
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

// The boxes of a tile's triangles, and their vertices' ids; ids.w is the triangle's place in the
// tile.
struct LaneTriangles {
  float4 low[kWarp], high[kWarp];
  uint4 ids[kWarp];
};

constexpr unsigned kMetCapacity = 4 * kWarp, kAdjacentCapacity = 2 * kWarp;
constexpr unsigned kCandidateCapacity = 2 * kWarp;

struct WarpMemory {
  LaneTriangles triangles;  // of one tile, then of the other
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
        met_{memory.met},
        adjacent_{memory.adjacent},
        candidates_{memory.candidates},
        lane_(laneId()),
        any_self_(c.params().any_self != 0),
        passes_(c.params().passes),
        schedule_(c, memory.turns) {}

  // Runs the part that has enough work for a full warp, until nothing is left. Each part is called
  // from one place only, so that the code fits the instruction cache.
  __device__ void run() {
    bool more = true;
    while (true) {
      const bool last_met = !more && rounds_ == 0;
      if (candidates_.size >= kWarp || (last_met && met_.size == 0 && candidates_.size > 0)) {
        decideCandidates();
      } else if (met_.size >= kWarp || (last_met && met_.size > 0)) {
        filterMet();
      } else if (kAdjacent && (adjacent_.size >= kWarp || (last_met && adjacent_.size > 0))) {
        filterAdjacent();
      } else if (rounds_ != 0) {
        takePartners();
      } else if (more) {
        more = takePair();
      } else {
        break;
      }
    }
    addOverlaps();
  }

 private:
  // Takes the next pair of tiles, or a tile against itself. Returns false if there is none or the
  // cycle is cut off.
  __device__ bool takePair() {
    if (!schedule_.take()) return false;
    if (++taken_ % kPairsPerAsker == 0) {
      addOverlaps();
      if (warpIsCutOff(c_, schedule_.number() % kWarpsPerAsker == 0)) return false;
    }
    if (!schedule_.isSelf()) {
      layOut(schedule_.pair(), schedule_.part(), schedule_.parts());
    } else if (c_.scene.bodies[c_.scene.tile_body[schedule_.tile()]].has_self != 0) {
      layOutSelf(schedule_.tile());
    }
    if (rounds_ == 0) schedule_.askForNext();
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

  // Selects the triangles of each tile that meet the other tile's box, and tests them against each
  // other. Those of the first tile are rows; each row is assigned to 32 / (rows, rounded up to a
  // power of two) lanes. Those of the second tile are columns in memory_.triangles; the lanes of a
  // row divide them. `part`: takes only this one of `parts` parts of the work.
  __device__ void layOut(const TilePair& pair, std::uint32_t part, std::uint32_t parts) {
    const TileState a = c_.tiles.states[pair.a], b = c_.tiles.states[pair.b];
    first_a_ = pair.a.value * kWarp;
    first_b_ = pair.b.value * kWarp;
    const TileEntryIndex at_a(first_a_ + lane_), at_b(first_b_ + lane_);
    const TileEntryBox box_a = c_.tiles.boxes[at_a], box_b = c_.tiles.boxes[at_b];
    const uint4 ids_a = idsAt(at_a), ids_b = idsAt(at_b);
    const unsigned in_a = a.live & __ballot_sync(kFullWarp, intersects(box_a.box(), b.box));
    const unsigned in_b = b.live & __ballot_sync(kFullWarp, intersects(box_b.box(), a.box));
    const std::uint32_t rows = __popc(in_a), columns = __popc(in_b);
    if (rows == 0 || columns == 0) return;
    if (part == 0) overlaps_ += rows * columns;
    const unsigned before = (1U << lane_) - 1;
    leave((in_a >> lane_ & 1) != 0, __popc(in_a & before), box_a, ids_a);
    const unsigned shift = rows > 1 ? 32 - __clz(static_cast<int>(rows - 1)) : 0;
    const std::uint32_t row = lane_ & ((1U << shift) - 1);
    const Aabb box = boxOfPlace(row);
    setRow(memory_.triangles.ids[row]);
    leave((in_b >> lane_ & 1) != 0, __popc(in_b & before), box_b, ids_b);
    first_column_ = lane_ >> shift;
    stride_ = kWarp >> shift;
    const unsigned log_stride = kLogWarp - shift;
    findPartners(box, part, (columns + stride_ - 1) >> log_stride, parts);
    const std::uint32_t own_steps = (columns + stride_ - 1 - first_column_) >> log_stride;
    if (row >= rows || own_steps == 0) partners_ = 0;
    partners_ &= (2U << ((own_steps - 1) % kWarp)) - 1;
    rounds_ = warpMost(__popc(partners_));
  }
  // Tests the triangles of a tile against each other. Places them on a ring and tests each against
  // those up to halfway round, so that each pair is tested once and all lanes have equal work.
  __device__ void layOutSelf(TileIndex tile) {
    constexpr unsigned kSteps = kWarp / 2;
    const unsigned live = c_.tiles.states[tile].live;
    const std::uint32_t count = __popc(live);
    if (count == 0) return;
    overlaps_ += count * (count - 1) / 2;
    first_a_ = first_b_ = tile.value * kWarp;
    const TileEntryIndex at(first_a_ + lane_);
    const TileEntryBox box = c_.tiles.boxes[at];
    const bool mine = (live >> lane_ & 1) != 0;
    leave(mine, lane_, box, idsAt(at));
    setRow(memory_.triangles.ids[lane_]);
    first_column_ = lane_ + 1;
    stride_ = 1;
    findPartners(box.box(), 0, kSteps, 1);
    const unsigned live_after = live >> 1 >> lane_ | live << (kWarp - 1 - lane_);
    if (!mine) partners_ = 0;
    partners_ &= live_after;
    if (lane_ >= kSteps) partners_ &= (1U << (kSteps - 1)) - 1;
    rounds_ = warpMost(__popc(partners_));
  }
  // Writes the triangles of the lanes for which `in` is set to their places in memory_.triangles.
  __device__ void leave(bool in, std::uint32_t place, const TileEntryBox& box, const uint4& ids) {
    __syncwarp();
    if (in) {
      memory_.triangles.low[place] = box.low;
      memory_.triangles.high[place] = box.high;
      memory_.triangles.ids[place] = ids;
    }
    __syncwarp();
  }
  // Sets the ids of this lane's row. If no body may have contacts with itself, no vertex is shared.
  __device__ void setRow(const uint4& ids) {
    ids_ = any_self_ ? ids : make_uint4(kNone, kNone, kNone, ids.w);
    if (kAdjacent) certified_ = certifiedBits(ids);
  }
  // Returns the ids of an entry, with its place in the tile as w.
  __device__ uint4 idsAt(TileEntryIndex at) const {
    const uint4 ids = any_self_ ? c_.tiles.ids[at] : uint4{};
    return make_uint4(ids.x, ids.y, ids.z, lane_);
  }
  __device__ Aabb boxOfPlace(std::uint32_t place) const {
    return TileEntryBox{memory_.triangles.low[place], memory_.triangles.high[place]}.box();
  }
  __device__ std::uint32_t columnAt(std::uint32_t step) const {
    return (first_column_ + step * stride_) % kWarp;
  }

  // Finds the columns of this lane that meet its row's box, as bits by steps. Columns beyond the
  // last one are tested too, with old contents; the caller removes their bits.
  __device__ void findPartners(const Aabb& box, std::uint32_t first, std::uint32_t steps,
                               std::uint32_t every) {
    partners_ = 0;
#pragma unroll 2
    for (std::uint32_t step = first; step < steps; step += every) {
      if (intersects(box, boxOfPlace(columnAt(step)))) partners_ |= 1U << step;
    }
    if (passes_ != 1) keepPass();
  }
  __device__ void keepPass() {
    for (std::uint32_t step = 0; step < kWarp; ++step) {
      if ((schedule_.number() + step) % passes_ != c_.params().pass) partners_ &= ~(1U << step);
    }
  }

  // Takes one partner of each lane at a time, while the queues have room. Pairs that share vertices
  // are dropped, or go to a queue of their own.
  __device__ void takePartners() {
    while (rounds_ != 0 && met_.size <= kMetCapacity - kWarp &&
           adjacent_.size <= kAdjacentCapacity - kWarp) {
      const bool has = partners_ != 0;
      const std::uint32_t step = has ? __ffs(static_cast<int>(partners_)) - 1 : 0;
      partners_ &= partners_ - 1;
      const uint4 ids = memory_.triangles.ids[columnAt(step)];
      const EntryPair pair{TileEntryIndex(first_a_ + ids_.w), TileEntryIndex(first_b_ + ids.w)};
      if (kAdjacent) {
        const std::uint32_t shared = sharedBits(ids_, ids);
        met_.push(has && shared == 0, pair);
        const bool open = has && shared != 0 && (shared & certified_) == 0;
        if (__any_sync(kFullWarp, open) != 0) adjacent_.push(open, pair);
      } else {
        met_.push(has && !shareVertices(ids_, ids), pair);
      }
      if (--rounds_ == 0) schedule_.askForNext();
    }
  }

  // Filters queued pairs by planes, and by the partition to which the pair belongs. In swept motion
  // it uses moving boxes instead of planes.
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

  // Decides the candidates of which float32 is certain, and leaves the others to the narrow phase.
  __device__ void decideCandidates() {
    DeviceCandidate candidate;
    bool open = candidates_.pop(candidate);
    if (kStates == 1 && c_.params().decides != 0) {
      PartVerdict verdict = PartVerdict::kOpen;
      TriangleIndex a(0), b(0);
      if (open) {
        const TileEntry entry_a = c_.tiles.at(candidate.a);
        const TileEntry entry_b = c_.tiles.at(candidate.b);
        a = entry_a.triangle;
        b = entry_b.triangle;
        verdict = certainVerdict(entry_a.posed, entry_b.posed, unpackFacts(candidate.facts));
      }
      const unsigned decided = __ballot_sync(kFullWarp, verdict != PartVerdict::kOpen);
      if (laneId() == 0) atomicAdd(&c_.counters().decided, 1ULL * __popc(decided));
      reportContacts(c_, verdict == PartVerdict::kMeet, a, b, 0);
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
  WarpQueue<EntryPair> met_, adjacent_;
  WarpQueue<DeviceCandidate> candidates_;
  const std::uint32_t lane_;
  const bool any_self_;
  const std::uint32_t passes_;
  PairSchedule schedule_;
  std::uint32_t taken_ = 0;
  // The state of this pair of tiles: their first slots, and the row and columns of this lane.
  std::uint32_t first_a_ = 0, first_b_ = 0;
  std::uint32_t first_column_ = 0, stride_ = 1;
  uint4 ids_{};                  // of the row's triangle
  std::uint32_t certified_ = 0;  // bits of its vertices that have a certified fan
  unsigned partners_ = 0;        // the columns that are still to be taken, as bits by steps
  std::uint32_t rounds_ = 0;     // the most columns that a lane has
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
