// The pairs with a very large or far-off triangle: boxes against the clusters, their members, and
// each other.
#include "cuda/device/boxes.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/screen.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 256;
// Blocks beyond one per cluster, for the large triangles among themselves.
constexpr unsigned kBlocksAmong = 64;

__device__ bool classesMeet(const CycleView& c, const Member& a, const Member& b) {
  const std::uint32_t x = c.bodies[a.body_and_home >> 1].class_of_body;
  const std::uint32_t y = c.bodies[b.body_and_home >> 1].class_of_body;
  return (c.class_mask[x] >> y & 1) != 0;
}

__device__ uint4 idsOf(const CycleView& c, const Member& m) {
  const std::uint32_t* vertices = c.corners + 3 * std::size_t{m.triangle};
  return make_uint4(c.vertex_id[vertices[0]], c.vertex_id[vertices[1]], c.vertex_id[vertices[2]],
                    0);
}

// Two members whose boxes overlap.
__device__ void meet(const CycleView& c, std::uint32_t at_a, std::uint32_t at_b) {
  const Member a = c.members[at_a], b = c.members[at_b];
  if (!classesMeet(c, a, b)) return;
  const uint4 ids_a = idsOf(c, a), ids_b = idsOf(c, b);
  const std::uint32_t shared_a = sharedBits(ids_a, ids_b);
  if (shared_a != 0 && c.params->adjacent == AdjacentPairs::kSkip) return;
  Candidate candidate;
  if (!isCandidate(c, kNone, at_a, at_b, shared_a, shared_a == 0 ? 0 : sharedBits(ids_b, ids_a),
                   candidate)) {
    return;
  }
  const unsigned long long place = atomicAdd(&c.counters->candidates, 1ULL);
  if (place < c.candidate_capacity) c.candidates[place] = candidate;
}

// Passes over the same pairs again are the same work to who reads the counters.
__device__ bool isFirstSweep(const CycleView& c) { return c.params->passes == 1; }

__global__ void __launch_bounds__(kThreads) largeKernel(CycleView c) {
  const Bin large = c.bins[c.cluster_count];
  const std::uint32_t large_count = min(c.counters->large, large.capacity);
  if (large_count == 0 || blockIdx.x % c.params->passes != c.params->pass) return;
  if (blockIdx.x >= c.cluster_count) {  // rows of the large list, each against the later ones
    unsigned long long pairs = 0;
    for (std::uint32_t i = blockIdx.x - c.cluster_count; i < large_count; i += kBlocksAmong) {
      const Aabb box = memberBox(c, c.members[large.begin + i]);
      for (std::uint32_t j = i + 1 + threadIdx.x; j < large_count; j += kThreads) {
        ++pairs;
        if (overlap(box, memberBox(c, c.members[large.begin + j]))) {
          meet(c, large.begin + i, large.begin + j);
        }
      }
    }
    if (pairs != 0 && isFirstSweep(c)) atomicAdd(&c.counters->interval_overlaps, pairs);
    return;
  }

  __shared__ BlockBox shared_box;
  __shared__ std::uint32_t near[kThreads], near_count;
  const Bin bin = c.bins[blockIdx.x];
  const std::uint32_t count = min(countOf(c, blockIdx.x), bin.capacity);
  shared_box.clear();
  Aabb own;  // of this thread's members
  for (std::uint32_t m = threadIdx.x; m < count; m += kThreads) {
    const Member member = c.members[bin.begin + m];
    if ((member.body_and_home & 1) != 0) own.include(memberBox(c, member));
  }
  shared_box.include(own);
  const Aabb cluster_box = shared_box.get();
  unsigned long long pairs = 0;
  for (std::uint32_t first = 0; first < large_count; first += kThreads) {
    if (threadIdx.x == 0) near_count = 0;
    __syncthreads();
    const std::uint32_t i = first + threadIdx.x;
    if (i < large_count && overlap(cluster_box, memberBox(c, c.members[large.begin + i]))) {
      near[atomicAdd(&near_count, 1U)] = large.begin + i;
    }
    __syncthreads();
    for (std::uint32_t m = threadIdx.x; near_count > 0 && m < count; m += kThreads) {
      const Member member = c.members[bin.begin + m];
      if ((member.body_and_home & 1) == 0) continue;  // met at home
      const Aabb box = memberBox(c, member);
      pairs += near_count;
      for (std::uint32_t k = 0; k < near_count; ++k) {
        if (overlap(box, memberBox(c, c.members[near[k]]))) meet(c, bin.begin + m, near[k]);
      }
    }
    __syncthreads();
  }
  if (pairs != 0 && isFirstSweep(c)) atomicAdd(&c.counters->interval_overlaps, pairs);
}

}  // namespace

std::uint32_t largeBlocks(const CycleView& cycle) { return cycle.cluster_count + kBlocksAmong; }

void launchLarge(const CycleView& cycle, cudaStream_t stream) {
  largeKernel<<<largeBlocks(cycle), kThreads, 0, stream>>>(cycle);
}

}  // namespace deformable_contact_monitor
