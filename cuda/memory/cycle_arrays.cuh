// Collects the arrays of all stages: everything that the kernels of a cycle read and write. Kernels
// get a copy of this struct, which is valid until the memory grows.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>
#include <cstring>

#include "core/detector.h"
#include "core/predicates/aabb.h"
#include "core/predicates/swept_triangle.h"
#include "core/predicates/triangle.h"
#include "core/rigid_transform.h"
#include "core/rules/half_space.h"
#include "core/rules/intervals.h"
#include "core/rules/part_pairs.h"
#include "core/rules/principal_axes.h"
#include "cuda/device/boxes.cuh"
#include "cuda/memory/device_memory.cuh"
#include "cuda/memory/nearest_arrays.cuh"
#include "cuda/memory/tile_entries.cuh"

namespace deformable_contact_monitor {

// A body that takes part. Uploaded in each cycle in which one has changed.
struct DeviceBody {
  RigidTransform pose;
  // The distance by which boxes are inflated: margin_m in metres, slack in the scale of the
  // clusters. It is the margin, or in swept motion a little more than the pad.
  float margin_m, slack;
  std::uint32_t identity_pose;
  std::uint32_t has_self;  // 1 if contacts with itself are enabled
  std::uint32_t first_vertex, vertex_count;
  std::uint32_t first_triangle, triangle_count, first_tile;
  std::uint32_t group;
  // The other bodies of its enabled pairs: a range of SceneArrays::partners.
  std::uint32_t partner_begin, partner_count;
};

// The state of a body at the beginning of the time interval. Uploaded in each cycle of swept
// motion.
struct EarlierBody {
  RigidTransform pose;
  std::uint32_t identity_pose;
  std::uint32_t is_still;      // 1 if it has no earlier state
  std::uint32_t has_vertices;  // 1 if it has earlier vertices: in SceneArrays::earlier_received
  float pad_m;
};

// A range of a body's vertices or triangles, for one thread block.
struct BodyBlock {
  BodyIndex body;
  std::uint32_t first, count;
};

// Maps triangle numbers on the device to those in results.
struct alignas(8) ListedBody {
  std::uint32_t first_triangle;  // the number of the body's first triangle
  std::uint32_t id;              // a BodyId
};

// Returns the body of a triangle by a binary search in `count` bodies, which are in the order of
// their triangles.
__host__ __device__ inline ListedBody bodyOf(const ListedBody* bodies, std::uint32_t count,
                                             TriangleIndex triangle) {
  std::uint32_t first = 0;
  while (count > 1) {
    const std::uint32_t half = count / 2;
    if (bodies[first + half].first_triangle <= triangle.value) first += half;
    count -= half;
  }
  return bodies[first];
}

// A vertex whose nearest prototype could not be found in the lists of neighbours.
struct alignas(8) FarVertex {
  VertexIndex vertex;
  BodyIndex body;
};

// A flag in SceneArrays::vertex_id: other vertices are equal to this one.
constexpr std::uint32_t kRepeated = std::uint32_t{1} << 31;
// Values of SceneArrays::vertex_id for a vertex that lies below or above the partition by more than
// its body's margin. A triangle whose three vertices are on one side does not reach into the
// partition. For other triangles, such vertices are identified when the tile entries get their ids.
constexpr std::uint32_t kBelowPartition = ~std::uint32_t{0}, kAbovePartition = kBelowPartition - 1;

struct SceneArrays : ArrayGroup {
  using ArrayGroup::ArrayGroup;

  // The parts of the arrays that are in use.
  std::uint32_t body_count = 0, pair_row = 0;
  std::uint32_t vertex_block_count = 0, triangle_block_count = 0, triangle_count = 0;
  std::uint32_t tile_count = 0;
  std::uint32_t identity_mask = 0;

  DeviceArray<DeviceBody, BodyIndex> bodies{*this, &CycleSizes::bodies};
  DeviceArray<ListedBody, BodyIndex> listed_bodies{*this, &CycleSizes::bodies};
  DeviceArray<BodyIndex, Place> partners{*this, &CycleSizes::partners};
  // For each group, the groups that its bodies may touch, as bits.
  DeviceArray<std::uint32_t, Place> group_mask{*this, kMostGroups};
  // Which pairs of parts are enabled, see PartPairs. Parts have the numbers of PartTable; if no
  // body has parts, these are the numbers of the bodies.
  DeviceArray<std::uint32_t, Place> pair_enabled{*this, &CycleSizes::pair_words};
  // The part of each triangle, kNone if that takes no part; and for each part the number of its
  // rejected triangles, zero at the start of a cycle. Only if CycleParams::parts is set.
  DeviceArray<std::uint32_t, TriangleIndex> part{*this, &CycleSizes::part_triangles};
  DeviceArray<std::uint32_t, Place> rejected{*this, &CycleSizes::parts};
  DeviceArray<BodyBlock, Place> vertex_blocks{*this, &CycleSizes::vertex_blocks};
  DeviceArray<BodyBlock, Place> triangle_blocks{*this, &CycleSizes::triangle_blocks};
  // The bodies' triangles, grouped into tiles (stages/tiles.cuh).
  DeviceArray<BodyIndex, TileIndex> tile_body{*this, &CycleSizes::tiles};
  // The numbers of each slot's vertices in x, y and z, and that of its triangle in w; without a
  // triangle 0 and kNone.
  DeviceArray<uint4, TileEntryIndex> slot_numbers{*this, &CycleSizes::slots};
  // The slots of the same tile whose triangles share a vertex with this one by its number, as bits.
  DeviceArray<std::uint32_t, TileEntryIndex> slot_neighbours{*this, &CycleSizes::slots};
  // The inputs of tiling: the range of most of a body's vertices, in its frame [m], and the
  // triangles' keys along the space-filling curve, before and after they are sorted.
  DeviceArray<Aabb, BodyIndex> body_ranges{*this, &CycleSizes::bodies};
  DeviceArray<std::uint64_t, Place> curve_keys{*this, &CycleSizes::triangles};
  DeviceArray<std::uint64_t, Place> sorted_keys{*this, &CycleSizes::triangles};
  // x, y, z in the body's frame [m], as received from the user.
  DeviceArray<float, VertexIndex, 3> received{*this, &CycleSizes::vertices};
  DeviceArray<VertexIndex, TriangleIndex, 3> corners{*this, &CycleSizes::triangles};
  // x, y, z in the scene frame [m]; w holds the bits of (nearest prototype * 2 + tied).
  DeviceArray<float4, VertexIndex> posed{*this, &CycleSizes::vertices};
  DeviceArray<FarVertex, Place> far_vertices{*this, &CycleSizes::vertices};
  // The state at the beginning of the time interval, in swept motion, and the motion that all
  // bodies have in common [m]. Any vector gives correct results: it is subtracted from the present
  // state for boxes and clusters, never for verdicts.
  DeviceArray<EarlierBody, BodyIndex> earlier_bodies{*this, &CycleSizes::swept_bodies};
  DeviceArray<float, VertexIndex, 3> earlier_received{*this, &CycleSizes::swept_vertices};
  DeviceArray<float4, VertexIndex> earlier_posed{*this, &CycleSizes::swept_vertices};
  DeviceArray<Vec3f, Place> common_motion{*this, 1U};
  // Bounding boxes of the bodies' finite vertices, see cuda/device/boxes.cuh. They are zero at the
  // start of a cycle, and outside of a cycle they bound the vertices as received.
  DeviceArray<std::uint32_t, BodyIndex, kSides> body_boxes{*this, &CycleSizes::bodies};
  // The identity of a vertex: equal for two vertices of a body if and only if they are equal as
  // received. It is the number of one of these vertices; at that vertex kRepeated is set if there
  // are others and CycleParams::fans is set. Then the array is zero at the start of a cycle.
  DeviceArray<VertexIndex, VertexIndex> vertex_id{*this, &CycleSizes::vertices};
  // 1 for each vertex whose fan is certified, as far as the vertex's own ring shows. Only for
  // bodies that may touch themselves, and if CycleParams::fans is set.
  DeviceArray<std::uint32_t, VertexIndex> fan_certified{*this, &CycleSizes::vertices};
  // The vertex rings of all bodies that may touch themselves, if certified fans are needed.
  // `fan_count` counts the triangles around each vertex while the rings are built.
  DeviceArray<Place, VertexIndex> fan_begin{*this, &CycleSizes::fan_vertices};
  DeviceArray<VertexIndex, Place> fan_ring{*this, &CycleSizes::fan_places};
  DeviceArray<std::uint32_t, VertexIndex> fan_count{*this, &CycleSizes::fan_vertices};
  // An open-addressing hash table of vertices' numbers + 1; its size is a power of two.
  DeviceArray<std::uint32_t, Place> identity_table{*this, &CycleSizes::identity_slots};

  // Returns whether the pair of these parts is enabled.
  __device__ bool pairEnabled(std::uint32_t part_a, std::uint32_t part_b) const {
    return PartPairs{pair_enabled.data(), pair_row}.enabled(part_a, part_b);
  }
};

// A cluster's part of the array of entries and of the sorted arrays. `wanted` is the number of
// places that the cluster needs.
struct alignas(16) Bin {
  std::uint32_t begin, capacity, wanted;
};

struct TileArrays : ArrayGroup {
  using ArrayGroup::ArrayGroup;

  // The bins of the clusters, for this cycle and the next one.
  DeviceArray<Bin, ClusterIndex> bins{*this, &CycleSizes::clusters};
  DeviceArray<Bin, ClusterIndex> next_bins{*this, &CycleSizes::clusters};
  // The number of entries of each bin, including those that do not fit. Only the first of
  // kCountPlaces words is used, so that the counters of different clusters are in different memory
  // sectors. Zero at the start of a cycle.
  static constexpr unsigned kCountPlaces = 8;
  DeviceArray<std::uint32_t, ClusterIndex, kCountPlaces> counts{*this, &CycleSizes::clusters};
  DeviceArray<TileIndex, EntryIndex> bin_entries{*this, &CycleSizes::entries};
  DeviceArray<TileEntry, TileEntryIndex> entries{*this, &CycleSizes::slots};
  DeviceArray<TileBounds, TileIndex> bounds{*this, &CycleSizes::tiles};
  DeviceArray<EarlierTileEntry, TileEntryIndex> earlier{*this, &CycleSizes::swept_slots};
  // The ids of each entry's vertices, if equal vertices are searched.
  DeviceArray<uint4, TileEntryIndex> ids{*this, &CycleSizes::slots};
  DeviceArray<TileState, TileIndex> states{*this, &CycleSizes::tiles};
  DeviceArray<TileEntryIndex, Place> oversized{*this, &CycleSizes::slots};
  DeviceArray<std::uint32_t, Place> lists{*this, &CycleSizes::list_words};

  // Returns a whole entry, read by three wide loads.
  __device__ TileEntry at(TileEntryIndex slot) const {
    static_assert(sizeof(TileEntry) == 3 * sizeof(uint4));
    const auto* from = reinterpret_cast<const uint4*>(&entries[slot]);
    const uint4 words[3] = {from[0], from[1], from[2]};
    TileEntry entry;
    memcpy(&entry, words, sizeof entry);
    return entry;
  }
  __device__ const DiagonalBox& diagonalsOf(TileEntryIndex slot) const {
    return bounds[TileIndex(slot.value / kWarp)].diagonals[slot.value % kWarp];
  }
  __device__ std::uint32_t& count(ClusterIndex g) const { return *counts.row(g); }
  // Returns how many entries of a cluster are in its bin.
  __device__ std::uint32_t present(ClusterIndex g) const { return min(count(g), bins[g].capacity); }
  // Returns the tile's ascending list of clusters; null if it is in one cluster only.
  __device__ const std::uint32_t* clustersOf(const TileState& tile) const {
    return tile.list == kNone ? nullptr : lists.data() + tile.list + 1;
  }
};

// The frame onto which a cluster is projected. It is computed from the cluster in the last cycle;
// any frame gives correct results.
struct ClusterFrame {
  Vec3f centre;
  PrincipalAxes axes;
  Quantiser along[3];  // for each principal axis
};

// A piece of work for one warp: up to 32 sorted entries (rows), each against up to
// CycleParams::unit_columns of its partners (columns).
struct WorkUnit {
  ClusterIndex cluster;
  SortedIndex first_row;
  // The number of rows | the group of the rows << 8 | the group of the columns << 16.
  std::uint32_t rows_and_groups;
  std::uint32_t first_column;  // counted from the first partner of each row

  __device__ std::uint32_t rows() const { return rows_and_groups & 0xff; }
  __device__ std::uint32_t rowGroup() const { return rows_and_groups >> 8 & 0xff; }
  __device__ std::uint32_t columnGroup() const { return rows_and_groups >> 16; }
};

struct alignas(8) TilePair {
  TileIndex a, b;
};

struct SweepArrays : ArrayGroup {
  using ArrayGroup::ArrayGroup;

  DeviceArray<ClusterFrame, ClusterIndex> frames{*this, &CycleSizes::clusters};
  // The moments of the tiles' boxes about the frames' centres.
  DeviceArray<Moments, ClusterIndex> moments{*this, &CycleSizes::clusters};
  // The key, box and tile of each entry, in the order of the bins.
  DeviceArray<uint4, EntryIndex> projected{*this, &CycleSizes::entries};
  // The sorted entries, by group and bucket: their intervals along the second and third axis. A
  // sweep reads up to 64 places beyond the end.
  DeviceArray<PackedBox, SortedIndex> boxes{*this, &CycleSizes::entries, 64};
  // The bucket where the entry begins | the bucket where it ends << 16, within the group.
  DeviceArray<std::uint32_t, SortedIndex> keys{*this, &CycleSizes::entries};
  DeviceArray<TileIndex, SortedIndex> tiles{*this, &CycleSizes::entries};
  // The first place of each bucket; one more element has the end of the last bucket.
  DeviceArray<std::uint32_t, ClusterIndex, kBuckets + 1> bucket_begin{*this, &CycleSizes::clusters};
  DeviceArray<WorkUnit, Place> units{*this, &CycleSizes::units};
  // The results of the sweep: pairs of different tiles whose boxes meet, each once. Pairs in which
  // many triangles may meet are on the second list.
  DeviceArray<TilePair, Place> tile_pairs{*this, &CycleSizes::tile_pairs};
  DeviceArray<TilePair, Place> dense_pairs{*this, &CycleSizes::dense_pairs};
};

// The range of a row's partners among the sorted entries: entries of group `columns` that begin
// within the row's interval. If two entries begin in the same bucket, the entry of the later group,
// or the later entry of one group, is the partner. So each pair is found once.
struct ColumnRange {
  std::uint32_t begin, end;
};
// Returns that range. `bucket_begin`: the buckets of the cluster; `buckets`: the number of buckets
// of a group; `key`: the key of the row.
__device__ inline ColumnRange columnsOf(const std::uint32_t* bucket_begin, std::uint32_t buckets,
                                        std::uint32_t rows, std::uint32_t columns, SortedIndex row,
                                        std::uint32_t key) {
  const std::uint32_t* begin = bucket_begin + columns * buckets;
  const std::uint32_t first = key & 0xffffU, last = key >> 16;
  return {rows == columns ? row.value + 1 : begin[columns < rows ? first + 1 : first],
          begin[last + 1]};
}

// A sample for fuzzy c-means: a triangle's centroid [scaled] and a prototype near it. `near` is
// kNone if the triangle is in no cluster.
struct Sample {
  Vec3f centroid;
  ClusterIndex near;
};

struct ClusterArrays : ArrayGroup {
  using ArrayGroup::ArrayGroup;

  std::uint32_t count = 0;         // of clusters
  std::uint32_t sample_count = 0;  // of samples

  DeviceArray<Vec3f, ClusterIndex> prototypes{*this, &CycleSizes::clusters};  // [scaled]
  // The same [scaled], except that prototypes that coincide with an earlier one are moved far away.
  DeviceArray<Vec3f, ClusterIndex> live_prototypes{*this, &CycleSizes::clusters};
  // The lists of neighbours of each prototype, as PrototypesView describes them.
  DeviceArray<float, ClusterIndex> list_reach{*this, &CycleSizes::clusters};
  DeviceArray<Neighbour, ClusterIndex, kMostNeighbours> neighbours{*this, &CycleSizes::clusters};
  DeviceArray<std::uint32_t, ClusterIndex, kMostNeighbours> neighbour_cluster{
      *this, &CycleSizes::clusters};
  // For each prototype p, with memberships u and fuzzifier m: xyz = sum u^m (x - p), w = sum u^m.
  DeviceArray<float4, ClusterIndex> membership_sums{*this, &CycleSizes::clusters};
  DeviceArray<Sample, Place> samples{*this, &CycleSizes::samples};

  __device__ PrototypesView view() const {
    return {live_prototypes.data(), list_reach.data(), neighbours.data(), neighbour_cluster.data(),
            count};
  }
};

// A pair of tile entries for the narrow phase, with what the earlier filters found out.
struct DeviceCandidate {
  TileEntryIndex a, b;
  // Two bits (side + 1) for each of the three vertices of either triangle, then three bits for the
  // shared vertices of either triangle. In swept motion see stages/swept_pairs.cuh.
  std::uint32_t facts;
};

// The state of a candidate in swept motion, while its features are examined. Times are stored as
// bits of non-negative floats, which have the same order as the floats.
struct alignas(16) SweptState {
  std::uint32_t low, high;  // of the features that meet; 2 if none does yet
  std::uint32_t open_low;   // no open feature meets before this time
  std::uint32_t bits;       // which features are open, and flags: see stages/swept_pairs.cuh
};

// A pair of swept motion that the device leaves to the host.
struct OpenPair {
  MovingTriangle a, b;
  TriangleIndex triangle_a, triangle_b;
  std::uint32_t shared;  // bits of the shared vertices of a, and of b << 3
  std::uint32_t open;    // as in SweptVerdict::open
  float low, high;       // as in SweptVerdict
  std::uint32_t meets_at_end;
  float pad_m;  // of the two bodies together [m]
};

// The time interval of a contact in swept motion, stored where it was found. `high` is negative if
// only the pad makes the pair a contact.
struct alignas(8) ContactTimes {
  float low, high;
};

// Lengths of the lists of the narrow phase in swept motion, see stages/narrow_phase_moving.cuh.
// They are zero at the beginning of a cycle and of each pass.
struct alignas(128) SweptCounters {
  alignas(128) std::uint32_t touching;   // candidates for the static predicates
  alignas(128) std::uint32_t moving;     // pairs for the fixed directions
  alignas(128) std::uint32_t robust;     // pairs for the robust static predicates
  alignas(128) std::uint32_t featured;   // pairs for the test of their features
  alignas(128) std::uint32_t left;       // pairs with features that float32 leaves open
  alignas(128) std::uint32_t beyond;     // pairs that share vertices, left open by float32
  alignas(128) std::uint32_t dismissed;  // pairs that only a pad may make contacts
};

struct ContactArrays : ArrayGroup {
  using ArrayGroup::ArrayGroup;

  DeviceArray<DeviceCandidate, Place> candidates{*this, &CycleSizes::candidates};
  // Places of candidates that need the full verdict. Those that share vertices are stored from the
  // end of the array backwards.
  DeviceArray<Place, Place> open{*this, &CycleSizes::candidates};
  // Keys: the lower triangle's number << CycleParams::index_bits | the higher triangle's number.
  DeviceArray<std::uint64_t, Place> contacts{*this, &CycleSizes::contacts};
  DeviceArray<float, Place> separations_m{*this, &CycleSizes::contacts};

  // The number of contacts whose lower triangle is this one; it is zero except in stage output.
  // `row_begin` is the place of the first of them in `rows`.
  DeviceArray<std::uint32_t, TriangleIndex> row_count{*this, &CycleSizes::triangles, 1};
  DeviceArray<Place, TriangleIndex> row_begin{*this, &CycleSizes::triangles, 1};
  // The contacts grouped by their lower triangle, and their places in `contacts`. Stage output then
  // puts them in their order, in `contacts` or here (OrderedContacts in stages/rows.cuh).
  DeviceArray<std::uint64_t, Place> rows{*this, &CycleSizes::contacts};
  DeviceArray<Place, Place> row_from{*this, &CycleSizes::contacts};
  DeviceArray<std::uint32_t, Place> row_too_long{*this, 1U};  // 1 if a row was too long

  // Lists of candidates' places in swept motion; see stages/narrow_phase_moving.cuh.
  DeviceArray<SweptState, Place> states{*this, &CycleSizes::swept_candidates};
  DeviceArray<Place, Place> first_list{*this, &CycleSizes::swept_candidates};
  DeviceArray<Place, Place> second_list{*this, &CycleSizes::swept_candidates};
  DeviceArray<Place, Place> third_list{*this, &CycleSizes::swept_candidates};
  DeviceArray<Place, Place> dismissed{*this, &CycleSizes::swept_candidates};
  DeviceArray<ContactTimes, Place> times{*this, &CycleSizes::swept_contacts};
  DeviceArray<OpenPair, Place> open_pairs{*this, &CycleSizes::open_pairs};
  DeviceArray<SweptCounters, Place> swept_counters{*this, 1U};
};

struct CycleArrays : ArrayGroup {
  explicit CycleArrays(DeviceMemory& memory)
      : ArrayGroup(memory),
        scene(memory),
        clusters(memory),
        tiles(memory),
        sweep(memory),
        contacts(memory),
        nearest(memory) {}

  SceneArrays scene;
  ClusterArrays clusters;
  TileArrays tiles;
  SweepArrays sweep;
  ContactArrays contacts;
  NearestArrays nearest;

  std::uint32_t most_brute_force_tiles = 0;    // of one cluster, see usesBruteForce()
  PinnedPointer<CycleCounters> host_counters;  // to which the last kernel copies the counters
  PinnedPointer<std::uint32_t> host_stop;      // not 0: the cycle is to end early

  __device__ const CycleParams& params() const { return *the_params.data(); }
  __device__ CycleCounters& counters() const { return *the_counters.data(); }
  // Returns whether there is only one cluster, of few tiles. Then no cluster structures are built,
  // and the box of each tile is tested against that of every other tile.
  __host__ __device__ bool usesBruteForce() const {
    return clusters.count == 1 && scene.tile_count <= most_brute_force_tiles;
  }
  // Returns how many contacts are on the list; others were found but had no room.
  __device__ std::uint32_t listedContacts() const {
    return static_cast<std::uint32_t>(
        min(counters().contacts, static_cast<unsigned long long>(contacts.contacts.size())));
  }

  DeviceArray<CycleParams, Place> the_params{*this, 1U};
  DeviceArray<CycleCounters, Place> the_counters{*this, 1U};
};

}  // namespace deformable_contact_monitor
