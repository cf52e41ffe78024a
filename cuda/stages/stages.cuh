// The stages of a cycle, as launches into a stream. None allocates or waits for the device. What of
// them must stand right behind what is said in CycleGraph's list of steps.
#pragma once

#include <cuda_runtime.h>

#include "cuda/device/launch.cuh"
#include "cuda/memory/cycle_arrays.cuh"
#include "cuda/memory/host_copy.cuh"

namespace deformable_contact_monitor {

// What a cycle consists of; with the arrays, all that a recorded graph depends on.
struct CycleShape {
  DeviceTraits device;
  bool identify = false;    // some body has contacts with itself
  int refinements = 0;      // of the prototypes, for the next cycle
  bool swept = false;       // motion: each launch then works on both states
  bool sharers = false;     // triangles that share vertices may be contacts
  bool pads = false;        // in swept motion: some body has one
  bool fans = false;        // certified ones settle pairs of triangles that share vertices
  bool leaves_few = false;  // CycleParams::leaves_few

  bool operator==(const CycleShape& o) const {
    return device == o.device && identify == o.identify && refinements == o.refinements &&
           swept == o.swept && sharers == o.sharers && pads == o.pads && fans == o.fans &&
           leaves_few == o.leaves_few;
  }
};

// One of the launches below.
using Launch = void (*)(const CycleArrays&, const CycleShape&, cudaStream_t);

// pose: finds vertices that are equal as received, where some body has contacts with itself, and
// those whose fans are certified: reads scene.received; writes scene.vertex_id and
// scene.fan_certified. At one moment, of one of several shares, but for vertices that lie beside
// it.
void launchPoseIdentities(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// Ahead of a cycle: what it adds to becomes zero, that is, the counters, the members' counts, the
// boxes of the bodies and the table of vertices; and the bins that the last cycle sized are taken
// over. Beside what the host sends: a kernel of its own would be waited for.
void addClearing(const CycleArrays& cycle, const CycleShape& shape, HostCopies& copies);

// pose: brings the vertices into the scene frame and bounds the bodies, and finds each vertex's
// nearest prototype: reads scene.received; writes scene.posed, scene.body_boxes.
void launchPose(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// pose: gives triangles the ids of their vertices, but for those that lie beside the share: reads
// scene.vertex_id and scene.fan_certified; writes members.ids. On a stream of its own right behind
// launchPoseIdentities.
void launchPoseIds(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// assign: drops triangles that are not finite or outside every partner's box; puts the others into
// their tiles, and these into their clusters' bins, or on the large list; takes samples. Reads
// scene.posed, scene.corners; writes members.members, members.boxes, members.tiles,
// members.entries, members.lists, clusters.samples. Right behind launchPose.
void launchAssign(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// assign, for the next cycle: how much room each bin is to have. Reads members.counts; writes
// members.next_bins.
void launchAssignBins(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// sort: projects each cluster's tiles onto the cluster's frame, sorts them along its first axis,
// and cuts the sweep into work units. Reads members.entries; writes the arrays of `sweep`.
void launchSort(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// sort, for the next cycle: principal axes and extents of each cluster, as they are now. Reads
// sweep.moments; writes sweep.frames.
void launchSortFrames(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// cluster, for the next cycle: shape.refinements steps of fuzzy c-means on this cycle's samples,
// and the prototypes' lists of neighbours. Reads clusters.samples; writes the others of `clusters`.
void launchCluster(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);
// The lists alone.
void launchClusterLists(const CycleArrays& cycle, cudaStream_t stream);

// cluster, ahead of a cycle: new prototypes, from the first `samples` of clusters.samples; where
// none of those is a sample, they stay what they are.
void launchClusterSeeds(const CycleArrays& cycle, std::uint32_t samples, cudaStream_t stream);
// With new prototypes, the rest of what a cycle knows of its clusters: lists, frames, bins.
void launchClusterStart(const CycleArrays& cycle, cudaStream_t stream);

// sweep: pairs of tiles whose intervals, packed boxes and boxes intersect, and which this cluster
// owns. Reads the arrays of `sweep`; writes sweep.tile_pairs and sweep.crowded_pairs. Right behind
// launchSort.
void launchSweep(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// The same in place of launchSort and launchSweep where CycleArrays::together(): every tile against
// every other. Right behind launchAssign.
void launchTogether(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// sweep: pairs of triangles of these tiles, and of tiles of bodies that have contacts with
// themselves, whose boxes intersect are filtered by planes; the rest are contacts where float32 is
// certain of it, candidates where it is not. Reads both lists and the arrays of `members`; writes
// contacts.candidates and contacts.contacts, and where it leaves few also contacts.open. In several
// passes each 32 pairs of triangles have their turn in one. Right behind launchSweep or
// launchTogether.
void launchPairs(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// large: the same for the pairs with a triangle of the large list. Reads the arrays of `members`;
// writes the same. In several passes each of its largeBlocks() blocks has its turn in one.
void launchLarge(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);
std::uint32_t largeBlocks(const CycleArrays& cycle);

// judge: verdicts on the candidates; the last block leaves the counters on the host. Reads
// contacts.candidates; writes contacts.contacts and separations_m.
void launchJudge(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

// Before another pass over the work units: drops the candidates; before the `first`, the contacts.
void launchRestart(const CycleArrays& cycle, bool first, cudaStream_t stream);

}  // namespace deformable_contact_monitor
