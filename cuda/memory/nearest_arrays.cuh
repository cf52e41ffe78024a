// The arrays of the search for nearest pairs.
#pragma once

#include <cstdint>

#include "core/common/index.h"
#include "core/predicates/aabb.h"
#include "core/vector3.h"
#include "cuda/memory/device_memory.cuh"

namespace deformable_contact_monitor {

// Two bodies whose nearest triangles are searched, body a before body b.
struct NearestBodies {
  BodyIndex a, b;
  float margin_m;  // of the two
  // The regions of the two bodies, and the number of this pair's first task. Each pair of regions
  // is a task.
  std::uint32_t first_region_a, first_region_b, regions_b, first_task;
  std::uint32_t points_on_device;  // 1 if the device computes the closest points
  std::uint32_t part_a, part_b;    // only their triangles count; kNone: those of all parts
};

// Up to kWarp consecutive tiles of one body.
struct TileRegion {
  TileIndex first_tile;
  std::uint32_t tile_count;
};

// What the search knows of the triangles of a tile that are not rejected.
struct TileBound {
  Aabb box;             // scene frame [m]
  Vec3f point;          // a vertex of one of them
  std::uint32_t least;  // the least of their numbers; kNone if there are none
};

// Two tiles that may have the nearest triangles of a pair of bodies.
struct NearTiles {
  std::uint32_t pair;  // a place in NearestArrays::pairs
  TileIndex a, b;
};

// A pair of triangles that was as near as any before it.
struct NearestHit {
  unsigned long long key;    // as in NearestArrays::best
  std::uint32_t pair;        // a place in NearestArrays::pairs
  std::uint32_t triangle_b;  // its number on the device
};

// The result of the search for one pair of bodies. Triangles have their numbers in their bodies.
struct NearestFound {
  enum State : std::uint32_t { kBeyond, kFound, kCutOff };
  State state;
  std::uint32_t triangle_a, triangle_b;
  float distance_m;
  Vec3f point_a, point_b, normal;  // only if the device computes them
};

struct NearestArrays : ArrayGroup {
  using ArrayGroup::ArrayGroup;

  std::uint32_t pair_count = 0, region_count = 0, task_count = 0;

  DeviceArray<NearestBodies, Place> pairs{*this, &CycleSizes::nearest_pairs};
  // The best pair of triangles so far: the bits of the distance, then the number of triangle a.
  // Only the distance counts if that number is kNone.
  DeviceArray<unsigned long long, Place> best{*this, &CycleSizes::nearest_pairs};
  // The nearest triangles of the last cycle, as numbers in their bodies + 1; 0: there are none.
  DeviceArray<uint2, Place> last{*this, &CycleSizes::nearest_pairs};
  DeviceArray<TileRegion, Place> regions{*this, &CycleSizes::regions};
  DeviceArray<Aabb, Place> region_boxes{*this, &CycleSizes::regions};  // of their triangles [m]
  DeviceArray<TileBound, TileIndex> tiles{*this, &CycleSizes::nearest_tiles};
  // The part of all triangles of a tile that take part; kNone if they are of several parts. Only if
  // CycleParams::parts is set.
  DeviceArray<std::uint32_t, TileIndex> tile_parts{*this, &CycleSizes::part_tiles};
  DeviceArray<NearTiles, Place> near_tiles{*this, &CycleSizes::near_tiles};
  DeviceArray<NearestHit, Place> hits{*this, &CycleSizes::nearest_hits};
  PinnedPointer<NearestFound> found;  // one for each pair, written by the last kernel
};

}  // namespace deformable_contact_monitor
