// What stage assign leaves of each triangle, in a slot of its tile, and of each tile. The sweep and
// the narrow phase read it.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>

#include "core/predicates/aabb.h"
#include "core/predicates/triangle.h"
#include "core/rules/axis_box.h"
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

// The box of a tile entry, and its slot. The box has all that the triangle passes, minus the common
// motion and grown by its body's margin.
struct alignas(16) SlotBox {
  std::uint32_t x, y, z;  // the words of an AxisBox
  TileEntryIndex slot;

  __device__ static SlotBox of(const AxisBox& box, TileEntryIndex slot) {
    return {box.words[0], box.words[1], box.words[2], slot};
  }
  __device__ AxisBox box() const { return {x, y, z}; }
};

// The bounds of a tile's entries. They are empty in slots without a triangle, and where it is
// culled. Each part is an array of all lanes, so that a warp reads it in as few memory sectors as
// possible.
struct alignas(16) TileBounds {
  SlotBox boxes[kWarp];
  DiagonalBox diagonals[kWarp];

  __device__ void put(unsigned lane, const SlotBox& box, const DiagonalBox& along) {
    boxes[lane] = box;
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
  TurnedAxisBox axes;     // likewise

  // Returns the state of a tile without live triangles.
  __device__ static TileState none() {
    return {Aabb(), 0, kNone, DiagonalBox::none(), TurnedAxisBox(AxisBox())};
  }
  // Returns whether a live triangle of one tile may meet one of the other.
  __device__ bool mayMeet(const TileState& other) const {
    return intersects(box, other.box) && intersects(diagonals, other.diagonals);
  }
};

}  // namespace deformable_contact_monitor
