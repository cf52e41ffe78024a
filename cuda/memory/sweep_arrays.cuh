// The tiles of each cluster in the order of the sweep, and the sweep's work (stages sort and
// sweep).
#pragma once

#include <cuda_runtime.h>

#include <cstdint>

#include "core/rules/intervals.h"
#include "core/rules/principal_axes.h"
#include "cuda/memory/device_memory.cuh"

namespace deformable_contact_monitor {

// What a cluster is projected onto. From the cluster as it was last cycle: any frame is safe.
struct ClusterFrame {
  Vec3f centre;
  PrincipalAxes axes;
  Quantiser along[3];  // the principal axes
};

// Up to 32 sorted entries against up to CycleParams::unit_columns of the partners of each.
struct WorkUnit {
  ClusterIndex cluster;
  SortedIndex first_row;
  std::uint32_t rows_and_groups;  // rows | group of the rows << 8 | group of the columns << 16
  std::uint32_t first_column;     // counted from where each row's partners begin

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
  // Of the tiles' boxes about the frames' centres.
  DeviceArray<Moments, ClusterIndex> moments{*this, &CycleSizes::clusters};
  // Of each entry, as the bins have them: its key and box, as below, and its tile.
  DeviceArray<uint4, EntryIndex> projected{*this, &CycleSizes::entries};
  // Of each entry, in the bins' order by group and bucket.
  // Second and third axis; a sweep reads up to 64 places on.
  DeviceArray<PackedBox, SortedIndex> boxes{*this, &CycleSizes::entries, 64};
  // Bucket of the beginning, bucket of the end << 16; within the group.
  DeviceArray<std::uint32_t, SortedIndex> keys{*this, &CycleSizes::entries};
  DeviceArray<TileIndex, SortedIndex> tiles{*this, &CycleSizes::entries};
  // Where the entries of each bucket begin, and behind the last one where they end.
  DeviceArray<std::uint32_t, ClusterIndex, kBuckets + 1> bucket_begin{*this, &CycleSizes::clusters};
  DeviceArray<WorkUnit, Place> units{*this, &CycleSizes::units};
  // What the sweep leaves: pairs of different tiles whose boxes meet, each once; and those with
  // many triangles that may meet.
  DeviceArray<TilePair, Place> tile_pairs{*this, &CycleSizes::tile_pairs};
  DeviceArray<TilePair, Place> crowded_pairs{*this, &CycleSizes::crowded_pairs};
};

// The places of a row's partners among the sorted entries: those of group `columns` that begin
// within the row's interval. Of two that begin in one bucket, the one of the later group, or the
// later one, is the partner; so each pair is met once.
struct ColumnRange {
  std::uint32_t begin, end;
};
// `bucket_begin`: the cluster's; `buckets`: of a group; `key`: the row's.
__device__ inline ColumnRange columnsOf(const std::uint32_t* bucket_begin, std::uint32_t buckets,
                                        std::uint32_t rows, std::uint32_t columns, SortedIndex row,
                                        std::uint32_t key) {
  const std::uint32_t* begin = bucket_begin + columns * buckets;
  const std::uint32_t first = key & 0xffffU, last = key >> 16;
  return {rows == columns ? row.value + 1 : begin[columns < rows ? first + 1 : first],
          begin[last + 1]};
}

}  // namespace deformable_contact_monitor
