// Stage judge: verdicts on the candidates. Where the sweep leaves few, in full on all of them;
// else first by filters alone, and in full on those that these leave.
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/cut_off.cuh"
#include "cuda/stages/leave_counters.cuh"
#include "cuda/stages/narrow_phase_moving.cuh"
#include "cuda/stages/report.cuh"
#include "cuda/stages/screen.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
// Of a multiprocessor, as registers allow.
constexpr unsigned kFullBlocksEach = 3;

constexpr unsigned kBlocksPerAsker = 64;  // whose first warp asks the host whether to go on

// By floating-point filters alone. Within a margin, pairs that are apart may be contacts too.
__device__ PartVerdict quickVerdictOf(const CycleArrays& c, const DeviceCandidate& candidate,
                                      const Member& a, const Member& b) {
  const PairFacts facts = unpackFacts(candidate.facts);
  const PartVerdict verdict = quickVerdict(a.posed, b.posed, facts, c.params().predicates);
  const bool may_be_near =
      verdict == PartVerdict::kApart && !facts.shared.any && c.params().margins != 0;
  return may_be_near ? PartVerdict::kOpen : verdict;
}

// A thread for each of contacts.candidates: settles most of them, and puts the places of the others
// into contacts.open.
__global__ void __launch_bounds__(kThreads) quickKernel(CycleArrays c) {
  letNextStart();  // the kernel ahead has ended: this one is launched the usual way
  const auto count = static_cast<std::uint32_t>(
      min(c.counters().candidates, static_cast<unsigned long long>(c.contacts.candidates.size())));
  const std::uint32_t stride = gridDim.x * kThreads;
  const bool asks = blockIdx.x % kBlocksPerAsker == 0 && threadIdx.x < kWarp;
  for (std::uint32_t first = blockIdx.x * kThreads; first < count; first += stride) {
    // The first round is always worth its time: else a cycle cut off in its sweep would find none.
    if (first >= stride && warpIsCutOff(c, asks)) break;
    const Place i(first + threadIdx.x);
    PartVerdict verdict = PartVerdict::kApart;
    bool sharing = false;
    TriangleIndex a(0), b(0);
    if (i.value < count) {
      const DeviceCandidate candidate = c.contacts.candidates[i];
      const Member member_a = c.members.at(candidate.a);
      const Member member_b = c.members.at(candidate.b);
      a = member_a.triangle;
      b = member_b.triangle;
      sharing = sharedBitsOf(candidate) != 0;
      verdict = quickVerdictOf(c, candidate, member_a, member_b);
    }
    reportOpen(c, verdict == PartVerdict::kOpen, sharing, i);
    reportContacts(c, verdict == PartVerdict::kMeet, a, b, 0);
  }
}

// What warps take of contacts.open: each so many, of one kind; few are spread over many warps, for
// their long paths differ.
struct OpenShares {
  std::uint32_t open, sharing, each, open_shares, all;

  __device__ OpenShares(const CycleArrays& c, std::uint32_t warps)
      : open(c.counters().open), sharing(c.counters().sharing) {
    const std::uint32_t most = warps - 1;  // of shares, as if all were of one kind
    each = max(1U, min(kWarp, (open + sharing + most - 1) / most));
    open_shares = (open + each - 1) / each;
    all = open_shares + (sharing + each - 1) / each;
  }
  // This lane's place on the list, of the share with that number; kNone if there is none.
  __device__ std::uint32_t at(std::uint32_t share, std::uint32_t size) const {
    const bool shares = share >= open_shares;
    const std::uint32_t i = (shares ? share - open_shares : share) * each + laneId();
    if (laneId() >= each || i >= (shares ? sharing : open)) return kNone;
    return shares ? size - 1 - i : i;
  }
};

// A thread for each of contacts.open: the verdict in full. Filters that the other kernel has asked
// are not asked again, for most of this code's time goes into fetching it.
__global__ void __launch_bounds__(kThreads) fullKernel(CycleArrays c) {
  awaitKernelAhead();
  const bool first = c.params().leaves_few != 0;
  const std::uint32_t warps = gridDim.x * (kThreads / kWarp);
  const std::uint32_t warp = (blockIdx.x * kThreads + threadIdx.x) / kWarp;
  const OpenShares shares(c, warps);
  // Blocks without a share leave at once.
  constexpr std::uint32_t kSharesEach = kThreads / kWarp;
  const std::uint32_t working =
      min(gridDim.x, max((shares.all + kSharesEach - 1) / kSharesEach, 1U));
  if (blockIdx.x >= working) return;
  for (std::uint32_t share = warp; share < shares.all; share += warps) {
    if (share >= warps && warpIsCutOff(c, warp % kWarpsPerAsker == 0)) break;
    const std::uint32_t at = shares.at(share, c.contacts.open.size());
    Verdict verdict;
    PredicateState state;
    state.mode = c.params().predicates;
    TriangleIndex a(0), b(0);
    if (at != kNone) {
      const DeviceCandidate candidate = c.contacts.candidates[c.contacts.open[Place(at)]];
      const Member member_a = c.members.at(candidate.a);
      const Member member_b = c.members.at(candidate.b);
      a = member_a.triangle;
      b = member_b.triangle;
      PairFacts facts = unpackFacts(candidate.facts);
      facts.margin_m = marginOf(c, member_a, member_b);
      // Of others the full verdict begins with the same filters.
      verdict = first && facts.shared.any
                    ? candidateVerdict(member_a.posed, member_b.posed, facts, state)
                    : fullVerdict(member_a.posed, member_b.posed, facts, state);
    }
    __syncwarp();
    warpCount(&c.counters().exact, state.exact > 0);
    warpCount(&c.counters().undecided, verdict.contact && state.undecided);
    reportContacts(c, verdict.contact, a, b, verdict.separation_m);
  }
  leaveCounters(c, working);
}

__global__ void restartKernel(CycleArrays c, bool first) {
  CycleCounters& counters = c.counters();
  counters.candidates = 0;
  counters.open = counters.sharing = 0;
  counters.blocks_done = counters.pairs_taken = counters.open_pairs = 0;
  if (c.contacts.swept_counters.size() > 0) *c.contacts.swept_counters.data() = SweptCounters{};
  if (!first) return;
  counters.contacts = 0;
  counters.exact = counters.undecided = 0;
  counters.judged = counters.unjudged = counters.settled = 0;
}

}  // namespace

void launchRestart(const CycleArrays& cycle, bool first, cudaStream_t stream) {
  restartKernel<<<1, 1, 0, stream>>>(cycle, first);
}

void launchJudge(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  if (shape.swept) return launchJudgeMoving(cycle, shape, stream);
  const unsigned full_blocks = kFullBlocksEach * shape.device.multiprocessors;
  if (shape.leaves_few) {
    fullKernel<<<full_blocks, kThreads, 0, stream>>>(cycle);
    return;
  }
  quickKernel<<<blocksInOneWave(quickKernel, kThreads, 0, shape.device), kThreads, 0, stream>>>(
      cycle);
  launchEarly(fullKernel, full_blocks, kThreads, 0, shape.device, stream, cycle);
}

}  // namespace deformable_contact_monitor
