// Which triangles are in which clusters (stage assign).
#pragma once

#include <cstdint>

#include "core/predicates/triangle.h"
#include "cuda/memory/device_memory.cuh"

namespace deformable_contact_monitor {

// One triangle in one cluster, or on the large list.
struct alignas(16) Member {
  Triangle posed;  // scene frame [m]
  TriangleIndex triangle;
  // Where its clusters are in MemberArrays::lists: their number, then they, ascending. kNone: it is
  // in this cluster alone.
  std::uint32_t list;
  std::uint32_t body_and_home;  // body * 2 + 1 in its lowest cluster, body * 2 elsewhere

  __device__ BodyIndex body() const { return BodyIndex(body_and_home >> 1); }
  __device__ bool isHome() const { return (body_and_home & 1) != 0; }
};

// Where the triangle of a member was at the beginning of the step [m].
struct alignas(16) EarlierMember {
  Triangle posed;
};

// A cluster's part of the array of members, and of the sorted arrays.
struct Bin {
  std::uint32_t begin, capacity;
};

// A triangle in more clusters than a short list holds.
struct alignas(8) WideTriangle {
  TriangleIndex triangle;
  BodyIndex body;
};

struct MemberArrays : ArrayGroup {
  using ArrayGroup::ArrayGroup;

  // Of the clusters, then of the large list; this cycle's, and the next one's.
  DeviceArray<Bin, ClusterIndex> bins{*this, &CycleSizes::clusters, 1};
  DeviceArray<Bin, ClusterIndex> next_bins{*this, &CycleSizes::clusters, 1};
  // How many members came to each bin, whether they fit or not, in the first of 8 places, which
  // keeps the counters of different clusters in different sectors; zero at the start of a cycle.
  DeviceArray<std::uint32_t, ClusterIndex, 8> counts{*this, &CycleSizes::clusters, 1};
  DeviceArray<Member, MemberIndex> members{*this, &CycleSizes::members};
  DeviceArray<EarlierMember, MemberIndex> earlier{*this, &CycleSizes::swept_members};  // of each
  DeviceArray<WideTriangle, Place> wide{*this, &CycleSizes::triangles};
  DeviceArray<std::uint32_t, Place> lists{*this, &CycleSizes::list_words};

  __device__ std::uint32_t& count(ClusterIndex g) const { return *counts.row(g); }
  // Of the members of a cluster those that are there.
  __device__ std::uint32_t present(ClusterIndex g) const { return min(count(g), bins[g].capacity); }
  // The member's ascending list of clusters; null: it is in one alone.
  __device__ const std::uint32_t* clustersOf(const Member& m) const {
    return m.list == kNone ? nullptr : lists.data() + m.list + 1;
  }
};

}  // namespace deformable_contact_monitor
