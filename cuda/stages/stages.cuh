// The stages of a cycle, as launches into a stream. None allocates or waits for the device. Some
// must stand right behind another, for they launch early: see cuda/launch.cuh.
#pragma once

#include <cuda_runtime.h>

#include "cuda/device/launch.cuh"
#include "cuda/memory/cycle_view.cuh"

namespace deformable_contact_monitor {

// Starts a cycle: clears its counters; brings the vertices into the scene frame, bounds the bodies,
// and finds each vertex's nearest prototype.
void launchPose(const CycleView& cycle, const DeviceTraits& device, cudaStream_t stream);

// Vertex identities, for bodies with self contact. Independent of the other stages up to the sort.
void launchIdentify(const CycleView& cycle, cudaStream_t stream);

// Right behind the pose. Drops triangles that are not finite or outside every partner's box; puts
// the others into their clusters' bins, or on the large list; takes samples.
void launchAssign(const CycleView& cycle, const DeviceTraits& device, cudaStream_t stream);

// Projects each cluster's members, sorts them along its first axis, and cuts the sweep into units.
void launchSort(const CycleView& cycle, cudaStream_t stream);

// Right behind the sort. Sweeps the clusters: pairs that boxes, owners and planes leave become
// candidates.
void launchSweep(const CycleView& cycle, const DeviceTraits& device, cudaStream_t stream);

// Likewise for the pairs with a large triangle. Independent of the sweep.
// In several passes each of its blocks has its turn in one.
std::uint32_t largeBlocks(const CycleView& cycle);
void launchLarge(const CycleView& cycle, cudaStream_t stream);

// Judges the candidates; the last block leaves the counters on the host.
void launchJudge(const CycleView& cycle, const DeviceTraits& device, cudaStream_t stream);

// Before another pass over the work units: drops the candidates; before the `first`, the contacts.
void launchRestart(const CycleView& cycle, bool first, cudaStream_t stream);

// For the next cycle, from what this one saw. Frames need the sort; the others, the assignment.
void launchMovePrototypes(const CycleView& cycle, cudaStream_t stream);
void launchListNeighbours(const CycleView& cycle, cudaStream_t stream);
void launchSizeBins(const CycleView& cycle, cudaStream_t stream);
void launchFrames(const CycleView& cycle, cudaStream_t stream);

// Sorts the contacts' keys, of which there are counters->contacts but never more than `capacity`
// looked at; what lies beyond them is filled with ones. With separations iff `separations_out`.
// A null `scratch` asks for the bytes it needs.
void sortContacts(const CycleView& cycle, std::uint32_t capacity, unsigned index_bits,
                  std::uint64_t* keys_out, float* separations_out, void* scratch,
                  std::size_t& scratch_bytes, cudaStream_t stream);

}  // namespace deformable_contact_monitor
