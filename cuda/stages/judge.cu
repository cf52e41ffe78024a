// Last stages: verdicts. First by filters alone, then in full on the few pairs they leave.
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/screen.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
// Of a multiprocessor; more of them, with so long a code, disturb each other.
constexpr unsigned kFullBlocksEach = 2;

// By floating-point filters alone.
__device__ PartVerdict quickVerdict(const CycleView& c, const Candidate& candidate, const Member& a,
                                    const Member& b) {
  const SharedVertices shared = unpackShared(candidate.signs);
  if (shared.any) {
    const bool apart = c.params->predicates != Predicates::kFast &&
                       certainlyNotBeyondShared(a.posed, b.posed, shared);
    return apart ? PartVerdict::kApart : PartVerdict::kOpen;
  }
  const PartVerdict verdict =
      quickIntersection(a.posed, b.posed, unpackSides(candidate.signs), c.params->predicates);
  // Within a margin, those that are apart may be contacts too.
  const bool near = verdict == PartVerdict::kApart && c.params->margins != 0;
  return near ? PartVerdict::kOpen : verdict;
}

// What the filters left open, without asking them again: most of this code's time goes into
// fetching it.
__device__ Verdict fullVerdict(const CycleView& c, const Candidate& candidate, const Member& a,
                               const Member& b, PredicateState& state) {
  const SharedVertices shared = unpackShared(candidate.signs);
  if (shared.any) return {meetBeyondShared(a.posed, b.posed, shared, state), 0};
  if (robustIntersection(a.posed, b.posed, unpackSides(candidate.signs), state)) return {true, 0};
  return nearVerdict(a.posed, b.posed, c.params->margins == 0 ? 0 : marginOf(c, a, b));
}

// A whole warp, of which some lanes have a contact.
__device__ void reportContacts(const CycleView& c, bool contact, std::uint32_t a, std::uint32_t b,
                               float separation_m) {
  const unsigned long long place = warpReserve(&c.counters->contacts, contact);
  if (!contact || place >= c.contact_capacity) return;
  c.contacts[place] = std::uint64_t{min(a, b)} << c.params->index_bits | max(a, b);
  if (c.params->margins != 0) c.separations_m[place] = separation_m;
}

// Settles most candidates; the others are put off.
__global__ void __launch_bounds__(kThreads) quickKernel(CycleView c) {
  letNextStart();  // the kernel ahead has ended: this one is launched the usual way
  const auto count = static_cast<std::uint32_t>(
      min(c.counters->candidates, static_cast<unsigned long long>(c.candidate_capacity)));
  for (std::uint32_t first = blockIdx.x * kThreads; first < count; first += gridDim.x * kThreads) {
    const std::uint32_t i = first + threadIdx.x;
    PartVerdict verdict = PartVerdict::kApart;
    std::uint32_t a = 0, b = 0;
    if (i < count) {
      const Candidate candidate = c.candidates[i];
      const Member member_a = c.members[candidate.a], member_b = c.members[candidate.b];
      a = member_a.triangle;
      b = member_b.triangle;
      verdict = quickVerdict(c, candidate, member_a, member_b);
    }
    const bool open = verdict == PartVerdict::kOpen;
    const std::uint32_t place = warpReserve(&c.counters->open, open);
    if (open) c.open[place] = i;  // as many places as candidates
    reportContacts(c, verdict == PartVerdict::kMeet, a, b, 0);
  }
}

__global__ void __launch_bounds__(kThreads) fullKernel(CycleView c) {
  awaitKernelAhead();
  const std::uint32_t count = c.counters->open;
  // Few pairs are spread over many warps, for their long paths differ.
  const std::uint32_t warps = gridDim.x * (kThreads / kWarp);
  const std::uint32_t each = min(kWarp, (count + warps - 1) / warps);
  const std::uint32_t warp = (blockIdx.x * kThreads + threadIdx.x) / kWarp;
  for (std::uint32_t first = warp * each; first < count; first += warps * each) {
    const std::uint32_t i = first + laneId();
    Verdict verdict;
    PredicateState state;
    state.mode = c.params->predicates;
    std::uint32_t a = 0, b = 0;
    if (laneId() < each && i < count) {
      const Candidate candidate = c.candidates[c.open[i]];
      const Member member_a = c.members[candidate.a], member_b = c.members[candidate.b];
      a = member_a.triangle;
      b = member_b.triangle;
      verdict = fullVerdict(c, candidate, member_a, member_b, state);
    }
    __syncwarp();
    warpCount(&c.counters->exact, state.exact > 0);
    warpCount(&c.counters->undecided, verdict.contact && state.undecided);
    reportContacts(c, verdict.contact, a, b, verdict.separation_m);
  }

  // The last block to get here has seen all counters settle.
  __shared__ bool last;
  __syncthreads();
  if (threadIdx.x == 0) {
    __threadfence();
    last = atomicAdd(&c.counters->blocks_done, 1U) == gridDim.x - 1;
    if (last) c.counters->judged += __ldcg(&c.counters->candidates);
    __threadfence();
  }
  __syncthreads();
  if (!last) return;
  // Not through the first-level cache, which may hold older ones.
  static_assert(sizeof(CycleCounters) % sizeof(std::uint32_t) == 0);
  const auto* from = reinterpret_cast<const std::uint32_t*>(c.counters);
  auto* to = reinterpret_cast<std::uint32_t*>(c.host_counters);
  for (unsigned k = threadIdx.x; k < sizeof(CycleCounters) / sizeof(std::uint32_t); k += kThreads) {
    to[k] = __ldcg(from + k);
  }
}

__global__ void restartKernel(CycleView c, bool first) {
  CycleCounters* counters = c.counters;
  counters->candidates = 0;
  counters->open = counters->blocks_done = counters->units_taken = 0;
  if (!first) return;
  counters->contacts = 0;
  counters->exact = counters->undecided = 0;
  counters->judged = 0;
}

}  // namespace

void launchRestart(const CycleView& cycle, bool first, cudaStream_t stream) {
  restartKernel<<<1, 1, 0, stream>>>(cycle, first);
}

void launchJudge(const CycleView& cycle, const DeviceTraits& device, cudaStream_t stream) {
  quickKernel<<<blocksInOneWave(quickKernel, kThreads, 0, device), kThreads, 0, stream>>>(cycle);
  launchEarly(fullKernel, kFullBlocksEach * device.multiprocessors, kThreads, 0, device, stream,
              cycle);
}

}  // namespace deformable_contact_monitor
