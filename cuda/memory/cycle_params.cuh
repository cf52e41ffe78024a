// The settings of a cycle, and what it counts.
#pragma once

#include <cstdint>

#include "core/detector.h"
#include "core/options.h"
#include "core/rules/scene_scale.h"
#include "core/rules/size_rule.h"
#include "cuda/partitions/scene_partition.h"

namespace deformable_contact_monitor {

// Groups of bodies that the sweeps tell apart. Scenes with more groups share the last.
constexpr std::uint32_t kMostGroups = 32;
// Buckets along a cluster's first axis, divided evenly among the groups.
constexpr std::uint32_t kBuckets = 1024;
// Positions along an axis have so many bits before they become buckets.
constexpr std::uint32_t kAxisBits = 15;
// What work units' columns are counted in, and the most that one has.
constexpr std::uint32_t kLeastUnitColumns = 8, kMostUnitColumns = 64;

// Settings of a cycle; not part of a recorded graph.
struct CycleParams {
  SceneScale scale;
  SizeRule size;
  float overlap;
  float fuzzifier;
  AdjacentPairs adjacent;
  Predicates predicates;
  std::uint32_t margins;       // some body that takes part has one
  std::uint32_t group_count;   // <= kMostGroups
  std::uint32_t bucket_shift;  // from kAxisBits along the first axis to a bucket of a group
  std::uint32_t groups_exact;  // no two groups of bodies share a number
  std::uint32_t pass, passes;  // this pass makes the steps of stage pairs, and the blocks of the
                               // large list, whose number % passes == pass
  std::uint32_t unit_columns;  // a multiple of kLeastUnitColumns
  std::uint32_t index_bits;    // of a triangle's number in a contact's key
  std::uint32_t any_self;      // some body has contacts with itself
  std::uint32_t fans;          // certified ones settle pairs that share vertices
  std::uint32_t limited;       // the host may end the cycle early (stages/cut_off.cuh)
  std::uint32_t first_times;   // in swept motion: they are asked for
  std::uint32_t pads;          // in swept motion: some body that takes part has one
  SceneShare share;            // of this device: pairs beside it are not looked for
  std::uint32_t settles;       // the sweep gives the verdicts of which float32 is certain
  std::uint32_t leaves_few;    // and leaves few to the judge: flat fans are certified, or skipped

  DCM_HD std::uint32_t bucketsOfGroup() const { return 1U << (kAxisBits - bucket_shift); }
};

// Whether some body that takes part has a margin; in swept motion, a pad.
struct BodyLengths {
  bool margins, pads;
};

// For a scene of `triangles` triangles whose bodies fall into `groups` groups. Scale and size rule
// are left as they are by default.
CycleParams cycleParams(const Options& options, std::uint32_t triangles, std::uint32_t groups,
                        const BodyLengths& any);

// Counters that many warps add to keep apart, in memory lines of their own.
constexpr unsigned kLine = 128;

// Work done, sizes wanted, and what did not fit; zero at the start of a cycle. Counts go on beyond
// capacities, so they say what is needed.
struct alignas(kLine) CycleCounters {
  std::uint32_t rejected, culled, clustered, large;
  std::uint32_t largest_cluster;  // its triangles
  std::uint32_t bin_overflow;     // entries did not fit into some bin
  std::uint32_t bins_wanted;      // entries that next cycle's bins want room for
  std::uint32_t exact, undecided;
  std::uint32_t blocks_done;
  std::uint32_t cut_off;       // some work was given up, for the host wanted the cycle to end
  std::uint32_t open_pairs;    // in swept motion: left to the host
  unsigned long long members;  // of the clusters: triangles
  unsigned long long interval_overlaps;
  unsigned long long settled;   // pairs with a verdict from the sweep: never candidates
  unsigned long long judged;    // all passes' candidates
  unsigned long long unjudged;  // those that there was no room for: no verdict on them
  alignas(kLine) std::uint32_t far_vertices;
  alignas(kLine) std::uint32_t list_words;
  alignas(kLine) std::uint32_t units;
  alignas(kLine) std::uint32_t units_taken;
  alignas(kLine) std::uint32_t tile_pairs;
  alignas(kLine) std::uint32_t crowded_pairs;
  alignas(kLine) std::uint32_t pairs_taken;
  alignas(kLine) unsigned long long candidates;
  alignas(kLine) std::uint32_t open;     // in contacts.open from its front on
  alignas(kLine) std::uint32_t sharing;  // and from its end backwards
  alignas(kLine) unsigned long long contacts;
};

// What users are told of them; `clusters`: how many the cycle had. The rest of `told` stays.
void tell(const CycleCounters& counted, std::uint32_t clusters, Counters& told);

}  // namespace deformable_contact_monitor
