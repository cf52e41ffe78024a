// What the kernels of a cycle see: plain views of the device's arrays. See cuda_detector.cu for the
// order of the stages.
#pragma once

#include <cstdint>

#include "core/cpu/size_split.h"
#include "core/options.h"
#include "core/rules/half_space.h"
#include "core/rules/principal_axes.h"
#include "core/rules/rigid_transform.h"
#include "core/rules/scene_scale.h"

namespace deformable_contact_monitor {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

// Classes of bodies that the sweeps tell apart. Scenes with more groups of bodies share the last.
constexpr std::uint32_t kMostClasses = 32;
// What work units' columns are counted in.
constexpr std::uint32_t kLeastUnitColumns = 8;
// Buckets along a cluster's first axis, divided evenly among the classes.
constexpr std::uint32_t kBuckets = 1024;

// A body that takes part, as uploaded each cycle.
struct DeviceBody {
  RigidTransform pose;
  float margin_m, slack;  // [m]; [scaled]
  std::uint32_t identity_pose;
  std::uint32_t has_self;  // contacts with itself are enabled
  std::uint32_t first_vertex, vertex_count;
  std::uint32_t class_of_body;
  std::uint32_t partner_begin, partner_count;  // other bodies: in CycleView::partners
};

// A block of a body's vertices or triangles, by their numbers in the scene.
struct BodyBlock {
  std::uint32_t body, first, count;
};

// One triangle in one cluster, or on the large list.
struct alignas(16) Member {
  Triangle posed;
  std::uint32_t triangle;  // in the scene
  // Where its clusters are in CycleView::lists: their number, then they, ascending. kNone: it is in
  // this cluster alone.
  std::uint32_t list;
  std::uint32_t body_and_home;  // body * 2 + 1 in its lowest cluster, body * 2 elsewhere
};

// A cluster's part of the arrays of members.
struct Bin {
  std::uint32_t begin, capacity;
};

// What a cluster is projected onto. From the cluster as it was last cycle: any frame is safe.
struct ClusterFrame {
  Vec3f centre;
  PrincipalAxes axes;
  Quantiser along[3];  // the principal axes
  Quantiser world[4];  // x, y, z, z
};

// Up to 32 sorted members against up to CycleParams::unit_columns of the partners of each.
struct WorkUnit {
  std::uint32_t cluster, first_row;
  std::uint32_t rows_and_classes;  // rows | class of the rows << 8 | class of the columns << 16
  std::uint32_t first_column;      // counted from where each row's partners begin
};

// Two members for the narrow phase, and what the filters found.
struct Candidate {
  std::uint32_t a, b;
  // Two bits for each of 3 + 3 sides (side + 1), then three for each triangle's shared vertices.
  std::uint32_t signs;
};

// A centroid for fuzzy c-means [scaled], and a prototype near it, or kNone.
struct Sample {
  Vec3f centroid;
  std::uint32_t near;
};

// Settings of a cycle; not part of a recorded graph.
struct CycleParams {
  SceneScale scale;
  SizeRule size;
  float overlap;
  float fuzzifier;
  AdjacentPairs adjacent;
  Predicates predicates;
  std::uint32_t margins;        // some body has one
  std::uint32_t class_count;    // <= kMostClasses
  std::uint32_t bucket_shift;   // from 15 bits along the first axis to a bucket of a class
  std::uint32_t classes_exact;  // no two groups of bodies share a class
  std::uint32_t pass,
      passes;  // this one sweeps the work units u with u % passes == pass; large list: blocks
  std::uint32_t unit_columns;  // a multiple of kLeastUnitColumns
  std::uint32_t index_bits;    // of a triangle's number in a contact's key
};

// Counters that many warps add to keep apart, in memory lines of their own.
constexpr unsigned kLine = 128;

// Work done, sizes wanted, and what did not fit; zero at the start of a cycle. Counts go on beyond
// capacities, so they say what is needed.
struct alignas(kLine) CycleCounters {
  std::uint32_t rejected, culled, clustered, large;
  std::uint32_t entries, largest_cluster;
  std::uint32_t bin_overflow;  // members did not fit into some bin
  std::uint32_t bins_wanted;   // members that next cycle's bins want room for
  std::uint32_t exact, undecided;
  std::uint32_t blocks_done;
  unsigned long long interval_overlaps;
  unsigned long long judged;  // all passes' candidates
  alignas(kLine) std::uint32_t wide;
  alignas(kLine) std::uint32_t list_words;
  alignas(kLine) std::uint32_t units;
  alignas(kLine) std::uint32_t units_taken;
  alignas(kLine) unsigned long long candidates;
  alignas(kLine) std::uint32_t open;
  alignas(kLine) unsigned long long contacts;
};

// Places in CycleView::member_count from one cluster's to the next one's.
constexpr std::uint32_t kCountStride = 8;

// All arrays live on the device. Vertices and triangles are of the bodies that take part.
struct CycleView {
  const CycleParams* params;
  CycleCounters* counters;
  CycleCounters* host_counters;  // pinned: where the last kernel leaves them
  const DeviceBody* bodies;
  const std::uint32_t* partners;
  const std::uint32_t* class_mask;    // per class: which classes its bodies meet, as bits
  const std::uint32_t* pair_enabled;  // bodies x bodies bits, rows of pair_row words
  std::uint32_t body_count, pair_row;

  const BodyBlock* vertex_blocks;
  const BodyBlock* triangle_blocks;
  std::uint32_t vertex_block_count, triangle_block_count;
  std::uint32_t triangle_count;
  const float* received;         // x y z per vertex, in the body's frame [m]
  const std::uint32_t* corners;  // three vertices per triangle
  float4* posed;                 // x, y, z [m], scene frame; w: nearest prototype * 2 + tied
  uint2* far_vertices;           // vertex, body: where the lists of neighbours did not do
  std::uint32_t* far_count;      // of them; zero at the start of a cycle
  std::uint32_t* body_boxes;     // per body, see cuda/boxes.cuh; zero at the start of a cycle
  std::uint32_t* vertex_id;      // equal iff of one body and equal as received
  std::uint32_t* identity_table;
  std::uint32_t identity_mask;

  std::uint32_t cluster_count;
  Vec3f* prototypes;       // [scaled]
  Vec3f* live_prototypes;  // likewise; those that coincide with another one are far off
  float* list_reach;
  Neighbour* neighbours;
  std::uint32_t* neighbour_cluster;
  float4* membership_sums;  // per prototype: sum u^m (x - p), sum u^m
  Sample* samples;
  std::uint32_t sample_count;

  Bin* bins;  // of the clusters, then of the large list
  Bin* next_bins;
  std::uint32_t* member_count;  // see countOf
  std::uint32_t member_capacity;
  Member* members;
  uint2* wide;  // triangle, body
  std::uint32_t* lists;
  std::uint32_t list_capacity;

  ClusterFrame* frames;
  Moments* moments;  // of the members' centroids about the frames' centres
  // Sorted by class and bucket, in the same bins as the members.
  PackedBox* sweep_boxes;     // second and third axis
  std::uint32_t* sweep_keys;  // bucket of the beginning, bucket of the end << 16; within the class
  uint4* world_boxes;         // x and y, lo and hi; z, lo and hi
  uint4* sweep_ids;           // three vertex ids, the member
  std::uint32_t* bucket_begin;  // per cluster: kBuckets + 1 places
  WorkUnit* units;
  std::uint32_t unit_capacity;

  Candidate* candidates;
  std::uint32_t candidate_capacity;
  std::uint32_t* open;  // candidates that the filters could not settle
  std::uint64_t* contacts;
  float* separations_m;
  std::uint32_t contact_capacity;
};

// The places of a row's partners among the sorted members: those of class `columns` that begin
// within the row's interval. Of two that begin in one bucket, the one of the later class, or the
// later one, is the partner; so each pair is met once.
struct ColumnRange {
  std::uint32_t begin, end;
};
// `bucket_begin`: the cluster's; `buckets`: of a class.
__device__ inline ColumnRange columnsOf(const std::uint32_t* bucket_begin, std::uint32_t buckets,
                                        std::uint32_t rows, std::uint32_t columns,
                                        std::uint32_t row, std::uint32_t key) {
  const std::uint32_t* begin = bucket_begin + columns * buckets;
  const std::uint32_t first = key & 0xffffU, last = key >> 16;
  return {rows == columns ? row + 1 : begin[columns < rows ? first + 1 : first], begin[last + 1]};
}

__device__ inline std::uint32_t& countOf(const CycleView& c, std::uint32_t cluster) {
  return c.member_count[std::size_t{cluster} * kCountStride];
}

__device__ inline PrototypesView prototypesView(const CycleView& c) {
  return {c.live_prototypes, c.list_reach, c.neighbours, c.neighbour_cluster, c.cluster_count};
}

}  // namespace deformable_contact_monitor
