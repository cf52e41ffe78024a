// Stage output: the geometry of sorted contacts.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>

#include "core/pair_geometry.h"
#include "cuda/memory/cycle_arrays.cuh"

namespace deformable_contact_monitor {

// Contacts on the device, by keys as in ContactArrays::contacts.
struct SortedContacts {
  const std::uint64_t* keys;
  const float* separations_m;  // null: all of them intersect
  std::uint32_t most;          // of them, if there are so many
};

// Behind what is in the stream: fills in the geometry of each contact. Reads
// scene.corners and scene.posed.
void launchGeometry(const CycleArrays& cycle, const SortedContacts& sorted, PairGeometry* geometry,
                    cudaStream_t stream);

}  // namespace deformable_contact_monitor
