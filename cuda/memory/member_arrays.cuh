// The triangles by tiles, and which tiles are in which clusters (stage assign).
#pragma once

#include <cuda_runtime.h>

#include <cstdint>
#include <cstring>

#include "core/predicates/aabb.h"
#include "core/predicates/triangle.h"
#include "cuda/memory/device_memory.cuh"

namespace deformable_contact_monitor {

// One triangle in its tile's slot.
struct alignas(16) Member {
  Triangle posed;  // scene frame [m]
  TriangleIndex triangle;
  BodyIndex body;
  std::uint32_t group;  // the body's
};
// With padding it would be moved byte by byte.
static_assert(sizeof(Member) == sizeof(Triangle) + 3 * sizeof(std::uint32_t));

// The box of a member [m]: of all that it passes, but for the common motion, with its body's
// margin.
struct alignas(16) MemberBox {
  float4 low, high;  // of which w is of no use

  __device__ static MemberBox of(const Aabb& box) {
    return {make_float4(box.min.x, box.min.y, box.min.z, 0),
            make_float4(box.max.x, box.max.y, box.max.z, 0)};
  }
  __device__ Aabb box() const { return {{low.x, low.y, low.z}, {high.x, high.y, high.z}}; }
};

// Where the triangle of a member was at the beginning of the step [m].
struct alignas(16) EarlierMember {
  Triangle posed;
};

// What the stage assign leaves of a tile: of its live triangles, that is, those that are neither
// dropped nor large.
struct alignas(16) TileState {
  Aabb box;            // all that they pass, with the body's margin [m]
  std::uint32_t live;  // a bit for each slot
  // Where the tile's clusters are in MemberArrays::lists: their number, then they, ascending.
  // kNone: it is in one alone.
  std::uint32_t list;
};

// A cluster's part of the array of entries, and of the sorted arrays; and how many places it was to
// have at least.
struct alignas(16) Bin {
  std::uint32_t begin, capacity, wanted;
};

struct MemberArrays : ArrayGroup {
  using ArrayGroup::ArrayGroup;

  // Of the clusters; this cycle's, and the next one's.
  DeviceArray<Bin, ClusterIndex> bins{*this, &CycleSizes::clusters};
  DeviceArray<Bin, ClusterIndex> next_bins{*this, &CycleSizes::clusters};
  // How many entries came to each bin, whether they fit or not, in the first of so many places,
  // which keeps the counters of different clusters in different sectors; zero at the start of a
  // cycle.
  static constexpr unsigned kCountPlaces = 8;
  DeviceArray<std::uint32_t, ClusterIndex, kCountPlaces> counts{*this, &CycleSizes::clusters};
  DeviceArray<TileIndex, EntryIndex> entries{*this, &CycleSizes::entries};
  DeviceArray<Member, MemberIndex> members{*this, &CycleSizes::slots};
  DeviceArray<MemberBox, MemberIndex> boxes{*this, &CycleSizes::slots};
  DeviceArray<EarlierMember, MemberIndex> earlier{*this, &CycleSizes::swept_slots};  // of each
  // Of each, its vertices' ids, where some body has contacts with itself.
  DeviceArray<uint4, MemberIndex> ids{*this, &CycleSizes::slots};
  DeviceArray<TileState, TileIndex> tiles{*this, &CycleSizes::tiles};
  DeviceArray<MemberIndex, Place> large{*this, &CycleSizes::slots};
  DeviceArray<std::uint32_t, Place> lists{*this, &CycleSizes::list_words};

  // A whole member, by few wide loads.
  __device__ Member at(MemberIndex slot) const {
    static_assert(sizeof(Member) == 3 * sizeof(uint4));
    const auto* from = reinterpret_cast<const uint4*>(&members[slot]);
    const uint4 words[3] = {from[0], from[1], from[2]};
    Member member;
    memcpy(&member, words, sizeof member);
    return member;
  }
  __device__ std::uint32_t& count(ClusterIndex g) const { return *counts.row(g); }
  // Of the entries of a cluster those that are there.
  __device__ std::uint32_t present(ClusterIndex g) const { return min(count(g), bins[g].capacity); }
  // The tile's ascending list of clusters; null: it is in one alone.
  __device__ const std::uint32_t* clustersOf(const TileState& tile) const {
    return tile.list == kNone ? nullptr : lists.data() + tile.list + 1;
  }
};

}  // namespace deformable_contact_monitor
