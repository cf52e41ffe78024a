// Declares the arrays of the scene: the bodies that are in some enabled pair, with their vertices,
// triangles and tiles. The stages transform and assign read them.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>

#include "core/rigid_transform.h"
#include "cuda/device/boxes.cuh"
#include "cuda/memory/device_memory.cuh"

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
  // A matrix of bodies x bodies bits, in rows of pair_row words.
  DeviceArray<std::uint32_t, Place> pair_enabled{*this, &CycleSizes::pair_words};
  DeviceArray<BodyBlock, Place> vertex_blocks{*this, &CycleSizes::vertex_blocks};
  DeviceArray<BodyBlock, Place> triangle_blocks{*this, &CycleSizes::triangle_blocks};
  // The bodies' triangles, grouped into tiles (stages/tiles.cuh); kNone in slots without a
  // triangle.
  DeviceArray<BodyIndex, TileIndex> tile_body{*this, &CycleSizes::tiles};
  DeviceArray<TriangleIndex, TileEntryIndex> slot_triangle{*this, &CycleSizes::slots};
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
  // are others.
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
};

}  // namespace deformable_contact_monitor
