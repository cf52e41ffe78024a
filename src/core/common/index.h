// Types for indices of different things, so that the compiler finds mixed-up indices.
#pragma once

#include <cstdint>

#include "core/host_device.h"

namespace deformable_contact_monitor {

// The index of an item of kind Tag. Uninitialised by default, like a plain number.
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
// Returns the index that is so many places further on.
template <class Tag>
DCM_HD inline Index<Tag> operator+(Index<Tag> a, std::uint32_t places) {
  return Index<Tag>(a.value + places);
}

// A backend numbers the bodies, vertices and triangles that it works on in its own order.
using BodyIndex = Index<struct BodyTag>;
using VertexIndex = Index<struct VertexTag>;
using TriangleIndex = Index<struct TriangleTag>;
using ClusterIndex = Index<struct ClusterTag>;
using TileEntryIndex =
    Index<struct TileEntryTag>;               // one triangle in one cluster; on CUDA, in its tile
using TileIndex = Index<struct TileTag>;      // a tile of up to 32 triangles
using EntryIndex = Index<struct EntryTag>;    // one tile in one cluster
using SortedIndex = Index<struct SortedTag>;  // a place in the order of the sort

}  // namespace deformable_contact_monitor
