// Declares the stages of a cycle as functions that enqueue them into a stream. None of them
// allocates or waits for the device. "Directly after" another launch means that nothing may be
// enqueued in between, because programmatic dependent launch is used; CycleGraph's list of steps
// keeps to it. cuda/README.md has the stages in their order.
#pragma once

#include <cuda_runtime.h>

#include "cuda/device/launch.cuh"
#include "cuda/memory/cycle_arrays.cuh"
#include "cuda/memory/host_copy.cuh"

namespace deformable_contact_monitor {

// States which steps a cycle consists of. A recorded graph depends on this and on the arrays, and
// on nothing else.
struct CycleShape {
  DeviceTraits device;
  bool identify = false;    // equal vertices are searched, see DeviceScene::searchesEqualVertices()
  int refinements = 0;      // steps of fuzzy c-means, for the next cycle
  bool swept = false;       // swept motion: each launch works on both states
  bool adjacent = false;    // triangles that share vertices may be contacts
  bool pads = false;        // in swept motion: some body has a pad
  bool times = false;       // in swept motion: first times are wanted
  bool fans = false;        // certified fans decide pairs that share vertices
  bool leaves_few = false;  // as in CycleParams::leaves_few
  bool margins = false;     // as in CycleParams::margins
  bool nearest = false;     // the nearest pairs of bodies are searched

  bool operator==(const CycleShape& o) const {
    return device == o.device && identify == o.identify && refinements == o.refinements &&
           swept == o.swept && adjacent == o.adjacent && pads == o.pads && times == o.times &&
           fans == o.fans && leaves_few == o.leaves_few && margins == o.margins &&
           nearest == o.nearest;
  }
};

// One of the launches below.
using Launch = void (*)(const CycleArrays&, const CycleShape&, cudaStream_t);

// transform: finds vertices that are equal as received, if `shape.identify` asks for it, and those
// whose fans are certified. Reads scene.received; writes scene.vertex_id and
// scene.fan_certified. If the detector has one of several partitions, it skips vertices that lie
// beside it (not in swept motion).
void launchVertexIdentities(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// Adds what must be zero before a cycle to `copies`: the counters, the bins' counts, the boxes of
// the bodies, the table of vertices, and their identities if fans are certified. It also makes the
// bins that the last cycle sized the current ones. The kernel that copies from the host does this
// too, because another kernel would delay the cycle.
void addClearing(const CycleArrays& cycle, const CycleShape& shape, HostCopies& copies);

// transform: brings the vertices into the scene frame and bounds the bodies. It also finds each
// vertex's nearest prototype, which stage assign needs. Reads scene.received; writes scene.posed
// and scene.body_boxes.
void launchTransform(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// transform: gives tile entries the ids of their vertices, except entries that lie beside the
// partition. Reads scene.vertex_id and scene.fan_certified; writes tiles.ids. Runs on a branch,
// directly after launchVertexIdentities.
void launchEntryIds(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// assign: culls triangles that are not finite or outside every partner's box. Puts the others into
// their tiles, and the tiles into their clusters' bins; oversized triangles go to a list of their
// own. Takes samples for the clusters. Reads scene.posed and scene.slot_numbers; writes
// tiles.entries, tiles.bounds, tiles.states, tiles.bin_entries, tiles.lists, tiles.oversized and
// clusters.samples. Directly after launchTransform.
void launchAssign(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// assign, for the next cycle: computes how much room each bin is to have. Reads tiles.counts;
// writes tiles.next_bins.
void launchAssignBins(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// sort: projects each cluster's tiles onto the cluster's frame, sorts them along its first axis,
// and cuts the sweep into work units. Reads tiles.bin_entries; writes the arrays of `sweep`.
void launchSort(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// sort, for the next cycle: computes the principal axes and extents of each cluster. Reads
// sweep.moments; writes sweep.frames.
void launchSortFrames(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// cluster, for the next cycle: makes shape.refinements steps of fuzzy c-means on this cycle's
// samples, and the prototypes' lists of neighbours. Reads clusters.samples; writes the other arrays
// of `clusters`.
void launchCluster(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);
// Makes only the lists of neighbours.
void launchClusterLists(const CycleArrays& cycle, cudaStream_t stream);

// cluster, before a cycle: makes new prototypes from the first `samples` of clusters.samples.
// Prototypes stay as they are if all of these samples are empty.
void launchClusterSeeds(const CycleArrays& cycle, std::uint32_t samples, cudaStream_t stream);
// Resets what a cycle knows of its clusters, for new prototypes: lists, frames and bins.
void launchClusterStart(const CycleArrays& cycle, cudaStream_t stream);

// sweep: finds the pairs of tiles whose intervals, packed boxes and boxes intersect, each in one
// cluster. Reads the arrays of `sweep`; writes sweep.tile_pairs and sweep.dense_pairs. Directly
// after launchSort.
void launchSweep(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// sweep: does the same by brute force, instead of launchSort and launchSweep, where
// CycleArrays::usesBruteForce(): tests every tile against every other. Directly after launchAssign.
void launchBruteForceTiles(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// sweep, second part: tests these pairs of tiles triangle by triangle, and the tiles of bodies that
// may have contacts with themselves. Pairs of triangles whose boxes intersect are filtered by
// planes. A pair that is left is a contact if float32 is certain of it, and else a candidate. Reads
// both lists and the arrays of `tiles`; writes contacts.candidates and contacts.contacts, and with
// shape.leaves_few also contacts.open. If there are several passes, each group of 32 pairs of
// triangles belongs to one of them. Directly after launchSweep.
void launchSweepTriangles(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// oversized: does the same for the pairs with an oversized triangle. Reads the arrays of `tiles`;
// writes the same lists. If there are several passes, each of its oversizedBlocks() blocks belongs
// to one of them.
void launchOversized(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);
std::uint32_t oversizedBlocks(const CycleArrays& cycle);

// narrow_phase: makes the verdicts on the candidates; the last block copies the counters to the
// host. Reads contacts.candidates; writes contacts.contacts and separations_m.
void launchNarrowPhase(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// nearest: finds the nearest triangles of each of nearest.pairs at the present moment, and writes
// them to the host. Reads scene.posed and the tiles; starts from nearest.last, if there is
// something. Runs on a branch after launchTransform.
void launchNearest(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// Prepares another pass: drops the candidates, and before the `first` pass the contacts.
void launchRestart(const CycleArrays& cycle, bool first, cudaStream_t stream);

}  // namespace deformable_contact_monitor
