// What stage assign leaves of each triangle, in a slot of its tile, and of each tile. The sweep and
// the narrow phase read it.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>

#include "core/predicates/aabb.h"
#include "core/predicates/triangle.h"
#include "core/rules/diagonal_box.h"
#include "cuda/memory/device_memory.cuh"

namespace deformable_contact_monitor {

// A triangle in its slot of a tile.
struct alignas(16) TileEntry {
  Triangle posed;  // scene frame [m]
  TriangleIndex triangle;
  BodyIndex body;
  std::uint32_t part;  // its number, see SceneArrays::pair_enabled
};
// With padding, the compiler would copy it byte by byte.
static_assert(sizeof(TileEntry) == sizeof(Triangle) + 3 * sizeof(std::uint32_t));

// The box of a tile entry [m], inflated by its body's margin. In swept motion it contains all
// places that the triangle passes, minus the common motion.
struct alignas(16) TileEntryBox {
  float4 low, high;  // low.w holds the bits of the slot, in the array of all boxes; high.w is 0

  __device__ static TileEntryBox of(const Aabb& box, TileEntryIndex slot = TileEntryIndex(0)) {
    return {make_float4(box.min.x, box.min.y, box.min.z, __uint_as_float(slot.value)),
            make_float4(box.max.x, box.max.y, box.max.z, 0)};
  }
  __device__ Aabb box() const { return {{low.x, low.y, low.z}, {high.x, high.y, high.z}}; }
};

// The bounds of a tile's entries; in swept motion they bound all that the triangles pass. They are
// empty in slots without a triangle, and where it is culled. Each part is an array of all lanes, so
// that a warp reads it in as few memory sectors as possible.
struct alignas(16) TileBounds {
  float4 low[kWarp], high[kWarp];  // boxes, as in TileEntryBox
  DiagonalBox diagonals[kWarp];

  __device__ TileEntryBox box(unsigned lane) const { return {low[lane], high[lane]}; }
  __device__ void put(unsigned lane, const TileEntryBox& box, const DiagonalBox& along) {
    low[lane] = box.low;
    high[lane] = box.high;
    diagonals[lane] = along;
  }
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
  DiagonalBox diagonals;  // of the live triangles, as those in TileArrays

  // Returns whether a live triangle of one tile may meet one of the other.
  __device__ bool mayMeet(const TileState& other) const {
    return intersects(box, other.box) && intersects(diagonals, other.diagonals);
  }
};

}  // namespace deformable_contact_monitor
