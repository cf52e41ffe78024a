// Numbers of different things, which the compiler keeps apart.
#pragma once

#include <cstdint>

#include "core/host_device.h"

namespace deformable_contact_monitor {

// The number of one of Tag's things; uninitialised as constructed, like a plain number.
template <class Tag>
struct Index {
  std::uint32_t value;

  Index() = default;
  DCM_HD explicit constexpr Index(std::uint32_t v) : value(v) {}
};

template <class Tag>
DCM_HD inline bool operator==(Index<Tag> a, Index<Tag> b) {
  return a.value == b.value;
}
template <class Tag>
DCM_HD inline bool operator!=(Index<Tag> a, Index<Tag> b) {
  return a.value != b.value;
}
template <class Tag>
DCM_HD inline bool operator<(Index<Tag> a, Index<Tag> b) {
  return a.value < b.value;
}
// The one that is so many places further on.
template <class Tag>
DCM_HD inline Index<Tag> operator+(Index<Tag> a, std::uint32_t places) {
  return Index<Tag>(a.value + places);
}

// Of the bodies, vertices and triangles that a backend works on, in its own order.
using BodyIndex = Index<struct BodyTag>;
using VertexIndex = Index<struct VertexTag>;
using TriangleIndex = Index<struct TriangleTag>;
using ClusterIndex = Index<struct ClusterTag>;
using MemberIndex = Index<struct MemberTag>;  // one triangle in one cluster; on CUDA, in its tile
using TileIndex = Index<struct TileTag>;      // a tile of up to 32 triangles
using EntryIndex = Index<struct EntryTag>;    // one tile in one cluster
using SortedIndex = Index<struct SortedTag>;  // a place in the order of the sort

}  // namespace deformable_contact_monitor
