// Stage narrow_phase: decides the candidates. If the sweep leaves few, one kernel gives all of them
// the full verdict. Otherwise a first kernel applies floating-point filters, and a second one gives
// the full verdict to the pairs that these leave open.
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/cut_off.cuh"
#include "cuda/stages/found_pairs.cuh"
#include "cuda/stages/narrow_phase_moving.cuh"
#include "cuda/stages/pair_filter.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
// The blocks of fullKernel on each multiprocessor, as far as its registers allow.
constexpr unsigned kFullBlocksEach = 3;

// One block in so many asks the host whether the cycle is cut off, by its first warp.
constexpr unsigned kBlocksPerAsker = 64;

// Returns a verdict by floating-point filters alone. If there are margins, pairs that are apart
// stay open, because they may be within the margin. Otherwise the sweep has decided what float32
// can.
template <bool kMargins>
__device__ PartVerdict quickVerdictOf(const DeviceCandidate& candidate, const TileEntry& a,
                                      const TileEntry& b) {
  const PairFacts facts = unpackFacts(candidate.facts);
  const PartVerdict verdict = quickVerdict(a.posed, b.posed, facts);
  const bool may_be_near = kMargins && verdict == PartVerdict::kApart && !facts.shared.any;
  return may_be_near ? PartVerdict::kOpen : verdict;
}

// One thread for each of contacts.candidates: decides most of them, and adds the others to
// contacts.open. Without kMargins, no pair has a margin.
template <bool kMargins>
__global__ void __launch_bounds__(kThreads) quickKernel(CycleArrays c) {
  letNextKernelStart();  // the previous kernel has ended, for this launch is a plain one
  const auto count = static_cast<std::uint32_t>(
      min(c.counters().candidates, static_cast<unsigned long long>(c.contacts.candidates.size())));
  const std::uint32_t stride = gridDim.x * kThreads;
  const bool asks = blockIdx.x % kBlocksPerAsker == 0 && threadIdx.x < kWarp;
  for (std::uint32_t first = blockIdx.x * kThreads; first < count; first += stride) {
    // The first round runs in any case: otherwise a cycle that was cut off in its sweep would
    // report no contact at all.
    if (first >= stride && warpIsCutOff(c, asks)) break;
    const Place i(first + threadIdx.x);
    PartVerdict verdict = PartVerdict::kApart;
    bool adjacent = false;
    TriangleIndex a(0), b(0);
    if (i.value < count) {
      const DeviceCandidate candidate = c.contacts.candidates[i];
      const TileEntry entry_a = c.tiles.at(candidate.a);
      const TileEntry entry_b = c.tiles.at(candidate.b);
      a = entry_a.triangle;
      b = entry_b.triangle;
      adjacent = sharedBitsOf(candidate) != 0;
      verdict = quickVerdictOf<kMargins>(candidate, entry_a, entry_b);
    }
    reportOpen(c, verdict == PartVerdict::kOpen, adjacent, i);
    reportContacts(c, verdict == PartVerdict::kMeet, a, b, 0);
  }
}

// Divides contacts.open into portions for warps. Each portion has pairs of one kind, with or
// without shared vertices. Few pairs are spread over many warps, because the lanes of a warp wait
// for each other's longest path.
struct OpenPortions {
  std::uint32_t open, adjacent, each, open_portions, all;

  __device__ OpenPortions(const CycleArrays& c, std::uint32_t warps)
      : open(c.counters().open), adjacent(c.counters().open_adjacent) {
    const std::uint32_t most = warps - 1;  // either kind may have one incomplete portion
    each = max(1U, min(kWarp, (open + adjacent + most - 1) / most));
    open_portions = (open + each - 1) / each;
    all = open_portions + (adjacent + each - 1) / each;
  }
  // Returns this lane's place on contacts.open; kNone if the lane has no pair.
  __device__ std::uint32_t at(std::uint32_t portion, std::uint32_t size) const {
    const bool adjacent_kind = portion >= open_portions;
    const std::uint32_t i = (adjacent_kind ? portion - open_portions : portion) * each + laneId();
    if (laneId() >= each || i >= (adjacent_kind ? adjacent : open)) return kNone;
    return adjacent_kind ? size - 1 - i : i;
  }
};

// One thread for each of contacts.open: gives the full verdict, and adds contacts. Filters that
// quickKernel has applied are not repeated, because most time of this kernel goes into fetching its
// code. Without kMargins, no pair has a margin.
template <bool kMargins>
__global__ void __launch_bounds__(kThreads) fullKernel(CycleArrays c) {
  awaitPreviousKernel();
  const bool first = c.params().leaves_few != 0;
  const std::uint32_t warps = gridDim.x * (kThreads / kWarp);
  const std::uint32_t warp = (blockIdx.x * kThreads + threadIdx.x) / kWarp;
  const OpenPortions portions(c, warps);
  // Blocks without a portion leave at once.
  constexpr std::uint32_t kPortionsEach = kThreads / kWarp;
  const std::uint32_t working =
      min(gridDim.x, max((portions.all + kPortionsEach - 1) / kPortionsEach, 1U));
  if (blockIdx.x >= working) return;
  for (std::uint32_t portion = warp; portion < portions.all; portion += warps) {
    if (portion >= warps && warpIsCutOff(c, warp % kWarpsPerAsker == 0)) break;
    const std::uint32_t at = portions.at(portion, c.contacts.open.size());
    Verdict verdict;
    PredicateState state;
    state.mode = c.params().predicates;
    TriangleIndex a(0), b(0);
    if (at != kNone) {
      const DeviceCandidate candidate = c.contacts.candidates[c.contacts.open[Place(at)]];
      const TileEntry entry_a = c.tiles.at(candidate.a);
      const TileEntry entry_b = c.tiles.at(candidate.b);
      a = entry_a.triangle;
      b = entry_b.triangle;
      PairFacts facts = unpackFacts(candidate.facts);
      facts.margin_m = kMargins ? marginOf(c, entry_a, entry_b) : 0;
      // Pairs without shared vertices need no filters here: fullVerdict() begins with the same
      // ones.
      const PartVerdict quick = first && facts.shared.any
                                    ? quickVerdict(entry_a.posed, entry_b.posed, facts)
                                    : PartVerdict::kOpen;
      verdict = quick == PartVerdict::kOpen
                    ? fullVerdict(entry_a.posed, entry_b.posed, facts, state)
                    : Verdict{quick == PartVerdict::kMeet, 0};
    }
    __syncwarp();
    warpCount(&c.counters().exact, state.exact > 0);
    warpCount(&c.counters().undecided, verdict.contact && state.undecided);
    reportContacts(c, verdict.contact, a, b, verdict.separation_m);
  }
  writeFinalCounters(c, working);
}

// One thread: resets the counters before a pass, and before the `first` pass also those of the
// contacts.
__global__ void restartKernel(CycleArrays c, bool first) {
  CycleCounters& counters = c.counters();
  counters.candidates = 0;
  counters.open = counters.open_adjacent = 0;
  counters.blocks_done = counters.pairs_taken = counters.open_pairs = 0;
  if (c.contacts.swept_counters.size() > 0) *c.contacts.swept_counters.data() = SweptCounters{};
  if (!first) return;
  counters.contacts = 0;
  counters.exact = counters.undecided = 0;
  counters.examined = counters.unexamined = counters.decided = 0;
}

}  // namespace

void launchRestart(const CycleArrays& cycle, bool first, cudaStream_t stream) {
  restartKernel<<<1, 1, 0, stream>>>(cycle, first);
}

void launchNarrowPhase(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  if (shape.swept) return launchNarrowPhaseMoving(cycle, shape, stream);
  const unsigned full_blocks = kFullBlocksEach * shape.device.multiprocessors;
  const auto full = shape.margins ? fullKernel<true> : fullKernel<false>;
  if (shape.leaves_few) {
    full<<<full_blocks, kThreads, 0, stream>>>(cycle);
    return;
  }
  const auto quick = shape.margins ? quickKernel<true> : quickKernel<false>;
  quick<<<blocksInOneWave(quick, kThreads, 0, shape.device), kThreads, 0, stream>>>(cycle);
  launchDependent(full, full_blocks, kThreads, 0, shape.device, stream, cycle);
}

}  // namespace deformable_contact_monitor
