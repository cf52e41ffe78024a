// Declares the arrays of tiles: the triangles of each tile, and the clusters of each tile (stage
// assign).
#pragma once

#include <cuda_runtime.h>

#include <cstdint>
#include <cstring>

#include "core/predicates/aabb.h"
#include "core/predicates/triangle.h"
#include "cuda/memory/device_memory.cuh"

namespace deformable_contact_monitor {

// A triangle in its slot of a tile.
struct alignas(16) TileEntry {
  Triangle posed;  // scene frame [m]
  TriangleIndex triangle;
  BodyIndex body;
  std::uint32_t group;  // of the body
};
// With padding, the compiler would copy it byte by byte.
static_assert(sizeof(TileEntry) == sizeof(Triangle) + 3 * sizeof(std::uint32_t));

// The box of a tile entry [m], inflated by its body's margin. In swept motion it contains all
// places that the triangle passes, minus the common motion.
struct alignas(16) TileEntryBox {
  float4 low, high;  // w is not used

  __device__ static TileEntryBox of(const Aabb& box) {
    return {make_float4(box.min.x, box.min.y, box.min.z, 0),
            make_float4(box.max.x, box.max.y, box.max.z, 0)};
  }
  __device__ Aabb box() const { return {{low.x, low.y, low.z}, {high.x, high.y, high.z}}; }
};

// The triangle of a tile entry at the beginning of the time interval, in the scene frame [m].
struct alignas(16) EarlierTileEntry {
  Triangle posed;
};

// The result of stage assign for a tile. A triangle is live if it is neither culled nor oversized.
struct alignas(16) TileState {
  Aabb box;            // of the live triangles, inflated by the margin [m]
  std::uint32_t live;  // a bit for each slot
  // The place of the tile's clusters in TileArrays::lists: their number, then the clusters in
  // ascending order. kNone if the tile is in one cluster only, or if there was no room for a list.
  std::uint32_t list;
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
  DeviceArray<TileEntryBox, TileEntryIndex> boxes{*this, &CycleSizes::slots};
  DeviceArray<EarlierTileEntry, TileEntryIndex> earlier{*this, &CycleSizes::swept_slots};
  // The ids of each entry's vertices, if some body may have contacts with itself.
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
  __device__ std::uint32_t& count(ClusterIndex g) const { return *counts.row(g); }
  // Returns how many entries of a cluster are in its bin.
  __device__ std::uint32_t present(ClusterIndex g) const { return min(count(g), bins[g].capacity); }
  // Returns the tile's ascending list of clusters; null if it is in one cluster only.
  __device__ const std::uint32_t* clustersOf(const TileState& tile) const {
    return tile.list == kNone ? nullptr : lists.data() + tile.list + 1;
  }
};

}  // namespace deformable_contact_monitor
