// The launches of a check, in their order.
#pragma once

#include <cuda_runtime.h>

#include "cuda/device/launch.cuh"
#include "cuda/states/state_arrays.cuh"

namespace deformable_contact_monitor {

// Reads the corners of all bodies, and makes the boxes of tiles, regions and bodies.
void launchStateBodies(const StateArrays& arrays, cudaStream_t stream);

// Clears what a launch has found.
void launchStateStart(const StateArrays& arrays, cudaStream_t stream);

// Clears the counters and the choice of nearest triangles alone, to search again.
void launchStateRestart(const StateArrays& arrays, cudaStream_t stream);

// Notes the states whose poses take vertices beyond float32.
void launchStateLeaves(const StateArrays& arrays, cudaStream_t stream);

// For nearest pairs: finds for each state a distance that is not less than the least one, and looks
// at the triangles of the tiles that gave it.
void launchStateBounds(const StateArrays& arrays, cudaStream_t stream);

// Lists the pairs of tiles whose triangles matter. `searches_at_once`: looks at their triangles
// too, and lists nothing; for launches whose list has no room.
void launchStateTiles(const StateArrays& arrays, bool searches_at_once, cudaStream_t stream);

// Looks at the triangles of the listed tiles.
void launchStateTriangles(const StateArrays& arrays, const DeviceTraits& device,
                          cudaStream_t stream);

// Chooses the nearest triangles of each state among the hits, and writes `found`.
void launchStateNearest(const StateArrays& arrays, const DeviceTraits& device, cudaStream_t stream);

}  // namespace deformable_contact_monitor
