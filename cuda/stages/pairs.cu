// Stage sweep, its second part: inside pairs of tiles, triangle against triangle, a warp for each
// pair. What each test leaves goes through a short queue, so that every test runs on full warps.
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/cut_off.cuh"
#include "cuda/stages/pair_turns.cuh"
#include "cuda/stages/report.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/swept_pairs.cuh"
#include "cuda/stages/warp_queue.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
constexpr unsigned kWarps = kThreads / kWarp;
constexpr unsigned kLogWarp = 5;
static_assert(1U << kLogWarp == kWarp);
constexpr unsigned kBlocksEach = 7;  // of a multiprocessor, as registers allow

// Two members whose boxes meet.
struct alignas(8) MemberPair {
  MemberIndex a, b;
};

// Boxes of a tile's triangles, and their vertices' ids with their places in the tile as w.
struct LaneTriangles {
  float4 low[kWarp], high[kWarp];
  uint4 ids[kWarp];
};

constexpr unsigned kMetCapacity = 4 * kWarp, kSharingCapacity = 2 * kWarp;
constexpr unsigned kCandidateCapacity = 2 * kWarp;

struct WarpMemory {
  LaneTriangles triangles;  // of one tile, and then of the other
  MemberPair met[kMetCapacity], sharing[kSharingCapacity];
  DeviceCandidate candidates[kCandidateCapacity];
  TurnNumbers turns;
};

// A pair of tiles takes some microseconds. Once in so many a warp asks whether the cycle is cut
// off.
constexpr std::uint32_t kPairsPerAsker = 64;

// kStates == 2 in swept motion; kSharers: triangles that share vertices may be contacts.
template <int kStates, bool kSharers>
class PairScreener {
 public:
  __device__ PairScreener(const CycleArrays& c, WarpMemory& memory)
      : c_(c),
        memory_(memory),
        met_{memory.met},
        sharing_{memory.sharing},
        candidates_{memory.candidates},
        lane_(laneId()),
        any_self_(c.params().any_self != 0),
        passes_(c.params().passes),
        turns_(c, memory.turns) {}

  // Each part has one place in this loop: the code must fit the instruction cache.
  __device__ void run() {
    bool more = true;
    while (true) {
      const bool last_met = !more && rounds_ == 0;
      if (candidates_.size >= kWarp || (last_met && met_.size == 0 && candidates_.size > 0)) {
        settleCandidates();
      } else if (met_.size >= kWarp || (last_met && met_.size > 0)) {
        screenMet();
      } else if (kSharers && (sharing_.size >= kWarp || (last_met && sharing_.size > 0))) {
        screenSharing();
      } else if (rounds_ != 0) {
        takePartners();
      } else if (more) {
        more = takePair();
      } else {
        break;
      }
    }
    leaveOverlaps();
  }

 private:
  // To the next pair of tiles, or a tile against itself; false if there is none, or the cycle is
  // cut off.
  __device__ bool takePair() {
    if (!turns_.take()) return false;
    if (++taken_ % kPairsPerAsker == 0) {
      leaveOverlaps();
      if (warpIsCutOff(c_, turns_.number() % kWarpsPerAsker == 0)) return false;
    }
    if (!turns_.isSelf()) {
      layOut(turns_.pair(), turns_.part(), turns_.parts());
    } else if (c_.scene.bodies[c_.scene.tile_body[turns_.tile()]].has_self != 0) {
      layOutSelf(turns_.tile());
    }
    if (rounds_ == 0) turns_.askForNext();
    return true;
  }
  // Passes over the same pairs again are the same work to who reads the counters.
  __device__ void leaveOverlaps() {
    if (lane_ == 0 && overlaps_ != 0 && passes_ == 1) {
      atomicAdd(&c_.counters().interval_overlaps, 1ULL * overlaps_);
    }
    overlaps_ = 0;
  }

  // Of the triangles of each tile those that meet the other tile's box: each row, one of the first
  // tile, to as many lanes as there are for it; the columns, of the second, to memory_.triangles,
  // each lane to look at every so many of them. One of so many parts of the work.
  __device__ void layOut(const TilePair& pair, std::uint32_t part, std::uint32_t parts) {
    const TileState a = c_.members.tiles[pair.a], b = c_.members.tiles[pair.b];
    first_a_ = pair.a.value * kWarp;
    first_b_ = pair.b.value * kWarp;
    const MemberIndex at_a(first_a_ + lane_), at_b(first_b_ + lane_);
    const MemberBox box_a = c_.members.boxes[at_a], box_b = c_.members.boxes[at_b];
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
  // All triangles of a tile as a ring. Each looks as far as halfway round: so each pair comes once,
  // and each has as many.
  __device__ void layOutSelf(TileIndex tile) {
    constexpr unsigned kSteps = kWarp / 2;
    const unsigned live = c_.members.tiles[tile].live;
    const std::uint32_t count = __popc(live);
    if (count == 0) return;
    overlaps_ += count * (count - 1) / 2;
    first_a_ = first_b_ = tile.value * kWarp;
    const MemberIndex at(first_a_ + lane_);
    const MemberBox box = c_.members.boxes[at];
    const bool mine = (live >> lane_ & 1) != 0;
    leave(mine, lane_, box, idsAt(at));
    setRow(memory_.triangles.ids[lane_]);
    first_column_ = lane_ + 1;
    stride_ = 1;
    findPartners(box.box(), 0, kSteps, 1);
    const unsigned live_ahead = live >> 1 >> lane_ | live << (kWarp - 1 - lane_);
    if (!mine) partners_ = 0;
    partners_ &= live_ahead;
    if (lane_ >= kSteps) partners_ &= (1U << (kSteps - 1)) - 1;
    rounds_ = warpMost(__popc(partners_));
  }
  // To memory_.triangles, by a whole warp: of the lanes that are `in`, each to its place.
  __device__ void leave(bool in, std::uint32_t place, const MemberBox& box, const uint4& ids) {
    __syncwarp();
    if (in) {
      memory_.triangles.low[place] = box.low;
      memory_.triangles.high[place] = box.high;
      memory_.triangles.ids[place] = ids;
    }
    __syncwarp();
  }
  // Of this lane's row; where no body has contacts with itself, its vertices are nobody else's.
  __device__ void setRow(const uint4& ids) {
    ids_ = any_self_ ? ids : make_uint4(kNone, kNone, kNone, ids.w);
    if (kSharers) certified_ = certifiedBits(ids);
  }
  // With the place in the tile as w.
  __device__ uint4 idsAt(MemberIndex at) const {
    const uint4 ids = any_self_ ? c_.members.ids[at] : uint4{};
    return make_uint4(ids.x, ids.y, ids.z, lane_);
  }
  __device__ Aabb boxOfPlace(std::uint32_t place) const {
    return MemberBox{memory_.triangles.low[place], memory_.triangles.high[place]}.box();
  }
  __device__ std::uint32_t columnAt(std::uint32_t step) const {
    return (first_column_ + step * stride_) % kWarp;
  }

  // The columns of this lane that meet its row's box, some of which may be out of date.
  __device__ void findPartners(const Aabb& box, std::uint32_t first, std::uint32_t steps,
                               std::uint32_t every) {
    partners_ = 0;
#pragma unroll 2
    for (std::uint32_t step = first; step < steps; step += every) {
      if (intersects(box, boxOfPlace(columnAt(step)))) partners_ |= 1U << step;
    }
    if (passes_ != 1) keepPass();
  }
  // A pass has every so many a step of every pair of tiles.
  __device__ void keepPass() {
    for (std::uint32_t step = 0; step < kWarp; ++step) {
      if ((turns_.number() + step) % passes_ != c_.params().pass) partners_ &= ~(1U << step);
    }
  }

  // Partners of all lanes, one by one, while there is room. Those that share vertices are no
  // contacts, or have a turn of their own.
  __device__ void takePartners() {
    while (rounds_ != 0 && met_.size <= kMetCapacity - kWarp &&
           sharing_.size <= kSharingCapacity - kWarp) {
      const bool has = partners_ != 0;
      const std::uint32_t step = has ? __ffs(static_cast<int>(partners_)) - 1 : 0;
      partners_ &= partners_ - 1;
      const uint4 ids = memory_.triangles.ids[columnAt(step)];
      const MemberPair pair{MemberIndex(first_a_ + ids_.w), MemberIndex(first_b_ + ids.w)};
      if (kSharers) {
        const std::uint32_t shared = sharedBits(ids_, ids);
        met_.push(has && shared == 0, pair);
        const bool open = has && shared != 0 && (shared & certified_) == 0;
        if (__any_sync(kFullWarp, open) != 0) sharing_.push(open, pair);
      } else {
        met_.push(has && !shareVertices(ids_, ids), pair);
      }
      if (--rounds_ == 0) turns_.askForNext();
    }
  }

  // Planes, and whose share the pair is; in swept motion moving boxes instead of planes.
  __device__ void screenMet() {
    MemberPair pair{MemberIndex(0), MemberIndex(0)};
    DeviceCandidate candidate{};
    bool kept = met_.pop(pair);
    if (kept) kept = screen(pair, 0, 0, candidate);
    candidates_.push(kept, candidate);
  }
  // The same of those that share vertices.
  __device__ void screenSharing() {
    MemberPair pair{MemberIndex(0), MemberIndex(0)};
    DeviceCandidate candidate{};
    bool kept = sharing_.pop(pair);
    if (kept) {
      const uint4 a = c_.members.ids[pair.a], b = c_.members.ids[pair.b];
      kept = screen(pair, sharedBits(a, b), sharedBits(b, a), candidate);
    }
    candidates_.push(kept, candidate);
  }
  __device__ bool screen(const MemberPair& pair, std::uint32_t shared_a, std::uint32_t shared_b,
                         DeviceCandidate& candidate) const {
    const auto screen = kStates > 1 ? screenMovingPair : screenPair;
    return screen(c_, pair.a, pair.b, shared_a, shared_b, candidate);
  }

  // Verdicts of which float32 is certain; the other candidates are for the judge.
  __device__ void settleCandidates() {
    DeviceCandidate candidate;
    bool open = candidates_.pop(candidate);
    if (kStates == 1 && c_.params().settles != 0) {
      PartVerdict verdict = PartVerdict::kOpen;
      TriangleIndex a(0), b(0);
      if (open) {
        const Member member_a = c_.members.at(candidate.a);
        const Member member_b = c_.members.at(candidate.b);
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
    const bool has_room = open && putCandidate(c_, place, candidate);
    if (c_.params().leaves_few != 0) {
      const bool sharing = sharedBitsOf(candidate) != 0;
      reportOpen(c_, has_room, sharing, Place(static_cast<std::uint32_t>(place)));
    }
  }

  const CycleArrays& c_;
  WarpMemory& memory_;
  WarpQueue<MemberPair> met_, sharing_;
  WarpQueue<DeviceCandidate> candidates_;
  const std::uint32_t lane_;
  const bool any_self_;
  const std::uint32_t passes_;
  PairTurns turns_;
  std::uint32_t taken_ = 0;
  // Of this pair of tiles: their first slots, and the row and columns of this lane.
  std::uint32_t first_a_ = 0, first_b_ = 0;
  std::uint32_t first_column_ = 0, stride_ = 1;
  uint4 ids_{};                  // of the row
  std::uint32_t certified_ = 0;  // bits of its vertices: who shares one of them is no contact
  unsigned partners_ = 0;        // by steps, the columns that are still to be taken
  std::uint32_t rounds_ = 0;     // the most that a lane has
  std::uint32_t overlaps_ = 0;
};

// Warps for the tiles, sweep.crowded_pairs and sweep.tile_pairs: reads the arrays of `members`,
// adds to contacts.candidates and contacts.contacts.
template <int kStates, bool kSharers>
__global__ void __launch_bounds__(kThreads, kBlocksEach) pairsKernel(CycleArrays c) {
  __shared__ WarpMemory memory[kWarps];
  awaitKernelAhead();
  PairScreener<kStates, kSharers> screener(c, memory[threadIdx.x / kWarp]);
  screener.run();
}

}  // namespace

void launchPairs(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  const auto of = [&shape](auto plain, auto sharers) { return shape.sharers ? sharers : plain; };
  const auto kernel = shape.swept ? of(pairsKernel<2, false>, pairsKernel<2, true>)
                                  : of(pairsKernel<1, false>, pairsKernel<1, true>);
  const unsigned blocks = blocksInOneWave(kernel, kThreads, 0, shape.device);
  launchEarly(kernel, blocks, kThreads, 0, shape.device, stream, cycle);
}

}  // namespace deformable_contact_monitor
