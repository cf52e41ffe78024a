// Stage assign: culls triangles, and puts every tile into each cluster in which one of its
// triangles may have a contact (core/rules/half_space.h). One warp works on each tile, and one lane
// on each of its triangles. Most tiles lie inside one cluster; the others go through BorderTile.
#include "core/rules/clustering.h"
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/corners.cuh"
#include "cuda/stages/cut_off.cuh"
#include "cuda/stages/stages.cuh"
#include "cuda/stages/swept_pairs.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
constexpr unsigned kWarps = kThreads / kWarp;

// Returns one of a body's partners for each lane, or the body itself beyond the last partner.
__device__ BodyIndex partnerOfLane(const SceneArrays& scene, BodyIndex b, const DeviceBody& body,
                                   std::uint32_t first) {
  const std::uint32_t p = first + laneId();
  return p < body.partner_count ? scene.partners[Place(body.partner_begin + p)] : b;
}

// Returns whether this lane's box meets the box of a partner that meets the body's own box. `all`:
// the box of all lanes' boxes. `partner`: partnerOfLane() of the first partners. Called by a whole
// warp.
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

// Returns the box of a tile entry as SlotBox describes it. `box`: the inflated box of all that
// the triangle passes. In swept motion the pads are added to both states before the boxes are
// joined.
template <int kStates>
__device__ Aabb passedBox(const CycleArrays& c, const Corners<kStates>& corners, float margin_m,
                          const Aabb& box) {
  if (kStates == 1) return box;
  return sweptBox(paddedBox(c, {corners.earlier(), corners.posed()}, margin_m),
                  c.scene.common_motion[Place(0)]);
}

// Returns the intervals of all that the triangle passes along the diagonals, see TileArrays.
template <int kStates>
__device__ DiagonalBox passedDiagonals(const CycleArrays& c, const Corners<kStates>& corners,
                                       float grown_m) {
  constexpr int kPoints = 3 * kStates;
  Vec3f v[kPoints];
  for (int k = 0; k < kPoints; ++k) {
    v[k] = k < 3 ? corners.v[k] : corners.v[k] - c.scene.common_motion[Place(0)];
  }
  return diagonalBox<kPoints>(v, grown_m, c.params().diagonals);
}

// Stores the triangle's centroid as a sample for fuzzy c-means, if its number is one of those that
// are sampled. Triangles that are not regular become empty samples.
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

// Adds a tile to the bin of a cluster. A bin that is full only counts; the host then repeats the
// cycle with larger bins.
__device__ void putEntry(const CycleArrays& c, std::uint32_t cluster, TileIndex tile) {
  const ClusterIndex g(cluster);
  const Bin bin = c.tiles.bins[g];
  const std::uint32_t place = atomicAdd(&c.tiles.count(g), 1U);
  if (place < bin.capacity) {
    c.tiles.bin_entries[EntryIndex(bin.begin + place)] = tile;
  } else {
    c.counters().bin_overflow = 1;
  }
}

// Finds the clusters of a tile that may be in several: those to which the half-space rule admits at
// least one of its live triangles. All calls are made by a whole warp. `kPoints`: the number of
// points of each triangle.
template <int kPoints>
class BorderTile {
 public:
  // The most clusters that findListed() finds: those on a prototype's list of neighbours, and its
  // own.
  static constexpr unsigned kMostFound = kMostNeighbours + 1;

  // `rule` and `live` are those of this lane's triangle. `near`: a prototype near the tile, the
  // same in all lanes. `found`: shared memory of the warp for kMostFound clusters.
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

  // Returns whether the list of `near` contains all clusters of the tile.
  __device__ bool isListed() const { return view_.list_reach[near_] > radius_; }

  // Writes the admitted clusters among `near` and its neighbours to `found`. Returns their number.
  // The list is sorted by distance, so it stops where neighbours are too far away.
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

  // Calls visit(cluster) for each admitted one of all clusters, in ascending order, in all lanes.
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
  // Returns the greatest of all lanes' floats, given as bits. None may be negative; NaN counts as
  // the greatest.
  __device__ static float mostOf(std::uint32_t bits) { return __uint_as_float(warpMost(bits)); }

  // Returns false only if the rule admits none of the triangles. All their points lie in the box,
  // so none of them is nearer to the prototype than the box is, because rounding is monotone. If
  // the box is farther away than any point reaches, the first competitor of each triangle keeps it
  // out.
  __device__ bool mayAdmit(const Vec3f& prototype) const {
    const Vec3f nearest{least(most(prototype.x, box_.min.x), box_.max.x),
                        least(most(prototype.y, box_.min.y), box_.max.y),
                        least(most(prototype.z, box_.min.z), box_.max.z)};
    return !(squaredDistance(nearest, prototype) > reach2_);
  }
  // Returns whether the rule admits a live triangle of some lane to the prototype's cluster.
  __device__ bool admits(const Vec3f& prototype) const {
    return __any_sync(kFullWarp, live_ && rule_.admits(prototype)) != 0;
  }
  // Calls visit(lane) for each lane in the bit mask `within` whose prototype the rule admits.
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
  // The box of the points of all live triangles [scaled].
  Aabb box_;
  float reach2_;  // the greatest squared reach of a point
};

// Reserves room for a list of `length` clusters; returns kNone if there is none. Called by a whole
// warp.
__device__ std::uint32_t reserveList(const CycleArrays& c, std::uint32_t length) {
  std::uint32_t place = 0;
  if (laneId() == 0) {
    place = reserve(&c.counters().list_words, length + 1);
    if (std::uint64_t{place} + length + 1 > c.tiles.lists.size()) place = kNone;
    if (place != kNone) c.tiles.lists[Place(place)] = length;
  }
  return __shfl_sync(kFullWarp, place, 0);
}

// Puts the tile into all its clusters. Returns the place of their list, which is in ascending
// order: findListed() returns them unordered, so each lane counts how many are less than its own.
// If the list of neighbours does not reach far enough, all clusters are tested. Called by a whole
// warp.
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
      if (list != kNone) c.tiles.lists[Place(list + 1 + rank)] = g;
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
      if (list != kNone) c.tiles.lists[Place(list + 1 + rank)] = g;
      putEntry(c, g, tile);
    }
    ++rank;
  });
  return list;
}

// Assigns a tile that has live triangles. Returns the place of the list of its clusters. If all
// live triangles lie inside the same cluster, that cluster is the only one. Called by a whole warp.
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

// Counts the triangles of this warp that were rejected, by part. Called by the whole warp.
__device__ void countRejected(const SceneArrays& scene, std::uint32_t part, bool rejected) {
  for (unsigned left = __ballot_sync(kFullWarp, rejected); left != 0;) {
    const int first = __ffs(static_cast<int>(left)) - 1;
    const std::uint32_t its = __shfl_sync(kFullWarp, part, first);
    const unsigned same = __ballot_sync(kFullWarp, rejected && part == its);
    if (laneId() == 0) atomicAdd(&scene.rejected[Place(its)], __popc(same));
    left &= ~same;
  }
}

// Returns the box of all lanes' boxes, those of a tile's live triangles. Grows counters().tiles_box
// by it if the tile is the first one of its body, or one of those that are sampled. Called by a
// whole warp.
__device__ Aabb boxOfTile(const CycleArrays& c, const DeviceBody& body, TileIndex tile,
                          const Aabb& box) {
  const Aabb all = warpBox(box);
  constexpr std::uint32_t kSampled = 1024;  // tiles, at most
  const bool is_sample = tile.value % (c.scene.tile_count / kSampled + 1) == 0;
  const unsigned k = laneId();
  if ((is_sample || tile.value == body.first_tile) && !all.empty() && k < kSides) {
    atomicMax(&c.counters().tiles_box[k], k < 3 ? ~orderedBits(all.min[static_cast<int>(k)])
                                                : orderedBits(all.max[static_cast<int>(k) - 3]));
  }
  return all;
}

// Writes the state of a tile but for its diagonals and its rounded box.
__device__ void putState(TileState* state, const Aabb& box, std::uint32_t live,
                         std::uint32_t list) {
  state->box = box;
  state->live = live;
  state->list = list;
}

// One warp for each tile. Reads scene.slot_numbers, scene.posed and scene.body_boxes; writes
// tiles.entries, tiles.bounds and tiles.states; adds to tiles.bin_entries, tiles.lists,
// tiles.oversized and counters().tiles_box. In swept motion (kStates == 2) it also writes the
// earlier states, to tiles.earlier.
template <int kStates>
__global__ void __launch_bounds__(kThreads) assignKernel(CycleArrays c) {
  __shared__ std::uint32_t found[kWarps][BorderTile<3 * kStates>::kMostFound];
  const std::uint32_t warp = threadIdx.x / kWarp;
  const TileIndex tile(blockIdx.x * kWarps + warp);
  const bool is_tile = tile.value < c.scene.tile_count;
  // Reads data that the previous kernel does not write, before it waits for that kernel.
  const BodyIndex b = is_tile ? c.scene.tile_body[tile] : BodyIndex(0);
  const DeviceBody& body = c.scene.bodies[b];
  const TileEntryIndex slot(tile.value * kWarp + laneId());
  const uint4 numbers = c.scene.slot_numbers[is_tile ? slot : TileEntryIndex(0)];
  const bool there = is_tile && numbers.w != kNone;
  const TriangleIndex t(there ? numbers.w : 0);
  // Triangles of parts that take no part are left out here.
  const bool has_parts = c.params().parts != 0;
  const std::uint32_t part = has_parts ? c.scene.part[t] : b.value;
  const bool takes_part = there && part != kNone;
  const ScenePartition partition = c.params().partition;
  const SizeBounds size = c.params().size;
  const BodyIndex partner = partnerOfLane(c.scene, b, body, 0);
  awaitPreviousKernel();
  letNextKernelStart();
  if (!is_tile) return;
  const Corners<kStates> corners(c.scene, numbers);
  const bool finite = takes_part && corners.isFinite();
  const Aabb box = finite ? inflated(corners.box(c), body.margin_m) : Aabb();
  bool near = finite;
  if (body.has_self == 0) near = meetsPartner(c.scene, b, box, warpBox(box), partner) && finite;
  const bool here = near && (partition.isWhole() || corners.reachesInto(partition, body.margin_m));
  const bool large = here && size.isOversized(box);
  const bool regular = here && !large;
  const unsigned live = __ballot_sync(kFullWarp, regular);
  const bool rejected = takes_part && !finite;
  warpCount(&c.counters().rejected, rejected);
  if (has_parts) countRejected(c.scene, part, rejected);
  warpCount(&c.counters().culled, (there && !takes_part) || (finite && !near));
  warpCount(&c.counters().clustered, regular);
  if (there) takeSample(c, t, regular, corners);
  if (__any_sync(kFullWarp, here) == 0) {
    if (laneId() == 0) c.tiles.states[tile] = TileState::none();
    return;
  }
  if (here) c.tiles.entries[slot] = {corners.posed(), t, b, part};
  if (kStates > 1 && here) c.tiles.earlier[slot].posed = corners.earlier();
  const DiagonalBox diagonals =
      here ? passedDiagonals(c, corners, body.margin_m) : DiagonalBox::none();
  AxisBox axes;
  if (here) axes = AxisBox(passedBox(c, corners, body.margin_m, box), c.params().axes);
  c.tiles.bounds[tile].put(laneId(), SlotBox::of(axes, slot), diagonals);
  // The tile's are written at once, because assignTile() needs the registers.
  const DiagonalBox of_tile = warpDiagonals(regular ? diagonals : DiagonalBox::none());
  if (laneId() == 0) c.tiles.states[tile].diagonals = of_tile;
  const AxisBox axes_of_tile = warpBox(regular ? axes : AxisBox());
  if (laneId() == 0) c.tiles.states[tile].axes = TurnedAxisBox(axes_of_tile);
  if (large) c.tiles.oversized[Place(atomicAdd(&c.counters().oversized, 1U))] = slot;
  const Aabb all = boxOfTile(c, body, tile, regular ? box : Aabb());
  const std::uint32_t list = live == 0 || c.usesBruteForce()
                                 ? kNone
                                 : assignTile(c, tile, live, corners, body.slack, found[warp]);
  if (laneId() == 0) putState(&c.tiles.states[tile], all, live, list);
}

}  // namespace

void launchAssign(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  const auto kernel = shape.swept ? assignKernel<2> : assignKernel<1>;
  launchDependent(kernel, (cycle.scene.tile_count + kWarps - 1) / kWarps, kThreads, 0, shape.device,
                  stream, cycle);
}

namespace {

constexpr unsigned kScanThreads = 1024;

// Returns how many places a cluster's bin should have, with some to spare.
__device__ std::uint32_t wantedPlaces(const CycleArrays& c, ClusterIndex bin) {
  const std::uint32_t count = c.tiles.count(bin);
  constexpr std::uint32_t kSpare = 32;
  // Decreases slowly after a peak, so that a scene that swings to and fro fits.
  const std::uint32_t before = c.tiles.bins[bin].wanted;
  return max(count + count / 4 + kSpare, before - before / 32);
}

// Computes the bins of the next cycle, in one block: reads tiles.counts, and writes tiles.next_bins
// by an exclusive sum of the capacities. Spare room is divided among all bins, because a bin that
// overflows costs a whole cycle.
__global__ void __launch_bounds__(kScanThreads) binsKernel(CycleArrays c) {
  const std::uint32_t bins = c.clusters.count, room = c.tiles.bin_entries.size();
  std::uint32_t mine = 0, wanted;
  for (ClusterIndex g(threadIdx.x); g.value < bins; g.value += kScanThreads) {
    mine += wantedPlaces(c, g);
  }
  blockPrefix<kScanThreads>(mine, wanted);
  const std::uint32_t more = wanted < room ? (room - wanted) / bins : 0;
  std::uint32_t begin = 0;
  for (std::uint32_t first = 0; first < bins; first += kScanThreads) {
    const ClusterIndex g(first + threadIdx.x);
    const std::uint32_t its = g.value < bins ? wantedPlaces(c, g) : 0;
    const std::uint32_t capacity = g.value < bins ? its + more : 0;
    std::uint32_t sum;
    const std::uint32_t before = blockPrefix<kScanThreads>(capacity, sum);
    // Cuts bins that do not fit; the host then enlarges the array.
    const std::uint32_t place = min(begin + before, room);
    if (g.value < bins) c.tiles.next_bins[g] = {place, min(capacity, room - place), its};
    begin += sum;
  }
  if (threadIdx.x == 0) c.counters().bins_wanted = wanted;
}

}  // namespace

void launchAssignBins(const CycleArrays& cycle, const CycleShape& /*shape*/, cudaStream_t stream) {
  if (cycle.usesBruteForce()) return;
  binsKernel<<<1, kScanThreads, 0, stream>>>(cycle);
}

}  // namespace deformable_contact_monitor
