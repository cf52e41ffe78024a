// What the kernels that check states read and write: the bodies, what is searched, and what was
// found. A state is a set of poses of the moved bodies; all other bodies stand still.
#pragma once

#include <cstdint>

#include "core/predicates/aabb.h"
#include "core/rigid_transform.h"
#include "core/rules/part_pairs.h"
#include "core/vector3.h"
#include "cuda/memory/device_memory.cuh"

namespace deformable_contact_monitor {

// A body of some pair. Its triangles are in tiles of up to 32, and these in regions of up to 32.
struct StateBody {
  std::uint32_t first_tile, tile_count, first_region, region_count;
  std::uint32_t moved;  // its place among the poses of a state; kNone: it stands still
};

// Two bodies of which at least one is moved, BodyId a before b.
struct DeviceStatePair {
  std::uint32_t a, b;  // places in StateArrays::bodies
  float touch_m;       // triangles at most so far apart touch; 0: those that intersect
  float margin_m;      // the largest of their triangles
  double radii_m;      // the sum of their radii

  // Returns the distance of the bodies from that of two triangles [m], as PairRadii does.
  __device__ float apartM(float bare_m) const {
    if (bare_m <= touch_m) return 0;
    return fmaxf(toFloat(bare_m - radii_m), 1.4e-45F);
  }
  // Returns how far apart triangles may be if their bodies are at most `apart_m` apart [m].
  __device__ float reachM(float apart_m) const {
    const float within_m = fminf(apart_m, margin_m);
    if (within_m == 0 && touch_m == 0) return 0;
    return __double2float_ru((within_m + radii_m) * (1 + 1e-6) + 0x1p-149);
  }
};

// The regions of a body are ranges of its tiles.
struct StateRegion {
  std::uint32_t first_tile, tile_count;
};

// Two tiles whose triangles may touch, or be the nearest, in a state.
struct StateTiles {
  std::uint32_t state, pair, tile_a, tile_b;
};

// Two triangles that are as near as any that were found before in their state.
struct StateHit {
  std::uint32_t state, pair, slot_a, slot_b;
  float apart_m, bare_m;
};

// The nearest triangles of a state; the distance is that of the bare triangles [m].
struct StateNearest {
  std::uint32_t pair;  // kNone: nothing is within the margins
  std::uint32_t slot_a, slot_b;
  float bare_m;
  Vec3f point_a, point_b, normal;
};

// What is asked in a launch.
struct StateQuestion {
  std::uint32_t nearest;    // the nearest triangles within the margins are searched
  std::uint32_t all_pairs;  // all pairs of bodies that touch are listed; else the first one ends it
  std::uint32_t limited;    // the host may stop the kernels
};

// Counters of a launch.
struct StateCounters {
  std::uint32_t near_tiles, hits, stopped;
};

struct StateArrays {
  std::uint32_t body_count, moved_count, pair_count, tile_count, region_count, state_count;
  StateQuestion question;

  const StateBody* bodies;
  const DeviceStatePair* pairs;
  // The pairs that the warp of a moved body looks at: from walk_begin[moved] up to, but not
  // including, walk_begin[moved + 1].
  const std::uint32_t *walk_begin, *walk_pair;
  const std::uint32_t* moved_body;     // by place among the poses: its place in `bodies`
  const RigidTransform* still_pose;    // by body; of moved bodies it is not used
  const float* vertices;               // of all bodies as received, x y z each
  const std::uint32_t* slot_triangle;  // by slot, 32 for each tile; kNone: none
  const std::uint32_t* slot_vertex;    // three rows by slot: places in `vertices`
  const std::uint32_t* slot_part;      // by slot: its number in `parts`; null: all count
  const float* slot_margin;            // by slot [m]; null: those of the pairs hold
  PartPairs parts;                     // which pairs of parts count
  const std::uint32_t* tile_body;      // by tile
  const StateRegion* regions;

  // The following are written when the bodies change. Boxes and corners are in the frame of a moved
  // body, and in the scene frame for others [m].
  std::uint32_t* received;  // by tile: bit i is set if its triangle i was received finite
  std::uint32_t* live;      // the same, and the pose of a body that is not moved leaves it finite
  float* corner;            // nine rows by slot: x y z of three corners
  Aabb *tile_box, *region_box, *body_box;
  Vec3f* tile_point;          // by tile: a corner of a live triangle
  std::uint32_t* tile_least;  // by tile: the least number of a live triangle

  // The following belong to a launch.
  const RigidTransform* poses;  // state by state, moved_count each
  StateTiles* near_tiles;
  std::uint32_t near_tiles_size;
  StateHit* hits;
  std::uint32_t hits_size;
  std::uint32_t* touches;        // by state: 1 if some bodies touch
  std::uint32_t* leaves_floats;  // by state: 1 if a pose takes a vertex beyond float32
  std::uint8_t* pair_touches;    // by state and pair
  std::uint32_t* apart;          // by state: the bits of the least distance so far [m]
  // By state: the pair of bodies, then triangle a, of the first triangles that touch, of those that
  // were found so far. Only of pairs without radii.
  unsigned long long* first_touch;
  // By state: the bits of a bound of the least distance, then the moved body whose seed gave it;
  // and by state and moved body, the tiles that did.
  unsigned long long* seed_key;
  StateTiles* seeds;
  std::uint32_t* best_pair;    // by state: these three choose among hits as near as `apart`
  unsigned long long* best_a;  // the bits of the bare distance, then triangle a
  std::uint32_t* best_b;       // triangle b
  StateNearest* found;         // by state
  StateCounters* counters;
  const std::uint32_t* host_stop;  // in the host's memory

  __host__ __device__ std::uint32_t slotCount() const { return 32 * tile_count; }
};

}  // namespace deformable_contact_monitor
