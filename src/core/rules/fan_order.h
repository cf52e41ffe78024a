// Orders the triangles around a vertex into a ring. Host and device share this implementation.
#pragma once

#include <cstdint>

#include "core/host_device.h"

namespace deformable_contact_monitor {

constexpr std::uint32_t kMostFanTriangles = 32;  // ordering takes a time that grows with its square

// The edge of a triangle opposite to the vertex.
struct FanEdge {
  std::uint32_t from, to;
};

// Orders the edges so that each begins where the one before ends. Returns false if there is no such
// order. The result depends on the order in which they come.
DCM_HD inline bool orderFan(FanEdge* edges, std::uint32_t count) {
  const auto swapWith = [edges](std::uint32_t i, std::uint32_t j) {
    const FanEdge edge = edges[i];
    edges[i] = edges[j];
    edges[j] = edge;
  };
  for (std::uint32_t i = 0; i < count; ++i) {
    std::uint32_t before = 0;
    while (before < count && edges[before].to != edges[i].from) ++before;
    if (before < count) continue;
    swapWith(0, i);
    break;
  }
  for (std::uint32_t i = 1; i < count; ++i) {
    std::uint32_t next = i;
    while (next < count && edges[next].from != edges[i - 1].to) ++next;
    if (next == count) return false;
    swapWith(i, next);
  }
  return true;
}

// Writes to `ring`, which has count + 1 places, the ring of vertex v as VertexFans defines it.
// `edges` are the edges opposite to v. They are reordered, and used only up to kMostFanTriangles.
DCM_HD inline void putRing(std::uint32_t v, FanEdge* edges, std::uint32_t count,
                           std::uint32_t* ring) {
  const bool ordered = count > 0 && count <= kMostFanTriangles && orderFan(edges, count);
  ring[0] = ordered ? edges[0].from : v;
  for (std::uint32_t k = 0; k < count; ++k) ring[k + 1] = ordered ? edges[k].to : v;
}

}  // namespace deformable_contact_monitor
