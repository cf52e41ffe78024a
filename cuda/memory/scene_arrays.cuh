// The scene on the device (stage pose): bodies of which some pair is enabled, with their vertices
// and triangles numbered through.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>

#include "core/rigid_transform.h"
#include "cuda/device/boxes.cuh"
#include "cuda/memory/device_memory.cuh"

namespace deformable_contact_monitor {

// A body that takes part, as uploaded each cycle.
struct DeviceBody {
  RigidTransform pose;
  // What boxes grow by [m]: the margin, or in swept motion the pad and a little; and [scaled].
  float margin_m, slack;
  std::uint32_t identity_pose;
  std::uint32_t has_self;  // contacts with itself are enabled
  std::uint32_t first_vertex, vertex_count;
  std::uint32_t first_triangle, triangle_count, first_tile;
  std::uint32_t group;
  std::uint32_t partner_begin, partner_count;  // other bodies: in SceneArrays::partners
};

// Where a body was at the beginning of the step; in swept motion, as uploaded each cycle.
struct EarlierBody {
  RigidTransform pose;
  std::uint32_t identity_pose;
  std::uint32_t is_still;      // it has no earlier state
  std::uint32_t has_vertices;  // of its own: in SceneArrays::earlier_received
  float pad_m;
};

// A block of a body's vertices or triangles, by their numbers.
struct BodyBlock {
  BodyIndex body;
  std::uint32_t first, count;
};

// What a body's triangles are called in results.
struct alignas(8) ListedBody {
  std::uint32_t first_triangle;  // the number of its first one
  std::uint32_t id;              // a BodyId
};

// Of `count` bodies in the order of their triangles: the one that a triangle is of.
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

// A vertex for which the lists of neighbours did not do.
struct alignas(8) FarVertex {
  VertexIndex vertex;
  BodyIndex body;
};

// In SceneArrays::vertex_id: other vertices equal this one.
constexpr std::uint32_t kRepeated = std::uint32_t{1} << 31;
// There too, instead of a number: the vertex lies on that side of the share, by more than its
// body's margin. So no triangle reaches in that has all of its vertices on one side; for others
// they are identified where triangles get their ids.
constexpr std::uint32_t kBelowShare = ~std::uint32_t{0}, kAboveShare = kBelowShare - 1;

struct SceneArrays : ArrayGroup {
  using ArrayGroup::ArrayGroup;

  // How much of the arrays is in use.
  std::uint32_t body_count = 0, pair_row = 0;
  std::uint32_t vertex_block_count = 0, triangle_block_count = 0, triangle_count = 0;
  std::uint32_t tile_count = 0;
  std::uint32_t identity_mask = 0;

  DeviceArray<DeviceBody, BodyIndex> bodies{*this, &CycleSizes::bodies};
  DeviceArray<ListedBody, BodyIndex> listed_bodies{*this, &CycleSizes::bodies};
  DeviceArray<BodyIndex, Place> partners{*this, &CycleSizes::partners};
  // Per group: which groups its bodies meet, as bits.
  DeviceArray<std::uint32_t, Place> group_mask{*this, kMostGroups};
  // Bodies x bodies bits, rows of pair_row words.
  DeviceArray<std::uint32_t, Place> pair_enabled{*this, &CycleSizes::pair_words};
  DeviceArray<BodyBlock, Place> vertex_blocks{*this, &CycleSizes::vertex_blocks};
  DeviceArray<BodyBlock, Place> triangle_blocks{*this, &CycleSizes::triangle_blocks};
  // The bodies' triangles by tiles (stages/group.cuh); kNone in slots without one.
  DeviceArray<BodyIndex, TileIndex> tile_body{*this, &CycleSizes::tiles};
  DeviceArray<TriangleIndex, MemberIndex> slot_triangle{*this, &CycleSizes::slots};
  // What that goes by: where most of a body's vertices are, in its frame [m]; the triangles' keys,
  // and where they are sorted.
  DeviceArray<Aabb, BodyIndex> body_ranges{*this, &CycleSizes::bodies};
  DeviceArray<std::uint64_t, Place> curve_keys{*this, &CycleSizes::triangles};
  DeviceArray<std::uint64_t, Place> sorted_keys{*this, &CycleSizes::triangles};
  // x y z in the body's frame [m].
  DeviceArray<float, VertexIndex, 3> received{*this, &CycleSizes::vertices};
  DeviceArray<VertexIndex, TriangleIndex, 3> corners{*this, &CycleSizes::triangles};
  // x, y, z in the scene frame [m]; w: nearest prototype * 2 + tied.
  DeviceArray<float4, VertexIndex> posed{*this, &CycleSizes::vertices};
  DeviceArray<FarVertex, Place> far_vertices{*this, &CycleSizes::vertices};
  // In swept motion the same at the beginning of the step, and what all bodies move by [m]: any
  // vector would do, it is taken off the present state ahead of boxes and clusters, never verdicts.
  DeviceArray<EarlierBody, BodyIndex> earlier_bodies{*this, &CycleSizes::swept_bodies};
  DeviceArray<float, VertexIndex, 3> earlier_received{*this, &CycleSizes::swept_vertices};
  DeviceArray<float4, VertexIndex> earlier_posed{*this, &CycleSizes::swept_vertices};
  DeviceArray<Vec3f, Place> common_motion{*this, 1U};
  // Of the bodies' finite vertices, see cuda/device/boxes.cuh; zero at the start of a cycle.
  // Outside of one, as received.
  DeviceArray<std::uint32_t, BodyIndex, kSides> body_boxes{*this, &CycleSizes::bodies};
  // Equal iff of one body and equal as received: the number of one of those vertices, and in its
  // own place, where there are others, kRepeated.
  DeviceArray<VertexIndex, VertexIndex> vertex_id{*this, &CycleSizes::vertices};
  // Of bodies that have contacts with themselves, where CycleParams::fans: 1 for a vertex whose fan
  // is certified, as far as its own ring tells.
  DeviceArray<std::uint32_t, VertexIndex> fan_certified{*this, &CycleSizes::vertices};
  // VertexFans of all bodies that have contacts with themselves, once certificates are asked for;
  // and what counts the triangles around each vertex meanwhile.
  DeviceArray<Place, VertexIndex> fan_begin{*this, &CycleSizes::fan_vertices};
  DeviceArray<VertexIndex, Place> fan_ring{*this, &CycleSizes::fan_places};
  DeviceArray<std::uint32_t, VertexIndex> fan_count{*this, &CycleSizes::fan_vertices};
  // An open-addressing hash table of vertices' numbers + 1; its size is a power of two.
  DeviceArray<std::uint32_t, Place> identity_table{*this, &CycleSizes::identity_slots};
};

}  // namespace deformable_contact_monitor
