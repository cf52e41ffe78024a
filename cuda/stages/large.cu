// Stage large: the pairs with a very large or far-off triangle: boxes against the clusters, their
// members, and each other.
#include "cuda/device/boxes.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/cut_off.cuh"
#include "cuda/stages/report.cuh"
#include "cuda/stages/screen.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/swept_pairs.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 256;
// Blocks beyond one per cluster, for the large triangles among themselves.
constexpr unsigned kBlocksAmong = 64;

__device__ bool groupsMeet(const SceneArrays& scene, const Member& a, const Member& b) {
  const std::uint32_t x = scene.bodies[a.body()].group, y = scene.bodies[b.body()].group;
  return (scene.group_mask[Place(x)] >> y & 1) != 0;
}

__device__ uint4 idsOf(const SceneArrays& scene, const Member& m) {
  const VertexIndex* vertices = scene.corners.row(m.triangle);
  return make_uint4(scene.vertex_id[vertices[0]].value, scene.vertex_id[vertices[1]].value,
                    scene.vertex_id[vertices[2]].value, 0);
}

// Of all that a member passes, in swept motion (kStates == 2) but for the common motion.
template <int kStates>
__device__ Aabb boxAt(const CycleArrays& c, MemberIndex at) {
  return kStates > 1 ? sweptMemberBox(c, at) : memberBox(c, c.members.members[at]);
}

// Two members whose boxes meet: adds to contacts.contacts or contacts.candidates if they are one.
template <int kStates>
__device__ void screenBoxPair(const CycleArrays& c, MemberIndex at_a, MemberIndex at_b) {
  const Member a = c.members.members[at_a], b = c.members.members[at_b];
  if (!groupsMeet(c.scene, a, b)) return;
  const uint4 ids_a = idsOf(c.scene, a), ids_b = idsOf(c.scene, b);
  const std::uint32_t shared_a = sharedBits(ids_a, ids_b);
  if (shared_a != 0 &&
      (c.params().adjacent == AdjacentPairs::kSkip || isCertified(ids_a, shared_a))) {
    return;
  }
  DeviceCandidate candidate;
  const std::uint32_t shared_b = shared_a == 0 ? 0 : sharedBits(ids_b, ids_a);
  const auto screen = kStates > 1 ? screenMovingPair : screenPair;
  if (!screen(c, ClusterIndex(kNone), at_a, at_b, shared_a, shared_b, candidate)) return;
  if (kStates == 1 && c.params().settles != 0) {
    const PartVerdict verdict = certainVerdict(a.posed, b.posed, unpackFacts(candidate.facts));
    if (verdict != PartVerdict::kOpen) atomicAdd(&c.counters().settled, 1ULL);
    if (verdict == PartVerdict::kMeet) {
      putContact(c, atomicAdd(&c.counters().contacts, 1ULL), a.triangle, b.triangle, 0);
    }
    if (verdict != PartVerdict::kOpen) return;
  }
  const unsigned long long place = atomicAdd(&c.counters().candidates, 1ULL);
  if (place < c.contacts.candidates.size()) {
    c.contacts.candidates[Place(static_cast<std::uint32_t>(place))] = candidate;
  }
}

// Each row of the large list from `first` on, in steps of kBlocksAmong, against the later ones.
// Returns how many pairs of boxes this thread looked at.
template <int kStates>
__device__ unsigned long long sweepAmong(const CycleArrays& c, const Bin& large,
                                         std::uint32_t large_count, std::uint32_t first) {
  unsigned long long pairs = 0;
  PacedCutOff pace(c, threadIdx.x == 0);
  for (std::uint32_t i = first; i < large_count; i += kBlocksAmong) {
    const MemberIndex at(large.begin + i);
    const Aabb box = boxAt<kStates>(c, at);
    for (std::uint32_t j = i + 1 + threadIdx.x; j < large_count; j += kThreads) {
      if (pace.isOver(1)) return pairs;
      ++pairs;
      const MemberIndex other(large.begin + j);
      if (intersects(box, boxAt<kStates>(c, other))) screenBoxPair<kStates>(c, at, other);
    }
  }
  return pairs;
}

// By the whole block: of the members that are at home in the cluster.
template <int kStates>
__device__ Aabb homeBox(const CycleArrays& c, std::uint32_t begin, std::uint32_t count) {
  __shared__ BlockBox shared_box;
  shared_box.clear();
  Aabb own;  // of this thread's members
  for (std::uint32_t m = threadIdx.x; m < count; m += kThreads) {
    const MemberIndex at(begin + m);
    if (c.members.members[at].isHome()) own.include(boxAt<kStates>(c, at));
  }
  shared_box.include(own);
  return shared_box.get();
}

// The large list against the members that are at home in a cluster, by the whole block. Returns how
// many pairs of boxes this thread looked at.
template <int kStates>
__device__ unsigned long long sweepCluster(const CycleArrays& c, const Bin& large,
                                           std::uint32_t large_count, ClusterIndex cluster) {
  __shared__ MemberIndex near[kThreads];
  __shared__ std::uint32_t near_count;
  const std::uint32_t begin = c.members.bins[cluster].begin, count = c.members.present(cluster);
  const Aabb cluster_box = homeBox<kStates>(c, begin, count);
  unsigned long long pairs = 0;
  PacedCutOff pace(c, threadIdx.x == 0);
  for (std::uint32_t first = 0; first < large_count; first += kThreads) {
    if (threadIdx.x == 0) near_count = 0;
    __syncthreads();
    const MemberIndex at(large.begin + first + threadIdx.x);
    if (first + threadIdx.x < large_count && intersects(cluster_box, boxAt<kStates>(c, at))) {
      near[atomicAdd(&near_count, 1U)] = at;
    }
    __syncthreads();
    for (std::uint32_t m = threadIdx.x; near_count > 0 && m < count; m += kThreads) {
      if (pace.isOver(near_count)) break;
      const MemberIndex other(begin + m);
      if (!c.members.members[other].isHome()) continue;  // it has its turn there
      const Aabb box = boxAt<kStates>(c, other);
      pairs += near_count;
      for (std::uint32_t k = 0; k < near_count; ++k) {
        if (intersects(box, boxAt<kStates>(c, near[k]))) screenBoxPair<kStates>(c, other, near[k]);
      }
    }
    if (__syncthreads_or(pace.wasOver() ? 1 : 0) != 0) break;
  }
  return pairs;
}

// A block for each cluster, and kBlocksAmong for the large list itself: reads members.members, adds
// to contacts.candidates.
template <int kStates>
__global__ void __launch_bounds__(kThreads) largeKernel(CycleArrays c) {
  const ClusterIndex list(c.clusters.count);
  const Bin large = c.members.bins[list];
  const std::uint32_t large_count = min(c.counters().large, large.capacity);
  const CycleParams& params = c.params();
  if (large_count == 0 || blockIdx.x % params.passes != params.pass) return;
  const unsigned long long pairs =
      blockIdx.x < list.value
          ? sweepCluster<kStates>(c, large, large_count, ClusterIndex(blockIdx.x))
          : sweepAmong<kStates>(c, large, large_count, blockIdx.x - list.value);
  // Passes over the same pairs again are the same work to who reads the counters.
  if (pairs != 0 && params.passes == 1) atomicAdd(&c.counters().interval_overlaps, pairs);
}

}  // namespace

std::uint32_t largeBlocks(const CycleArrays& cycle) { return cycle.clusters.count + kBlocksAmong; }

void launchLarge(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  const auto kernel = shape.swept ? largeKernel<2> : largeKernel<1>;
  kernel<<<largeBlocks(cycle), kThreads, 0, stream>>>(cycle);
}

}  // namespace deformable_contact_monitor
