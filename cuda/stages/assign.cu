// Second stage: every triangle into each cluster that it may share a contact in.
#include "cuda/device/boxes.cuh"
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
// Bodies with more partners near them than this are not culled triangle by triangle.
constexpr unsigned kMostPartnerBoxes = 32;
// Triangles in more clusters than this are done by a warp each.
constexpr unsigned kShortList = 12;
// Lanes that find the clusters of one triangle together; a power of two.
constexpr unsigned kTeam = 2;
constexpr unsigned kTeams = kWarp / kTeam;  // in a warp

// The boxes of a body's partners that meet its own, for all triangles of a block.
struct PartnerBoxes {
  unsigned count;
  float low[kMostPartnerBoxes][3], high[kMostPartnerBoxes][3];

  __device__ void collect(const CycleView& c, std::uint32_t b) {
    const DeviceBody& body = c.bodies[b];
    if (threadIdx.x == 0) count = 0;
    __syncthreads();
    const Aabb own = bodyBox(c, b);
    for (unsigned p = threadIdx.x; p < body.partner_count; p += kThreads) {
      const Aabb partner = bodyBox(c, c.partners[body.partner_begin + p]);
      if (!overlap(own, partner)) continue;
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
      if (overlap(triangle, box)) return true;
    }
    return false;
  }
};

// By a whole block.
__device__ void countBlock(std::uint32_t* counter, bool counted) {
  const int count = __syncthreads_count(counted ? 1 : 0);
  if (threadIdx.x == 0 && count > 0) atomicAdd(counter, static_cast<std::uint32_t>(count));
}

struct Corner {
  Vec3f v;
  Winner winner;
};

__device__ Corner cornerAt(const CycleView& c, std::uint32_t vertex) {
  const float4 p = c.posed[vertex];
  const std::uint32_t w = __float_as_uint(p.w);
  return {{p.x, p.y, p.z}, {w >> 1, (w & 1) != 0}};
}

__device__ void putMember(const CycleView& c, std::uint32_t bin, std::uint32_t place,
                          const Member& member) {
  const Bin b = c.bins[bin];
  if (place < b.capacity) {
    c.members[b.begin + place] = member;
  } else {
    c.counters->bin_overflow = 1;
  }
}

// Lanes of a warp that put members into the same bin share an atomic.
__device__ void putTogether(const CycleView& c, std::uint32_t bin, const Member& member) {
  const unsigned peers = __match_any_sync(__activemask(), bin);
  const int leader = __ffs(static_cast<int>(peers)) - 1;
  std::uint32_t base = 0;
  if (laneId() == static_cast<unsigned>(leader)) {
    base = atomicAdd(&countOf(c, bin), __popc(peers));
  }
  base = __shfl_sync(peers, base, leader);
  putMember(c, bin, base + __popc(peers & ((1U << laneId()) - 1)), member);
}

__device__ HalfSpaceRule ruleOf(const CycleView& c, const PrototypesView& view,
                                const Corner corner[3], float slack, std::uint32_t& first) {
  const SceneScale scale = c.params->scale;
  const Vec3f scaled[3] = {scale.apply(corner[0].v), scale.apply(corner[1].v),
                           scale.apply(corner[2].v)};
  const Winner w[3] = {corner[0].winner, corner[1].winner, corner[2].winner};
  return ruleFor(view, scaled, w, c.params->overlap, slack, first);
}

__device__ void takeSample(const CycleView& c, std::uint32_t t, bool regular,
                           const Corner corner[3]) {
  // Slot s is written by the first triangle of those with t * samples / triangles == s.
  const std::uint64_t scaled = std::uint64_t{t} * c.sample_count;
  if (scaled % c.triangle_count >= c.sample_count) return;
  Sample sample{{}, kNone};
  if (regular) {
    const SceneScale scale = c.params->scale;
    sample.centroid =
        (scale.apply(corner[0].v) + scale.apply(corner[1].v) + scale.apply(corner[2].v)) *
        (1.0F / 3);
    sample.near = corner[0].winner.cluster;
  }
  c.samples[scaled / c.triangle_count] = sample;
}

// Of one warp, in shared memory: which triangle goes into which cluster.
struct Entry {
  std::uint32_t triangle, list;
  std::uint32_t cluster_and_home;  // cluster * 2 + 1 if it is the lowest
};

// By a whole warp, a team for each: triangles that may be in several clusters.
__device__ void assignBorder(const CycleView& c, std::uint32_t body, std::uint32_t t, bool wanted,
                             Entry* entries) {
  const std::uint32_t* vertices = c.corners + 3 * std::size_t{t};
  const Corner corner[3] = {cornerAt(c, vertices[0]), cornerAt(c, vertices[1]),
                            cornerAt(c, vertices[2])};
  const PrototypesView view = prototypesView(c);
  std::uint32_t first = 0;
  bool in_first = false;
  std::uint64_t places[2] = {0, 0};  // bits: in the list of the first competitor
  static_assert(kMostNeighbours == 128);
  bool is_short = false;
  if (wanted) {
    float radius;
    const HalfSpaceRule rule = ruleOf(c, view, corner, c.bodies[body].slack, first);
    is_short = listSuffices(view, rule, first, radius);
    if (is_short) {
      in_first = rule.admits(view.prototypes[first]);
      const Share share{laneId() % kTeam, kTeam};
      forEachListed(view, rule, first, radius, share, [&places](std::uint32_t place) {
        places[place < 64 ? 0 : 1] |= std::uint64_t{1} << place % 64;
      });
    }
  }
  for (unsigned o = 1; o < kTeam; o *= 2) {
    for (std::uint64_t& half : places) half |= __shfl_xor_sync(kFullWarp, half, o);
  }
  // From here on the first of each team is alone.
  wanted = wanted && laneId() % kTeam == 0;
  std::uint32_t length = __popcll(places[0]) + __popcll(places[1]) + (in_first ? 1 : 0);
  is_short = is_short && length <= kShortList;
  if (wanted && !is_short) c.wide[atomicAdd(&c.counters->wide, 1U)] = make_uint2(t, body);
  if (!wanted || !is_short) length = 0;
  const std::uint32_t words = length > 1 ? length + 1 : 0;
  const std::uint32_t place = warpReserve(&c.counters->list_words, words);
  const bool listed = words > 0 && place + words <= c.list_capacity;
  if (listed) c.lists[place] = length;
  // Ranks by counting: lists are short, and need no array then.
  const std::uint32_t* cluster_at = view.neighbour_cluster + view.listBegin(first);
  const auto forEachIn = [&](const auto& visit) {
    if (in_first) visit(first);
    for (int half = 0; half < 2; ++half) {
      for (std::uint64_t rest = places[half]; rest != 0; rest &= rest - 1) {
        visit(cluster_at[64 * half + __ffsll(static_cast<long long>(rest)) - 1]);
      }
    }
  };
  std::uint32_t entry_count, next = warpPrefix(length, entry_count);
  if (length > 0) {
    forEachIn([&](std::uint32_t g) {
      std::uint32_t rank = 0;
      forEachIn([&](std::uint32_t other) { rank += other < g ? 1 : 0; });
      if (listed) c.lists[place + 1 + rank] = g;
      entries[next++] = {t, listed ? place : kNone, g << 1 | (rank == 0 ? 1U : 0U)};
    });
  }
  __syncwarp();
  for (std::uint32_t e = laneId(); e < entry_count; e += kWarp) {
    const Entry entry = entries[e];
    const std::uint32_t* v = c.corners + 3 * std::size_t{entry.triangle};
    putTogether(c, entry.cluster_and_home >> 1,
                {{{cornerAt(c, v[0]).v, cornerAt(c, v[1]).v, cornerAt(c, v[2]).v}},
                 entry.triangle,
                 entry.list,
                 body << 1 | (entry.cluster_and_home & 1)});
  }
  __syncwarp();  // before the next entries
}

__global__ void __launch_bounds__(kThreads) assignKernel(CycleView c) {
  awaitKernelAhead();
  letNextStart();
  __shared__ PartnerBoxes partners;
  const BodyBlock block = c.triangle_blocks[blockIdx.x];
  const DeviceBody& body = c.bodies[block.body];
  if (body.has_self == 0) partners.collect(c, block.body);

  const bool inside = threadIdx.x < block.count;
  const std::uint32_t t = block.first + (inside ? threadIdx.x : 0);
  const std::uint32_t* vertices = c.corners + 3 * std::size_t{t};
  const Corner corner[3] = {cornerAt(c, vertices[0]), cornerAt(c, vertices[1]),
                            cornerAt(c, vertices[2])};
  Member member{{{corner[0].v, corner[1].v, corner[2].v}}, t, kNone, block.body << 1 | 1};
  const bool finite = isFinite(corner[0].v) && isFinite(corner[1].v) && isFinite(corner[2].v);
  const Aabb box = inflated(boxOf(member.posed), body.margin_m);
  const bool near = finite && (body.has_self != 0 || partners.meets(box));
  const bool large = near && c.params->size.isLarge(box);
  const bool regular = inside && near && !large;
  warpCount(&c.counters->rejected, inside && !finite);
  countBlock(&c.counters->culled, inside && finite && !near);
  countBlock(&c.counters->clustered, regular);
  if (inside) takeSample(c, t, regular, corner);
  if (inside && large) {
    putMember(c, c.cluster_count, atomicAdd(&c.counters->large, 1U), member);
  }
  const std::uint32_t home = corner[0].winner.cluster;
  const bool interior = home == corner[1].winner.cluster && home == corner[2].winner.cluster &&
                        !corner[0].winner.tied && !corner[1].winner.tied && !corner[2].winner.tied;
  if (regular && interior) putTogether(c, home, member);

  // The others, closed up.
  __shared__ std::uint32_t border[kThreads], border_count;
  __shared__ Entry entries[kThreads / kWarp][kTeams * kShortList];
  if (threadIdx.x == 0) border_count = 0;
  __syncthreads();
  const std::uint32_t at = warpReserve(&border_count, regular && !interior);
  if (regular && !interior) border[at] = t;
  __syncthreads();
  const std::uint32_t warp = threadIdx.x / kWarp;
  for (std::uint32_t first = warp * kTeams; first < border_count; first += kThreads / kTeam) {
    const std::uint32_t mine = first + laneId() / kTeam;
    const bool there = mine < border_count;
    assignBorder(c, block.body, there ? border[mine] : block.first, there, entries[warp]);
  }
}

// A warp for each of the triangles that were left, over all prototypes in ascending order.
__global__ void __launch_bounds__(kThreads) assignWideKernel(CycleView c) {
  awaitKernelAhead();
  const PrototypesView view = prototypesView(c);
  const std::uint32_t count = c.counters->wide;
  const std::uint32_t warps = gridDim.x * (kThreads / kWarp);
  const std::uint32_t rounded = (c.cluster_count + kWarp - 1) / kWarp * kWarp;
  for (std::uint32_t i = (blockIdx.x * kThreads + threadIdx.x) / kWarp; i < count; i += warps) {
    const std::uint32_t t = c.wide[i].x, body = c.wide[i].y;
    const std::uint32_t* vertices = c.corners + 3 * std::size_t{t};
    const Corner corner[3] = {cornerAt(c, vertices[0]), cornerAt(c, vertices[1]),
                              cornerAt(c, vertices[2])};
    std::uint32_t first;
    const HalfSpaceRule rule = ruleOf(c, view, corner, c.bodies[body].slack, first);
    const auto admitted = [&](std::uint32_t g) {
      return g < c.cluster_count && rule.admits(view.prototypes[g]);
    };
    std::uint32_t length = 0;
    for (std::uint32_t g = laneId(); g < rounded; g += kWarp) {
      length += __popc(__ballot_sync(kFullWarp, admitted(g)));
    }
    std::uint32_t place = 0;
    if (laneId() == 0) place = atomicAdd(&c.counters->list_words, length + 1);
    place = __shfl_sync(kFullWarp, place, 0);
    const bool fits = place + length + 1 <= c.list_capacity;
    Member member{{{corner[0].v, corner[1].v, corner[2].v}}, t, fits ? place : kNone, body << 1};
    if (fits && laneId() == 0) c.lists[place] = length;
    std::uint32_t before = 0;
    for (std::uint32_t g = laneId(); g < rounded; g += kWarp) {
      const bool in = admitted(g);
      const unsigned mask = __ballot_sync(kFullWarp, in);
      const std::uint32_t k = before + __popc(mask & ((1U << laneId()) - 1));
      before += __popc(mask);
      if (!in) continue;
      if (fits) c.lists[place + 1 + k] = g;
      member.body_and_home = body << 1 | (k == 0 ? 1 : 0);
      putMember(c, g, atomicAdd(&countOf(c, g), 1U), member);
    }
  }
}

}  // namespace

void launchAssign(const CycleView& cycle, const DeviceTraits& device, cudaStream_t stream) {
  launchEarly(assignKernel, cycle.triangle_block_count, kThreads, 0, device, stream, cycle);
  launchEarly(assignWideKernel, blocksInOneWave(assignWideKernel, kThreads, 0, device), kThreads, 0,
              device, stream, cycle);
}

}  // namespace deformable_contact_monitor
