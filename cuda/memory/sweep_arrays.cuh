// Declares the arrays of the clusters: prototypes (stage cluster), the sorted tiles of each
// cluster, and the work units and results of the sweep (stages sort and sweep).
#pragma once

#include <cuda_runtime.h>

#include <cstdint>

#include "core/rules/half_space.h"
#include "core/rules/intervals.h"
#include "core/rules/principal_axes.h"
#include "cuda/memory/device_memory.cuh"

namespace deformable_contact_monitor {

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

}  // namespace deformable_contact_monitor
