// Stage narrow_phase in swept motion, third part: decides pairs of triangles that share vertices.
// Such a pair is a contact only if it meets beyond the shared vertices. A float32 filter comes
// first; the rest is decided in double, or left to the host.
#include "core/predicates/swept_adjacency.h"
#include "cuda/stages/narrow_phase_moving.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
// Shortcuts need more registers than they save time here.
constexpr unsigned kBeyondFilters = kAllSweptFilters & ~kShortcuts;

__device__ SharedVertices sharedOf(const DeviceCandidate& candidate) {
  const std::uint32_t bits = sharedBitsOf(candidate);
  return sharedByBits(bits & 7, bits >> 3);
}

// Returns whether float32 is certain that the triangles do not meet beyond their shared vertices.
// With two shared vertices, it tests whether the two remaining vertices can become coplanar with
// the shared edge. With one, it tests whether a plane separates the triangles around that vertex.
__device__ bool certainlyNotBeyond(const MovingTriangle& a, const MovingTriangle& b,
                                   const SharedVertices& shared) {
  const SharedSplit split(a, b, shared);
  if (split.a_count == 0 || split.b_count == 0) return true;
  if (isStill(a) && isStill(b)) return false;
  if (split.common_count == 2) {
    const Feature fold{FeatureKind::kFold,
                       {split.common[0], split.common[1], split.rest_a[0], split.rest_b[0]}};
    detail::FeaturePiece<float> piece;
    piece.d = coplanarity<float>(fold);
    return piece.d.sign() != 0 || !detail::setOrientations(fold, piece);
  }
  return split.common_count == 1 && split.a_count == 2 && split.b_count == 2 &&
         detail::certainlyApartAround<float, kAllSweptFilters>(split.common[0], split.rest_a,
                                                               split.rest_b);
}

// One thread for each pair at the end of contacts.open: adds pairs that float32 leaves open to
// first_list.
__global__ void __launch_bounds__(kThreads) adjacentKernel(CycleArrays c) {
  followPrevious();
  forEachByWarp(c, c.counters().open_adjacent, [&](Place k, bool there) {
    Place i(0);
    bool left = false;
    if (there) {
      i = c.contacts.open[Place(c.contacts.open.size() - 1 - k.value)];
      const DeviceCandidate pair = c.contacts.candidates[i];
      left = !certainlyNotBeyond(movingAt(c, pair.a), movingAt(c, pair.b), sharedOf(pair));
    }
    append(c.contacts.first_list, &sweptCounters(c).beyond, left, i);
  });
}

// One thread for each of contacts.first_list: decides the pair in double, adds it to the contacts,
// or leaves it to the host.
__global__ void __launch_bounds__(kThreads) beyondKernel(CycleArrays c) {
  followPrevious();
  const CycleParams& params = c.params();
  const std::uint32_t count = sweptCounters(c).beyond;
  // Spreads few pairs over many warps, because the lanes of a warp wait for each other's longest
  // path.
  const std::uint32_t warps = gridDim.x * (kThreads / kWarp);
  const std::uint32_t each = min(kWarp, (count + warps - 1) / warps);
  const std::uint32_t warp = (blockIdx.x * kThreads + threadIdx.x) / kWarp;
  for (std::uint32_t first = warp * each; first < count; first += warps * each) {
    if (first >= warps * each && warpIsCutOff(c, warp % kWarpsPerAsker == 0)) break;
    const std::uint32_t k = first + laneId();
    Place i(0);
    SweptVerdict verdict;
    PredicateState state;
    state.mode = params.predicates;
    if (laneId() < each && k < count) {
      i = c.contacts.first_list[Place(k)];
      const DeviceCandidate pair = c.contacts.candidates[i];
      verdict = quickSweptBeyondShared<double, kBeyondFilters>(
          movingAt(c, pair.a), movingAt(c, pair.b), sharedOf(pair), params.first_times != 0, state);
      if (verdict.part == PartVerdict::kOpen) leaveToHost(c, i, verdict);
    }
    __syncwarp();
    const bool meets = verdict.part == PartVerdict::kMeet;
    warpCount(&c.counters().exact, state.exact > 0);
    warpCount(&c.counters().undecided, meets && state.undecided);
    reportMoving(c, meets, i, {verdict.first_low, verdict.first_high});
  }
}

}  // namespace

void launchNarrowPhaseAdjacent(const CycleArrays& cycle, const CycleShape& shape,
                               cudaStream_t stream) {
  for (const auto kernel : {adjacentKernel, beyondKernel}) {  // plain launches are faster here
    kernel<<<blocksInOneWave(kernel, kThreads, 0, shape.device), kThreads, 0, stream>>>(cycle);
  }
}

}  // namespace deformable_contact_monitor
