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

constexpr unsigned kQueueCapacity = 2 * kWarp, kMetCapacity = 5 * kWarp;

// Of triangles; and low.w has the bits of their places in their tile.
struct LaneBoxes {
  float4 low[kWarp], high[kWarp];
};

struct WarpMemory {
  LaneBoxes rows, columns;  // of the two tiles
  MemberPair met[kMetCapacity];
  MemberPair screened[kQueueCapacity];
  DeviceCandidate candidates[kQueueCapacity];
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
        screened_{memory.screened},
        candidates_{memory.candidates},
        turn_((blockIdx.x * kThreads + threadIdx.x) / kWarp) {
    const CycleParams& params = c.params();
    tiles_ = params.any_self != 0 ? c.scene.tile_count : 0;
    end_ = tiles_ + min(c.counters().tile_pairs, c.sweep.tile_pairs.size());
  }

  // Each part has one place in this loop: the code must fit the instruction cache.
  __device__ void run() {
    bool more = true;
    while (true) {
      const bool last_met = !more && !any_partner_;
      const bool last_screened = last_met && met_.size == 0;
      if (candidates_.size >= kWarp ||
          (last_screened && screened_.size == 0 && candidates_.size > 0)) {
        settleCandidates();
      } else if (screened_.size >= kWarp || (last_screened && screened_.size > 0)) {
        screenPlanes();
      } else if (met_.size >= kWarp || (last_met && met_.size > 0)) {
        screenSharers();
      } else if (any_partner_) {
        takePartners();
      } else if (more) {
        more = takePair();
      } else {
        break;
      }
    }
    // Passes over the same pairs again are the same work to who reads the counters.
    if (laneId() == 0 && overlaps_ != 0 && c_.params().passes == 1) {
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
    if (!any_partner_) askForNext();
    return true;
  }

  // The boxes of the triangles of each tile that meet the other tile's box, closed up: rows of the
  // first tile, columns of the second.
  __device__ void layOut(const TilePairPart& pair, bool same) {
    const TileState a = c_.members.tiles[pair.a], b = c_.members.tiles[pair.b];
    first_a_ = pair.a.value * kWarp;
    first_b_ = pair.b.value * kWarp;
    const Aabb box_a = boxAt<kStates>(c_, MemberIndex(first_a_ + laneId()));
    const Aabb box_b = same ? box_a : boxAt<kStates>(c_, MemberIndex(first_b_ + laneId()));
    const bool in_a = (a.live >> laneId() & 1) != 0 && intersects(box_a, b.box);
    const bool in_b = (b.live >> laneId() & 1) != 0 && intersects(box_b, a.box);
    const std::uint32_t rows = closeUp(memory_.rows, in_a, box_a);
    const std::uint32_t columns = closeUp(memory_.columns, in_b, box_b);
    __syncwarp();
    if (laneId() == 0 && pair.part == 0) overlaps_ += same ? rows * (rows - 1) / 2 : rows * columns;
    if (rows != 0 && columns != 0) findPartners(rows, columns, pair, same);
    __syncwarp();
  }
  __device__ static std::uint32_t closeUp(LaneBoxes& to, bool in, const Aabb& box) {
    const unsigned mask = __ballot_sync(kFullWarp, in);
    if (in) {
      const unsigned mine = __popc(mask & ((1U << laneId()) - 1));
      to.low[mine] = make_float4(box.min.x, box.min.y, box.min.z, __uint_as_float(laneId()));
      to.high[mine] = make_float4(box.max.x, box.max.y, box.max.z, 0);
    }
    return __popc(mask);
  }

  // Each row is looked at by as many lanes as there are for it, each of which takes every so many a
  // column.
  __device__ void findPartners(std::uint32_t rows, std::uint32_t columns, const TilePairPart& pair,
                               bool same) {
    const unsigned shift = rows > 1 ? 32 - __clz(static_cast<int>(rows - 1)) : 0;
    const std::uint32_t row = laneId() & ((1U << shift) - 1);
    stride_ = kWarp >> shift;
    first_column_ = laneId() >> shift;
    const float4 low_a = memory_.rows.low[row], high_a = memory_.rows.high[row];
    const Aabb box{{low_a.x, low_a.y, low_a.z}, {high_a.x, high_a.y, high_a.z}};
    // Of a tile with itself each pair once.
    const std::uint32_t from = row >= rows ? kWarp : same ? row + 1 : 0;
    row_ = first_a_ + (__float_as_uint(low_a.w) & (kWarp - 1));
    partners_ = 0;
    const std::uint32_t steps = (columns + stride_ - 1) / stride_;
    for (std::uint32_t step = pair.part; step < steps; step += pair.parts) {
      const std::uint32_t column = first_column_ + step * stride_;
      if (column < from || column >= columns || !isOfPass(step)) continue;
      const float4 low = memory_.columns.low[column], high = memory_.columns.high[column];
      const Aabb other{{low.x, low.y, low.z}, {high.x, high.y, high.z}};
      if (intersects(box, other)) partners_ |= 1U << step;
    }
    any_partner_ = __any_sync(kFullWarp, partners_ != 0) != 0;
  }
  // A pass has every so many a step of every pair of tiles.
  __device__ bool isOfPass(std::uint32_t step) const {
    const CycleParams& params = c_.params();
    return params.passes == 1 || (item_ + step) % params.passes == params.pass;
  }

  // Partners of all lanes, one by one, while there is room.
  __device__ void takePartners() {
    while (any_partner_ && met_.size <= kMetCapacity - kWarp) {
      const bool has = partners_ != 0;
      MemberPair pair{};
      if (has) {
        const auto step = static_cast<std::uint32_t>(__ffs(static_cast<int>(partners_)) - 1);
        partners_ &= partners_ - 1;
        const float lane = memory_.columns.low[first_column_ + step * stride_].w;
        pair = {row_, first_b_ + __float_as_uint(lane)};
      }
      met_.push(has, pair);
      any_partner_ = __any_sync(kFullWarp, partners_ != 0) != 0;
      if (!any_partner_) askForNext();
    }
  }

  // Shared vertices.
  __device__ void screenSharers() {
    MemberPair pair{};
    bool kept = met_.pop(pair);
    if (kept) {
      const uint4 a = c_.members.ids[MemberIndex(pair.a)], b = c_.members.ids[MemberIndex(pair.b)];
      const std::uint32_t shared_a = sharedBits(a, b);
      const std::uint32_t shared_b = shared_a == 0 ? 0 : sharedBits(b, a);
      kept = shared_a == 0 ||
             (c_.params().adjacent == AdjacentPairs::kBeyondShared && !isCertified(a, shared_a));
      pair = {pair.a | shared_a << kSharedBitsAt, pair.b | shared_b << kSharedBitsAt};
    }
    screened_.push(kept, pair);
  }

  // Planes, and whose share the pair is; in swept motion moving boxes instead of planes.
  __device__ void screenPlanes() {
    MemberPair pair{};
    DeviceCandidate candidate{};
    bool kept = screened_.pop(pair);
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
  WarpMemory& memory_;
  WarpQueue<MemberPair> met_, screened_;
  WarpQueue<DeviceCandidate> candidates_;
  std::uint32_t turn_;  // in the first lane: the next pair's number
  std::uint32_t item_ = 0, taken_ = 0;
  std::uint32_t tiles_, end_;
  // Of this pair of tiles: their first slots, and of this lane its row's slot, and which columns it
  // takes; of them, by steps, those that are still to be taken.
  std::uint32_t first_a_ = 0, first_b_ = 0;
  std::uint32_t row_ = 0, first_column_ = 0, stride_ = 1;
  unsigned partners_ = 0;
  bool any_partner_ = false;  // some lane has one
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
