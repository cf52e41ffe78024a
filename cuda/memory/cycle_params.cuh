// Declares the settings of a cycle and its counters, as the kernels see them.
#pragma once

#include <cstdint>

#include "core/detector.h"
#include "core/options.h"
#include "core/rules/axis_box.h"
#include "core/rules/diagonal_box.h"
#include "core/rules/scene_scale.h"
#include "cuda/device/boxes.cuh"
#include "cuda/partitions/scene_partition.h"

namespace deformable_contact_monitor {

// The number of groups of bodies that the sweeps distinguish. In a scene with more groups, all
// further ones share the last number.
constexpr std::uint32_t kMostGroups = 32;
// The number of buckets along a cluster's first axis, divided evenly among the groups.
constexpr std::uint32_t kBuckets = 1024;
// The number of bits of a position along an axis, from which the bucket is computed.
constexpr std::uint32_t kAxisBits = 15;
// The number of columns of a work unit is a multiple of the first, and at most the second.
constexpr std::uint32_t kLeastUnitColumns = 8, kMostUnitColumns = 64;

// What the sweep knows of vertices that are equal: nothing; only which ones are the same by their
// number (SceneArrays::slot_numbers); or all, by their ids (TileArrays::ids).
enum class KnownIdentities : std::uint32_t { kNone, kNumbers, kAll };

// The settings of a cycle. They are not part of a recorded graph, so they may change in every
// cycle.
struct CycleParams {
  SceneScale scale;
  DiagonalFrame diagonals;
  AxisFrame axes;  // of the rounded boxes, as `diagonals`
  SizeBounds size;
  float overlap;
  float fuzzifier;
  AdjacentPairs adjacent;
  Predicates predicates;
  std::uint32_t margins;       // 1 if some body that takes part has a margin
  std::uint32_t group_count;   // <= kMostGroups
  std::uint32_t bucket_shift;  // from a position of kAxisBits bits to a bucket of a group
  // 1 if each pair of triangles of two groups is enabled: no two groups of bodies share a number,
  // and parts do not matter.
  std::uint32_t groups_exact;
  std::uint32_t parts;  // 1 if some body has parts: SceneArrays::part has the number of each part
  // The number of this pass, and of all passes. This pass makes the steps of the sweep and the
  // blocks of the oversized stage whose number % passes == pass.
  std::uint32_t pass, passes;
  std::uint32_t unit_columns;  // a multiple of kLeastUnitColumns
  std::uint32_t index_bits;    // of a triangle's number, in the key of a contact
  std::uint32_t any_self;      // 1 if some body may have contacts with itself
  KnownIdentities identities;
  std::uint32_t fans;         // 1 if certified fans decide pairs that share vertices
  std::uint32_t limited;      // 1 if the host may end the cycle early (stages/cut_off.cuh)
  std::uint32_t first_times;  // in swept motion: 1 if the user asks for contact times
  std::uint32_t pads;         // in swept motion: 1 if some body that takes part has a pad
  ScenePartition partition;   // of this device: other pairs are not detected
  std::uint32_t decides;      // 1 if the sweep decides pairs where float32 is certain
  // 1 if the sweep leaves so few pairs to the narrow phase that one kernel for all is fastest.
  std::uint32_t leaves_few;

  DCM_HD std::uint32_t bucketsOfGroup() const { return 1U << (kAxisBits - bucket_shift); }
};

// States whether some body that takes part has a margin, and in swept motion a pad.
struct BodyLengths {
  bool margins, pads;
};

// States whether some body has parts, and whether they matter (Scene::partsMatter()).
struct PartUse {
  bool any, matter;
};

// Returns the settings for a scene of `triangles` triangles whose bodies fall into `groups` groups.
// Scale, size rule and partition keep their defaults.
CycleParams cycleParams(const Options& options, std::uint32_t triangles, std::uint32_t groups,
                        const BodyLengths& any, const PartUse& parts);

// The size of a memory line [bytes]. Counters that many warps add to have a line each.
constexpr unsigned kLine = 128;

// Counts the work of a cycle, the sizes that it wants, and what did not fit. All are zero at the
// start of a cycle. Counts go on beyond the capacities, so they tell how much room is needed.
struct alignas(kLine) CycleCounters {
  std::uint32_t rejected, culled, clustered, oversized;
  std::uint32_t largest_cluster;  // the number of its triangles
  std::uint32_t bin_overflow;     // 1 if entries did not fit into some bin
  std::uint32_t bins_wanted;      // entries for which the next cycle's bins need room
  std::uint32_t exact, undecided;
  std::uint32_t blocks_done;
  std::uint32_t cut_off;               // 1 if work was given up because the host ended the cycle
  std::uint32_t open_pairs;            // in swept motion: pairs that are left to the host
  unsigned long long cluster_entries;  // the triangles of all clusters, added up
  unsigned long long interval_overlaps;
  unsigned long long decided;     // pairs that the sweep decided; they are no candidates
  unsigned long long examined;    // the candidates of all passes
  unsigned long long unexamined;  // candidates without room, which get no verdict
  alignas(kLine) std::uint32_t far_vertices;
  // Not in swept motion: how many vertices equal another one if these are searched; otherwise how
  // many pairs of triangles were found to share one.
  std::uint32_t repeated_vertices;
  std::uint32_t sharing_pairs;
  // The box of the live triangles of some thousand tiles, see boxOf() in cuda/device/boxes.cuh.
  alignas(kLine) std::uint32_t tiles_box[kSides];
  alignas(kLine) std::uint32_t list_words;
  alignas(kLine) std::uint32_t units;
  alignas(kLine) std::uint32_t units_taken;
  alignas(kLine) std::uint32_t tile_pairs;
  alignas(kLine) std::uint32_t dense_pairs;
  alignas(kLine) std::uint32_t pairs_taken;
  alignas(kLine) std::uint32_t near_tiles;
  std::uint32_t nearest_hits;     // on nearest.hits, including those without room
  std::uint32_t nearest_cut_off;  // 1 if the search for nearest pairs was given up
  alignas(kLine) unsigned long long candidates;
  alignas(kLine) std::uint32_t open;           // on contacts.open, from its front on
  alignas(kLine) std::uint32_t open_adjacent;  // on contacts.open, from its end backwards
  alignas(kLine) unsigned long long contacts;
};

// Copies the counters that users get to `told`, and leaves its other counters alone. `clusters`:
// the number of clusters in the cycle.
void reportCounters(const CycleCounters& counted, std::uint32_t clusters, Counters& told);

}  // namespace deformable_contact_monitor
