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

constexpr unsigned kQueueCapacity = 2 * kWarp;

struct WarpMemory {
  float4 low[kWarp], high[kWarp];  // boxes of the second tile's triangles
  MemberPair met[kQueueCapacity];
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
      const bool no_more_met = !more && met_.size == 0 && !anyPartner();
      const bool last = no_more_met && screened_.size == 0;
      if (candidates_.size >= kWarp || (last && candidates_.size > 0)) {
        settleCandidates();
      } else if (screened_.size >= kWarp || (no_more_met && screened_.size > 0)) {
        screenPlanes();
      } else if (met_.size >= kWarp || (!more && !anyPartner() && met_.size > 0)) {
        screenSharers();
      } else if (anyPartner()) {
        nextPartners();
      } else if (more) {
        more = takePair();
      } else {
        break;
      }
    }
    overlaps_ = warpSum(overlaps_);
    // Passes over the same pairs again are the same work to who reads the counters.
    if (laneId() == 0 && overlaps_ != 0 && c_.params().passes == 1) {
      atomicAdd(&c_.counters().interval_overlaps, overlaps_);
    }
  }

 private:
  __device__ bool anyPartner() const { return __any_sync(kFullWarp, partners_ != 0) != 0; }

  // Tiles against themselves, then pairs of tiles; false if there is none left, or the cycle is cut
  // off.
  __device__ bool takePair() {
    const CycleParams& params = c_.params();
    const std::uint64_t at = std::uint64_t{turn_} * params.passes + params.pass;
    if (at >= end_) return false;
    const std::uint32_t warps = gridDim.x * kWarps;
    if (++taken_ % kPairsPerAsker == 0 && warpIsCutOff(c_, turn_ % kWarpsPerAsker == 0)) {
      return false;
    }
    turn_ += warps;
    const auto i = static_cast<std::uint32_t>(at);
    if (i >= tiles_) {
      const TilePair pair = c_.sweep.tile_pairs[Place(i - tiles_)];
      findPartners(pair.a, pair.b);
      return true;
    }
    const TileIndex tile(i);
    if (c_.scene.bodies[c_.scene.tile_body[tile]].has_self != 0) findPartners(tile, tile);
    return true;
  }

  // The second tile's triangles whose boxes meet that of this lane's triangle of the first tile.
  __device__ void findPartners(TileIndex tile_a, TileIndex tile_b) {
    const TileState a = c_.members.tiles[tile_a], b = c_.members.tiles[tile_b];
    first_a_ = tile_a.value * kWarp;
    first_b_ = tile_b.value * kWarp;
    const bool same = tile_a == tile_b;
    Aabb box_a, box_b;
    if ((a.live >> laneId() & 1) != 0) box_a = boxAt<kStates>(c_, MemberIndex(first_a_ + laneId()));
    if (!same && (b.live >> laneId() & 1) != 0) {
      box_b = boxAt<kStates>(c_, MemberIndex(first_b_ + laneId()));
    }
    if (same) box_b = box_a;
    const bool in_a = intersects(box_a, b.box), in_b = intersects(box_b, a.box);
    const unsigned rows = __ballot_sync(kFullWarp, in_a);
    unsigned columns = __ballot_sync(kFullWarp, in_b);
    if (laneId() == 0) {
      overlaps_ += same ? __popc(rows) * (__popc(rows) - 1) / 2 : __popc(rows) * __popc(columns);
    }
    if (rows == 0) return;
    memory_.low[laneId()] = make_float4(box_b.min.x, box_b.min.y, box_b.min.z, 0);
    memory_.high[laneId()] = make_float4(box_b.max.x, box_b.max.y, box_b.max.z, 0);
    __syncwarp();
    unsigned partners = 0;
    for (; columns != 0; columns &= columns - 1) {
      const int column = __ffs(static_cast<int>(columns)) - 1;
      const float4 low = memory_.low[column], high = memory_.high[column];
      const Aabb box{{low.x, low.y, low.z}, {high.x, high.y, high.z}};
      if (intersects(box_a, box)) partners |= 1U << column;
    }
    __syncwarp();
    // Of a tile with itself each pair once.
    partners_ = same ? partners & ~((2U << laneId()) - 1) : partners;
  }

  // One partner of each lane that has some.
  __device__ void nextPartners() {
    const bool has = partners_ != 0;
    const auto column = static_cast<std::uint32_t>(__ffs(static_cast<int>(partners_)) - 1);
    partners_ &= partners_ - 1;
    met_.push(has, {first_a_ + laneId(), first_b_ + column});
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
  std::uint32_t turn_, taken_ = 0;  // of the pass
  std::uint32_t tiles_, end_;
  std::uint32_t first_a_ = 0, first_b_ = 0;  // slots of the tiles
  unsigned partners_ = 0;  // of this lane's triangle: those in the second tile that are left
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
