// Stage judge in swept motion, third part: triangles that share vertices.
#include "core/predicates/swept_adjacency.h"
#include "cuda/stages/narrow_phase_moving.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;

__device__ SharedVertices sharedOf(const DeviceCandidate& candidate) {
  const std::uint32_t bits = sharedBitsOf(candidate);
  return sharedByBits(bits & 7, bits >> 3);
}

// In float32, whether the two certainly do not meet beyond what they share.
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

// The pairs at the end of contacts.open; what is left comes to first_list.
__global__ void __launch_bounds__(kThreads) sharersKernel(CycleArrays c) {
  forEachByWarp(c, c.counters().sharing, [&](Place k, bool there) {
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

// A thread for each of contacts.first_list.
__global__ void __launch_bounds__(kThreads) beyondKernel(CycleArrays c) {
  const CycleParams& params = c.params();
  const std::uint32_t count = sweptCounters(c).beyond;
  // Few pairs are spread over many warps, for their long paths differ.
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
      verdict = quickSweptBeyondShared<double>(movingAt(c, pair.a), movingAt(c, pair.b),
                                               sharedOf(pair), params.first_times != 0, state);
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

void launchSharers(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  launchList(sharersKernel, kThreads, cycle, shape, stream);
  launchList(beyondKernel, kThreads, cycle, shape, stream);
}

}  // namespace deformable_contact_monitor
