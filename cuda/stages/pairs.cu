// Stage sweep, its second part: inside pairs of tiles, triangle against triangle, a warp for each
// pair. What each test leaves goes through a short queue, so that every test runs on full warps.
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/cut_off.cuh"
#include "cuda/stages/report.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/swept_pairs.cuh"
#include "cuda/stages/warp_queue.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
constexpr unsigned kWarps = kThreads / kWarp;
constexpr unsigned kBlocksEach = 7;  // of a multiprocessor, as registers allow

// Two members whose boxes meet; with the bits of the vertices that they share << kSharedBitsAt.
struct alignas(8) MemberPair {
  std::uint32_t a, b;
};
constexpr unsigned kSharedBitsAt = 29;
constexpr std::uint32_t kMemberMask = (1U << kSharedBitsAt) - 1;

constexpr unsigned kMetCapacity = 4 * kWarp, kCandidateCapacity = 2 * kWarp;

// Boxes of a tile's triangles, and their vertices' ids with their places in the tile as w. Those
// that are of no interest come last, with empty boxes.
struct LaneTriangles {
  float4 low[kWarp], high[kWarp];
  uint4 ids[kWarp];
};

struct WarpMemory {
  LaneTriangles triangles;  // of one tile, and then of the other
  MemberPair met[kMetCapacity];
  DeviceCandidate candidates[kCandidateCapacity];
};

// A pair of tiles takes some microseconds. Once in so many a warp asks whether the cycle is cut
// off.
constexpr std::uint32_t kPairsPerAsker = 64;

// kStates == 2 in swept motion.
template <int kStates>
class PairScreener {
 public:
  __device__ PairScreener(const CycleArrays& c, WarpMemory& memory)
      : c_(c),
        memory_(memory),
        met_{memory.met},
        candidates_{memory.candidates},
        lane_(laneId()),
        turn_((blockIdx.x * kThreads + threadIdx.x) / kWarp) {
    const CycleParams& params = c.params();
    passes_ = params.passes;
    beyond_shared_ = params.adjacent == AdjacentPairs::kBeyondShared;
    tiles_ = params.any_self != 0 ? c.scene.tile_count : 0;
    end_ = tiles_ + min(c.counters().tile_pairs, c.sweep.tile_pairs.size());
  }

  // Each part has one place in this loop: the code must fit the instruction cache.
  __device__ void run() {
    bool more = true;
    while (true) {
      const bool last_met = !more && rounds_ == 0;
      if (candidates_.size >= kWarp || (last_met && met_.size == 0 && candidates_.size > 0)) {
        settleCandidates();
      } else if (met_.size >= kWarp || (last_met && met_.size > 0)) {
        screenPlanes();
      } else if (rounds_ != 0) {
        takePartners();
      } else if (more) {
        more = takePair();
      } else {
        break;
      }
    }
    // Passes over the same pairs again are the same work to who reads the counters.
    if (laneId() == 0 && overlaps_ != 0 && passes_ == 1) {
      atomicAdd(&c_.counters().interval_overlaps, overlaps_);
    }
  }

 private:
  // The first pairs are dealt out, the others go to whoever is free: some have hundreds of
  // triangles that meet, most have few. Asked for when the last one's have been taken: until it is
  // wanted there is other work to do.
  __device__ void askForNext() {
    if (laneId() == 0) turn_ = gridDim.x * kWarps + atomicAdd(&c_.counters().pairs_taken, 1U);
  }

  // To the next pair of tiles, or a tile against itself; false if there is none, or the cycle is
  // cut off.
  __device__ bool takePair() {
    item_ = __shfl_sync(kFullWarp, turn_, 0);
    if (item_ >= end_) return false;
    if (++taken_ % kPairsPerAsker == 0 && warpIsCutOff(c_, item_ % kWarpsPerAsker == 0)) {
      return false;
    }
    if (item_ >= tiles_) {
      layOut(c_.sweep.tile_pairs[Place(item_ - tiles_)], false);
    } else if (c_.scene.bodies[c_.scene.tile_body[TileIndex(item_)]].has_self != 0) {
      layOut({TileIndex(item_), TileIndex(item_), 0, 1}, true);
    }
    if (rounds_ == 0) askForNext();
    return true;
  }

  // Of the triangles of each tile those that meet the other tile's box: each row, one of the first
  // tile, to lanes; the columns, of the second, to memory_.triangles.
  __device__ void layOut(const TilePairPart& pair, bool same) {
    const TileState a = c_.members.tiles[pair.a], b = c_.members.tiles[pair.b];
    first_b_ = pair.b.value * kWarp;
    const MemberIndex at_a(pair.a.value * kWarp + lane_), at_b(first_b_ + lane_);
    const MemberBox box_a = c_.members.boxes[at_a], box_b = c_.members.boxes[at_b];
    unsigned in_a = a.live, in_b = b.live;
    if (!same) {
      in_a &= __ballot_sync(kFullWarp, intersects(box_a.box(), b.box));
      in_b &= __ballot_sync(kFullWarp, intersects(box_b.box(), a.box));
    }
    const std::uint32_t rows = __popc(in_a), columns = __popc(in_b);
    if (rows == 0 || columns == 0) return;
    if (lane_ == 0 && pair.part == 0) overlaps_ += same ? rows * (rows - 1) / 2 : rows * columns;
    closeUp(in_a, box_a, at_a);
    const unsigned shift = rows > 1 ? 32 - __clz(static_cast<int>(rows - 1)) : 0;
    const std::uint32_t row = same ? lane_ : lane_ & ((1U << shift) - 1);
    const Aabb box = boxOfPlace(row);
    ids_ = memory_.triangles.ids[row];
    first_a_ = pair.a.value * kWarp;
    if (!same) closeUp(in_b, box_b, at_b);
    // A tile with itself as a ring of all places, looked at as far as halfway round: so each pair
    // comes once, and each row has as many.
    first_column_ = same ? lane_ + 1 : lane_ >> shift;
    stride_ = same ? 1 : kWarp >> shift;
    const std::uint32_t steps = same ? kWarp / 2 : (columns + stride_ - 1) / stride_;
    findPartners(box, pair.part, steps, pair.parts);
    if (same && lane_ >= kWarp / 2) partners_ &= (1U << (kWarp / 2 - 1)) - 1;
    rounds_ = warpMost(__popc(partners_));
  }
  // To memory_.triangles, those of the lanes that are `in` first, by a whole warp.
  __device__ void closeUp(unsigned in, const MemberBox& box, MemberIndex at) {
    const bool mine = (in >> lane_ & 1) != 0;
    const unsigned before = (1U << lane_) - 1;
    const unsigned place = mine ? __popc(in & before) : __popc(in) + __popc(~in & before);
    const MemberBox to = mine ? box : MemberBox::of(Aabb());
    uint4 ids{};
    if (mine) ids = c_.members.ids[at];
    ids.w = lane_;
    __syncwarp();
    memory_.triangles.low[place] = to.low;
    memory_.triangles.high[place] = to.high;
    memory_.triangles.ids[place] = ids;
    __syncwarp();
  }
  __device__ Aabb boxOfPlace(std::uint32_t place) const {
    return MemberBox{memory_.triangles.low[place], memory_.triangles.high[place]}.box();
  }
  __device__ std::uint32_t columnAt(std::uint32_t step) const {
    return (first_column_ + step * stride_) % kWarp;
  }

  // Each row is looked at by as many lanes as there are for it, each of which takes every so many a
  // column, from this step on.
  __device__ void findPartners(const Aabb& box, std::uint32_t first, std::uint32_t steps,
                               std::uint32_t every) {
    partners_ = 0;
    for (std::uint32_t step = first; step < steps; step += every) {
      if (intersects(box, boxOfPlace(columnAt(step)))) partners_ |= 1U << step;
    }
    if (passes_ != 1) keepPass();
  }
  // A pass has every so many a step of every pair of tiles.
  __device__ void keepPass() {
    for (std::uint32_t step = 0; step < kWarp; ++step) {
      if ((item_ + step) % passes_ != c_.params().pass) partners_ &= ~(1U << step);
    }
  }

  // Partners of all lanes, one by one, while there is room; those that share vertices stay where
  // they may meet beyond them.
  __device__ void takePartners() {
    while (rounds_ != 0 && met_.size <= kMetCapacity - kWarp) {
      bool kept = partners_ != 0;
      const std::uint32_t step = kept ? __ffs(static_cast<int>(partners_)) - 1 : 0;
      partners_ &= partners_ - 1;
      const uint4 ids = memory_.triangles.ids[columnAt(step)];
      MemberPair pair{first_a_ + ids_.w, first_b_ + ids.w};
      if (kept && shareVertices(ids_, ids)) {
        kept = false;
        if (beyond_shared_) {
          const std::uint32_t shared = sharedBits(ids_, ids);
          kept = !isCertified(ids_, shared);
          pair.a |= shared << kSharedBitsAt;
          pair.b |= sharedBits(ids, ids_) << kSharedBitsAt;
        }
      }
      met_.push(kept, pair);
      if (--rounds_ == 0) askForNext();
    }
  }

  // Planes, and whose share the pair is; in swept motion moving boxes instead of planes.
  __device__ void screenPlanes() {
    MemberPair pair{};
    DeviceCandidate candidate{};
    bool kept = met_.pop(pair);
    if (kept) {
      const auto screen = kStates > 1 ? screenMovingPair : screenPair;
      kept = screen(c_, MemberIndex(pair.a & kMemberMask), MemberIndex(pair.b & kMemberMask),
                    pair.a >> kSharedBitsAt, pair.b >> kSharedBitsAt, candidate);
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
    if (open && place < c_.contacts.candidates.size()) {
      c_.contacts.candidates[Place(static_cast<std::uint32_t>(place))] = candidate;
    }
  }

  const CycleArrays& c_;
  WarpMemory& memory_;
  WarpQueue<MemberPair> met_;
  WarpQueue<DeviceCandidate> candidates_;
  const std::uint32_t lane_;
  std::uint32_t passes_, tiles_, end_;
  bool beyond_shared_;
  std::uint32_t turn_;  // in the first lane: the next pair's number
  std::uint32_t item_ = 0, taken_ = 0;
  // Of this pair of tiles: their first slots, and the row and columns of this lane.
  std::uint32_t first_a_ = 0, first_b_ = 0;
  std::uint32_t first_column_ = 0, stride_ = 1;
  uint4 ids_{};               // the row's
  unsigned partners_ = 0;     // by steps, the columns that are still to be taken
  std::uint32_t rounds_ = 0;  // the most that a lane has
  unsigned long long overlaps_ = 0;
};

// Warps for the tiles and for sweep.tile_pairs: reads the arrays of `members`, adds to
// contacts.candidates and contacts.contacts.
template <int kStates>
__global__ void __launch_bounds__(kThreads, kBlocksEach) pairsKernel(CycleArrays c) {
  awaitKernelAhead();
  __shared__ WarpMemory memory[kWarps];
  PairScreener<kStates> screener(c, memory[threadIdx.x / kWarp]);
  screener.run();
}

}  // namespace

void launchPairs(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  const auto kernel = shape.swept ? pairsKernel<2> : pairsKernel<1>;
  launchEarly(kernel, blocksInOneWave(kernel, kThreads, 0, shape.device), kThreads, 0, shape.device,
              stream, cycle);
}

}  // namespace deformable_contact_monitor
