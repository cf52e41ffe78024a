// Stage assign: every triangle into each cluster that it may share a contact in.
#include "core/rules/sampling.h"
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/corners.cuh"
#include "cuda/stages/cut_off.cuh"
#include "cuda/stages/reach.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
// Bodies with more partners near them than this are not culled triangle by triangle.
constexpr unsigned kMostPartnerBoxes = 32;
// Triangles in more clusters than this are done by a warp each.
constexpr unsigned kShortList = 12;

// The boxes of a body's partners that meet its own, in shared memory for all triangles of a block.
struct PartnerBoxes {
  unsigned count;
  float low[kMostPartnerBoxes][3], high[kMostPartnerBoxes][3];

  __device__ void collect(const SceneArrays& scene, BodyIndex b) {
    const DeviceBody& body = scene.bodies[b];
    if (threadIdx.x == 0) count = 0;
    __syncthreads();
    const Aabb own = bodyBox(scene, b);
    for (unsigned p = threadIdx.x; p < body.partner_count; p += kThreads) {
      const Aabb partner = bodyBox(scene, scene.partners[Place(body.partner_begin + p)]);
      if (!intersects(own, partner)) continue;
      const unsigned place = atomicAdd(&count, 1U);
      if (place >= kMostPartnerBoxes) continue;
      for (int k = 0; k < 3; ++k) {
        low[place][k] = partner.min[k];
        high[place][k] = partner.max[k];
      }
    }
    __syncthreads();
  }
  __device__ bool meets(const Aabb& triangle) const {
    if (count > kMostPartnerBoxes) return true;
    for (unsigned p = 0; p < count; ++p) {
      const Aabb box{{low[p][0], low[p][1], low[p][2]}, {high[p][0], high[p][1], high[p][2]}};
      if (intersects(triangle, box)) return true;
    }
    return false;
  }
};

// By a whole block.
__device__ void countBlock(std::uint32_t* counter, bool counted) {
  const int count = __syncthreads_count(counted ? 1 : 0);
  if (threadIdx.x == 0 && count > 0) atomicAdd(counter, static_cast<std::uint32_t>(count));
}

template <int kStates>
__device__ void putMember(const CycleArrays& c, ClusterIndex bin, std::uint32_t place,
                          const Member& member, const Corners<kStates>& corners) {
  const Bin b = c.members.bins[bin];
  if (place < b.capacity) {
    const MemberIndex at(b.begin + place);
    c.members.members[at] = member;
    if (kStates > 1) c.members.earlier[at].posed = corners.earlier();
  } else {
    c.counters().bin_overflow = 1;
  }
}

// Lanes of a warp that put members into the same bin share an atomic.
template <int kStates>
__device__ void putTogether(const CycleArrays& c, ClusterIndex bin, const Member& member,
                            const Corners<kStates>& corners) {
  const unsigned peers = __match_any_sync(__activemask(), bin.value);
  const int leader = __ffs(static_cast<int>(peers)) - 1;
  std::uint32_t base = 0;
  if (laneId() == static_cast<unsigned>(leader)) {
    base = atomicAdd(&c.members.count(bin), __popc(peers));
  }
  base = __shfl_sync(peers, base, leader);
  putMember(c, bin, base + __popc(peers & ((1U << laneId()) - 1)), member, corners);
}

template <int kStates>
__device__ HalfSpaceRuleOf<3 * kStates> ruleOf(const CycleArrays& c, const PrototypesView& view,
                                               const Corners<kStates>& corners, float slack,
                                               std::uint32_t& first) {
  const ScaledCorners<kStates> scaled(c, corners);
  return ruleFor<3 * kStates>(view, scaled.v, corners.nearest, c.params().overlap, slack, first);
}

template <int kStates>
__device__ void takeSample(const CycleArrays& c, TriangleIndex t, bool regular,
                           const Corners<kStates>& corners) {
  const Sampling sampling{c.clusters.sample_count, c.scene.triangle_count};
  if (!sampling.isSample(t.value)) return;
  Sample sample{{}, ClusterIndex(kNone)};
  if (regular) {
    const ScaledCorners<kStates> scaled(c, corners);
    Vec3f centroid = centroidOf(scaled.v);
    if (kStates > 1) centroid = (centroid + centroidOf(scaled.v + 3 * (kStates - 1))) * 0.5F;
    sample = {centroid, ClusterIndex(corners.nearest[0].cluster)};
  }
  c.clusters.samples[Place(sampling.sampleOf(t.value))] = sample;
}

// Which of the prototypes near a triangle admit it, as bits of their places on a list of
// neighbours.
class AdmittedNeighbours {
 public:
  // All clusters of the triangle are those of the list, if true; else the list does not reach far
  // enough.
  template <int kStates>
  __device__ bool find(const CycleArrays& c, const PrototypesView& view,
                       const Corners<kStates>& corners, float slack) {
    static_assert(kMostNeighbours == 128);
    float radius;
    const auto rule = ruleOf(c, view, corners, slack, first_);
    if (!listSuffices(view, rule, first_, radius)) return false;
    in_first_ = rule.admits(view.prototypes[first_]);
    forEachListed(view, rule, first_, radius, [this](std::uint32_t place) {
      places_[place < 64 ? 0 : 1] |= std::uint64_t{1} << place % 64;
    });
    return true;
  }
  __device__ std::uint32_t count() const {
    return __popcll(places_[0]) + __popcll(places_[1]) + (in_first_ ? 1 : 0);
  }
  // visit(cluster) for each, in no particular order.
  template <class Visit>
  __device__ void forEach(const PrototypesView& view, const Visit& visit) const {
    const std::uint32_t* cluster_at = view.neighbour_cluster + view.listBegin(first_);
    if (in_first_) visit(first_);
    for (int half = 0; half < 2; ++half) {
      for (std::uint64_t rest = places_[half]; rest != 0; rest &= rest - 1) {
        visit(cluster_at[64 * half + __ffsll(static_cast<long long>(rest)) - 1]);
      }
    }
  }

 private:
  std::uint32_t first_ = 0;  // the first competitor, whose list it is
  bool in_first_ = false;
  std::uint64_t places_[2] = {0, 0};
};

// A member that is to be put into a cluster; of one warp, in shared memory.
struct PendingMember {
  TriangleIndex triangle;
  std::uint32_t list;              // see Member
  std::uint32_t cluster_and_home;  // cluster * 2 + 1 if it is the triangle's lowest
};
constexpr unsigned kMostPending = kWarp * kShortList;

// By a whole warp: writes the ascending list of each lane's clusters and hands out its members.
// Lanes without a triangle have none admitted. Returns how many are pending in the warp.
__device__ std::uint32_t listMembers(const CycleArrays& c, TriangleIndex t, std::uint32_t length,
                                     const AdmittedNeighbours& admitted, PendingMember* pending) {
  const PrototypesView view = c.clusters.view();
  const std::uint32_t words = length > 1 ? length + 1 : 0;
  const std::uint32_t place = warpReserve(&c.counters().list_words, words);
  const bool listed = words > 0 && place + words <= c.members.lists.size();
  if (listed) c.members.lists[Place(place)] = length;
  std::uint32_t total, next = warpPrefix(length, total);
  if (length > 0) {
    // Ranks by counting: lists are short, and need no array then.
    admitted.forEach(view, [&](std::uint32_t g) {
      std::uint32_t rank = 0;
      admitted.forEach(view, [&](std::uint32_t other) { rank += other < g ? 1 : 0; });
      if (listed) c.members.lists[Place(place + 1 + rank)] = g;
      pending[next++] = {t, listed ? place : kNone, g << 1 | (rank == 0 ? 1U : 0U)};
    });
  }
  __syncwarp();
  return total;
}

// By a whole warp, a lane for each: triangles that may be in several clusters. Those in too many
// become wide ones.
template <int kStates>
__device__ void assignBorder(const CycleArrays& c, BodyIndex body, TriangleIndex t, bool wanted,
                             PendingMember* pending) {
  AdmittedNeighbours admitted;
  std::uint32_t length = 0;
  if (wanted) {
    const bool all = admitted.find(c, c.clusters.view(), Corners<kStates>(c.scene, t),
                                   c.scene.bodies[body].slack);
    length = admitted.count();
    if (!all || length > kShortList) {
      c.members.wide[Place(atomicAdd(&c.counters().wide, 1U))] = {t, body};
      length = 0;
    }
  }
  const std::uint32_t total = listMembers(c, t, length, admitted, pending);
  for (std::uint32_t m = laneId(); m < total; m += kWarp) {
    const PendingMember member = pending[m];
    const Corners<kStates> corners(c.scene, member.triangle);
    putTogether(c, ClusterIndex(member.cluster_and_home >> 1),
                {corners.posed(), member.triangle, member.list,
                 body.value << 1 | (member.cluster_and_home & 1)},
                corners);
  }
  __syncwarp();  // before the next ones
}

// By a whole block: those of its triangles that are not in the interior of a cell, closed up.
template <int kStates>
__device__ void assignBorders(const CycleArrays& c, const BodyBlock& block, TriangleIndex t,
                              bool border) {
  __shared__ TriangleIndex borders[kThreads];
  __shared__ std::uint32_t count;
  __shared__ PendingMember pending[kThreads / kWarp][kMostPending];
  if (threadIdx.x == 0) count = 0;
  __syncthreads();
  const std::uint32_t at = warpReserve(&count, border);
  if (border) borders[at] = t;
  __syncthreads();
  const std::uint32_t warp = threadIdx.x / kWarp;
  for (std::uint32_t first = warp * kWarp; first < count; first += kThreads) {
    const std::uint32_t mine = first + laneId();
    const bool there = mine < count;
    assignBorder<kStates>(c, block.body, there ? borders[mine] : TriangleIndex(block.first), there,
                          pending[warp]);
  }
}

// A thread for each triangle, a block for each of scene.triangle_blocks: reads scene.corners,
// scene.posed, scene.body_boxes; adds to members.members, members.lists and members.wide. In swept
// motion (kStates == 2) the earlier states too, to members.earlier.
template <int kStates>
__global__ void __launch_bounds__(kThreads) assignKernel(CycleArrays c) {
  awaitKernelAhead();
  letNextStart();
  __shared__ PartnerBoxes partners;
  const BodyBlock block = c.scene.triangle_blocks[Place(blockIdx.x)];
  const DeviceBody& body = c.scene.bodies[block.body];
  if (body.has_self == 0) partners.collect(c.scene, block.body);

  const bool inside = threadIdx.x < block.count;
  const TriangleIndex t(block.first + (inside ? threadIdx.x : 0));
  const Corners<kStates> corners(c.scene, t);
  const Member member{corners.posed(), t, kNone, block.body.value << 1 | 1};
  const bool finite = corners.isFinite();
  const Aabb box = inflated(corners.box(c), body.margin_m);
  const bool near = finite && (body.has_self != 0 || partners.meets(box));
  const SceneShare& share = c.params().share;
  const bool here = near && (share.isWhole() || corners.reachesInto(share, body.margin_m));
  const bool large = here && c.params().size.isLarge(box);
  const bool regular = inside && here && !large;
  warpCount(&c.counters().rejected, inside && !finite);
  countBlock(&c.counters().culled, inside && finite && !near);
  countBlock(&c.counters().clustered, regular);
  if (inside) takeSample(c, t, regular, corners);
  if (inside && large) {
    putMember(c, ClusterIndex(c.clusters.count), atomicAdd(&c.counters().large, 1U), member,
              corners);
  }
  const bool interior = isInterior<3 * kStates>(corners.nearest);
  if (regular && interior) {
    putTogether(c, ClusterIndex(corners.nearest[0].cluster), member, corners);
  }
  assignBorders<kStates>(c, block, t, regular && !interior);
}

// A warp for each of members.wide, over all prototypes in ascending order: adds to members.members
// and members.lists.
template <int kStates>
__global__ void __launch_bounds__(kThreads) assignWideKernel(CycleArrays c) {
  awaitKernelAhead();
  const PrototypesView view = c.clusters.view();
  const std::uint32_t count = c.counters().wide;
  const std::uint32_t warps = gridDim.x * (kThreads / kWarp);
  const std::uint32_t rounded = (view.count + kWarp - 1) / kWarp * kWarp;
  const std::uint32_t warp = (blockIdx.x * kThreads + threadIdx.x) / kWarp;
  for (std::uint32_t i = warp; i < count; i += warps) {
    if (warpIsCutOff(c, warp % kWarpsPerAsker == 0)) return;
    const WideTriangle wide = c.members.wide[Place(i)];
    const Corners<kStates> corners(c.scene, wide.triangle);
    std::uint32_t first;
    const auto rule = ruleOf(c, view, corners, c.scene.bodies[wide.body].slack, first);
    const auto admitted = [&](std::uint32_t g) {
      return g < view.count && rule.admits(view.prototypes[g]);
    };
    std::uint32_t length = 0;
    for (std::uint32_t g = laneId(); g < rounded; g += kWarp) {
      length += __popc(__ballot_sync(kFullWarp, admitted(g)));
    }
    std::uint32_t place = 0;
    if (laneId() == 0) place = atomicAdd(&c.counters().list_words, length + 1);
    place = __shfl_sync(kFullWarp, place, 0);
    const bool fits = place + length + 1 <= c.members.lists.size();
    if (fits && laneId() == 0) c.members.lists[Place(place)] = length;
    Member member{corners.posed(), wide.triangle, fits ? place : kNone, 0};
    std::uint32_t before = 0;
    for (std::uint32_t g = laneId(); g < rounded; g += kWarp) {
      const bool in = admitted(g);
      const unsigned mask = __ballot_sync(kFullWarp, in);
      const std::uint32_t k = before + __popc(mask & ((1U << laneId()) - 1));
      before += __popc(mask);
      if (!in) continue;
      if (fits) c.members.lists[Place(place + 1 + k)] = g;
      member.body_and_home = wide.body.value << 1 | (k == 0 ? 1 : 0);
      const ClusterIndex bin(g);
      putMember(c, bin, atomicAdd(&c.members.count(bin), 1U), member, corners);
    }
  }
}

template <int kStates>
void launch(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  launchEarly(assignKernel<kStates>, cycle.scene.triangle_block_count, kThreads, 0, shape.device,
              stream, cycle);
  launchEarly(assignWideKernel<kStates>,
              blocksInOneWave(assignWideKernel<kStates>, kThreads, 0, shape.device), kThreads, 0,
              shape.device, stream, cycle);
}

}  // namespace

void launchAssign(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  shape.swept ? launch<2>(cycle, shape, stream) : launch<1>(cycle, shape, stream);
}

}  // namespace deformable_contact_monitor
