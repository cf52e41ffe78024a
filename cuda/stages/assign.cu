// Stage assign: every tile into each cluster that one of its triangles may share a contact in. A
// warp for each tile, a lane for each of its triangles.
#include "core/rules/sampling.h"
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/corners.cuh"
#include "cuda/stages/cut_off.cuh"
#include "cuda/stages/reach.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/swept_pairs.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
constexpr unsigned kWarps = kThreads / kWarp;

__device__ float lowest(float x) { return fromOrderedBits(~warpMost(~orderedBits(x))); }
__device__ float highest(float x) { return fromOrderedBits(warpMost(orderedBits(x))); }

// By a whole warp: the box of all lanes' boxes, which may be empty.
__device__ Aabb warpBox(const Aabb& box) {
  Aabb all;
  all.min = {lowest(box.min.x), lowest(box.min.y), lowest(box.min.z)};
  all.max = {highest(box.max.x), highest(box.max.y), highest(box.max.z)};
  return all;
}

// By a whole warp: what `v` is in that lane.
__device__ Vec3f laneVector(const Vec3f& v, int lane) {
  return {__shfl_sync(kFullWarp, v.x, lane), __shfl_sync(kFullWarp, v.y, lane),
          __shfl_sync(kFullWarp, v.z, lane)};
}

// Of a body's partners, one for each lane; the body itself beyond the last.
__device__ BodyIndex partnerOfLane(const SceneArrays& scene, BodyIndex b, const DeviceBody& body,
                                   std::uint32_t first) {
  const std::uint32_t p = first + laneId();
  return p < body.partner_count ? scene.partners[Place(body.partner_begin + p)] : b;
}

// By a whole warp: whether this lane's box meets that of one of the body's partners that meets the
// body's own; `all`: the box of all lanes' boxes; `partner`: partnerOfLane() of the first ones.
__device__ bool meetsPartner(const SceneArrays& scene, BodyIndex b, const Aabb& box,
                             const Aabb& all, BodyIndex partner) {
  const DeviceBody& body = scene.bodies[b];
  const Aabb own = bodyBox(scene, b);
  bool meets = false;
  for (std::uint32_t first = 0; first < body.partner_count; first += kWarp) {
    if (first > 0) partner = partnerOfLane(scene, b, body, first);
    Aabb partners;
    if (partner.value != b.value) partners = bodyBox(scene, partner);
    unsigned near =
        __ballot_sync(kFullWarp, intersects(own, partners) && intersects(all, partners));
    for (; near != 0; near &= near - 1) {
      const int lane = __ffs(static_cast<int>(near)) - 1;
      const Aabb other{laneVector(partners.min, lane), laneVector(partners.max, lane)};
      meets = meets || intersects(box, other);
    }
  }
  return meets;
}

// As MemberBox has it; `box`: of all that it passes, inflated.
template <int kStates>
__device__ Aabb passedBox(const CycleArrays& c, const Corners<kStates>& corners, float margin_m,
                          const Aabb& box) {
  if (kStates == 1) return box;
  return sweptBox(paddedBox(c, {corners.earlier(), corners.posed()}, margin_m),
                  c.scene.common_motion[Place(0)]);
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

__device__ void putEntry(const CycleArrays& c, std::uint32_t cluster, TileIndex tile) {
  const ClusterIndex g(cluster);
  const Bin bin = c.members.bins[g];
  const std::uint32_t place = atomicAdd(&c.members.count(g), 1U);
  if (place < bin.capacity) {
    c.members.entries[EntryIndex(bin.begin + place)] = tile;
  } else {
    c.counters().bin_overflow = 1;
  }
}

// The clusters of a tile that may be in several: those that the rule admits one of its live
// triangles to, by a whole warp. `kPoints`: of each triangle.
template <int kPoints>
class BorderTile {
 public:
  // Of the clusters near a prototype and itself, which many tiles have no more of.
  static constexpr unsigned kMostFound = kMostNeighbours + 1;

  // The rule of this lane's triangle, which is live or not; `found`: of the warp, in shared memory.
  __device__ BorderTile(const PrototypesView& view, const HalfSpaceRuleOf<kPoints>& rule, bool live,
                        std::uint32_t near, std::uint32_t* found)
      : view_(view), rule_(rule), live_(live), near_(near), found_(found) {
    radius_ = mostOf(__float_as_uint(live ? rule.searchRadius(view.prototypes[near]) : 0.0F));
    std::uint32_t reach2 = 0;
    Aabb box;
    for (int k = 0; live && k < kPoints; ++k) {
      box.include(rule.v[k]);
      reach2 = max(reach2, __float_as_uint(rule.reach2[0][k]));
    }
    box_ = warpBox(box);
    reach2_ = mostOf(reach2);
  }

  // Whether the list of `near` has all clusters of the tile.
  __device__ bool isListed() const { return view_.list_reach[near_] > radius_; }

  // The clusters on that list, and `near`, into `found`; returns how many they are.
  __device__ std::uint32_t findListed() const {
    std::uint32_t count = 0;
    const auto add = [&](std::uint32_t g) {
      if (laneId() == 0) found_[count] = g;
      ++count;
    };
    if (admits(view_.prototypes[near_])) add(near_);
    const std::size_t begin = view_.listBegin(near_);
    for (std::uint32_t first = 0; first < kMostNeighbours; first += kWarp) {
      const Neighbour n = view_.neighbours[begin + first + laneId()];
      const std::uint32_t cluster = view_.neighbour_cluster[begin + first + laneId()];
      const bool within = n.distance <= radius_;
      forEachAdmitted(n.prototype, __ballot_sync(kFullWarp, within && mayAdmit(n.prototype)),
                      [&](int lane) { add(__shfl_sync(kFullWarp, cluster, lane)); });
      if (__all_sync(kFullWarp, within) == 0) break;
    }
    __syncwarp();
    return count;
  }

  // visit(cluster) for each of all clusters, ascending, in all lanes.
  template <class Visit>
  __device__ void forEachOfAll(const Visit& visit) const {
    for (std::uint32_t first = 0; first < view_.count; first += kWarp) {
      const std::uint32_t g = first + laneId();
      const Vec3f prototype = view_.prototypes[min(g, view_.count - 1)];
      const unsigned within = __ballot_sync(kFullWarp, g < view_.count && mayAdmit(prototype));
      forEachAdmitted(prototype, within,
                      [&](int lane) { visit(first + static_cast<std::uint32_t>(lane)); });
    }
  }

 private:
  // Of all lanes' numbers, as bits, the most; none is negative, and NaN is more than any.
  __device__ static float mostOf(std::uint32_t bits) { return __uint_as_float(warpMost(bits)); }

  // False only where the rule admits none of the triangles: their points lie in the box, so none is
  // nearer to the prototype, as roundings are monotone; and farther than any of them reaches their
  // first competitors keep them out.
  __device__ bool mayAdmit(const Vec3f& prototype) const {
    const Vec3f nearest{least(most(prototype.x, box_.min.x), box_.max.x),
                        least(most(prototype.y, box_.min.y), box_.max.y),
                        least(most(prototype.z, box_.min.z), box_.max.z)};
    return !(squaredDistance(nearest, prototype) > reach2_);
  }
  __device__ bool admits(const Vec3f& prototype) const {
    return __any_sync(kFullWarp, live_ && rule_.admits(prototype)) != 0;
  }
  // visit(lane) for each of the lanes `within` whose prototype the rule admits.
  template <class Visit>
  __device__ void forEachAdmitted(const Vec3f& prototype, unsigned within,
                                  const Visit& visit) const {
    for (; within != 0; within &= within - 1) {
      const int lane = __ffs(static_cast<int>(within)) - 1;
      if (admits(laneVector(prototype, lane))) visit(lane);
    }
  }

  const PrototypesView& view_;
  const HalfSpaceRuleOf<kPoints>& rule_;
  const bool live_;
  const std::uint32_t near_;
  std::uint32_t* const found_;
  float radius_;
  Aabb box_;      // of the live triangles, as the rule has them [scaled]
  float reach2_;  // the most of their points
};

// By a whole warp: room for a list of `length` clusters; kNone if there is none.
__device__ std::uint32_t reserveList(const CycleArrays& c, std::uint32_t length) {
  std::uint32_t place = 0;
  if (laneId() == 0) {
    place = atomicAdd(&c.counters().list_words, length + 1);
    if (place + length + 1 > c.members.lists.size()) place = kNone;
    if (place != kNone) c.members.lists[Place(place)] = length;
  }
  return __shfl_sync(kFullWarp, place, 0);
}

// By a whole warp: the tile into all its clusters; returns where their list is.
template <int kPoints>
__device__ std::uint32_t assignBorder(const CycleArrays& c, TileIndex tile,
                                      const BorderTile<kPoints>& border, std::uint32_t* found) {
  if (border.isListed()) {
    const std::uint32_t length = border.findListed();
    const std::uint32_t list = length > 1 ? reserveList(c, length) : kNone;
    for (std::uint32_t i = laneId(); i < length; i += kWarp) {
      const std::uint32_t g = found[i];
      std::uint32_t rank = 0;
      for (std::uint32_t k = 0; k < length; ++k) rank += found[k] < g ? 1 : 0;
      if (list != kNone) c.members.lists[Place(list + 1 + rank)] = g;
      putEntry(c, g, tile);
    }
    return list;
  }
  if (warpIsCutOff(c, tile.value % kWarpsPerAsker == 0)) return kNone;
  std::uint32_t length = 0;
  border.forEachOfAll([&](std::uint32_t) { ++length; });
  const std::uint32_t list = reserveList(c, length);
  std::uint32_t rank = 0;
  border.forEachOfAll([&](std::uint32_t g) {
    if (laneId() == 0) {
      if (list != kNone) c.members.lists[Place(list + 1 + rank)] = g;
      putEntry(c, g, tile);
    }
    ++rank;
  });
  return list;
}

// By a whole warp: a tile of which some triangle is live; returns where the list of its clusters
// is.
template <int kStates>
__device__ std::uint32_t assignTile(const CycleArrays& c, TileIndex tile, unsigned live,
                                    const Corners<kStates>& corners, float slack,
                                    std::uint32_t* found) {
  const bool mine = (live >> laneId() & 1) != 0;
  const int some = __ffs(static_cast<int>(live)) - 1;
  const std::uint32_t near = __shfl_sync(kFullWarp, corners.nearest[0].cluster, some);
  const bool inside =
      isInterior<3 * kStates>(corners.nearest) && corners.nearest[0].cluster == near;
  if (__all_sync(kFullWarp, inside || !mine) != 0) {
    if (laneId() == 0) putEntry(c, near, tile);
    return kNone;
  }
  const PrototypesView view = c.clusters.view();
  const ScaledCorners<kStates> scaled(c, corners);
  std::uint32_t first;
  const auto rule =
      ruleFor<3 * kStates>(view, scaled.v, corners.nearest, c.params().overlap, slack, first);
  return assignBorder(c, tile, BorderTile<3 * kStates>(view, rule, mine, near, found), found);
}

// A warp for each tile: reads scene.corners, scene.posed, scene.body_boxes; writes members.members,
// members.boxes and members.tiles; adds to members.entries, members.lists and members.large. In
// swept motion (kStates == 2) the earlier states too, to members.earlier.
template <int kStates>
__global__ void __launch_bounds__(kThreads) assignKernel(CycleArrays c) {
  __shared__ std::uint32_t found[kWarps][BorderTile<3 * kStates>::kMostFound];
  const std::uint32_t warp = threadIdx.x / kWarp;
  const TileIndex tile(blockIdx.x * kWarps + warp);
  const bool is_tile = tile.value < c.scene.tile_count;
  // What the kernel ahead does not write.
  const BodyIndex b = is_tile ? c.scene.tile_body[tile] : BodyIndex(0);
  const DeviceBody& body = c.scene.bodies[b];
  const MemberIndex slot(tile.value * kWarp + laneId());
  const TriangleIndex named = is_tile ? c.scene.slot_triangle[slot] : TriangleIndex(kNone);
  const bool there = named.value != kNone;
  const TriangleIndex t(there ? named.value : 0);
  const VertexIndex* const corner = c.scene.corners.row(t);
  const VertexIndex vertices[3] = {corner[0], corner[1], corner[2]};
  const SceneShare share = c.params().share;
  const SizeRule size = c.params().size;
  const BodyIndex partner = partnerOfLane(c.scene, b, body, 0);
  awaitKernelAhead();
  letNextStart();
  if (!is_tile) return;
  const Corners<kStates> corners(c.scene, vertices);
  const bool finite = there && corners.isFinite();
  const Aabb box = finite ? inflated(corners.box(c), body.margin_m) : Aabb();
  bool near = finite;
  if (body.has_self == 0) near = meetsPartner(c.scene, b, box, warpBox(box), partner) && finite;
  const bool here = near && (share.isWhole() || corners.reachesInto(share, body.margin_m));
  const bool large = here && size.isLarge(box);
  const bool regular = here && !large;
  const unsigned live = __ballot_sync(kFullWarp, regular);
  warpCount(&c.counters().rejected, there && !finite);
  warpCount(&c.counters().culled, finite && !near);
  warpCount(&c.counters().clustered, regular);
  if (there) takeSample(c, t, regular, corners);
  if (__any_sync(kFullWarp, here) == 0) {
    if (laneId() == 0) c.members.tiles[tile] = {Aabb(), 0, kNone};
    return;
  }
  if (here) {
    c.members.members[slot] = {corners.posed(), t, b, body.group};
    if (kStates > 1) c.members.earlier[slot].posed = corners.earlier();
  }
  c.members.boxes[slot] = MemberBox::of(here ? passedBox(c, corners, body.margin_m, box) : Aabb());
  if (large) c.members.large[Place(atomicAdd(&c.counters().large, 1U))] = slot;
  const Aabb all = warpBox(regular ? box : Aabb());
  const std::uint32_t list = live == 0 || c.together()
                                 ? kNone
                                 : assignTile(c, tile, live, corners, body.slack, found[warp]);
  if (laneId() == 0) c.members.tiles[tile] = {all, live, list};
}

}  // namespace

void launchAssign(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  const auto kernel = shape.swept ? assignKernel<2> : assignKernel<1>;
  launchEarly(kernel, (cycle.scene.tile_count + kWarps - 1) / kWarps, kThreads, 0, shape.device,
              stream, cycle);
}

}  // namespace deformable_contact_monitor
