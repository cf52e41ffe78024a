// The triangles of a scene by tiles, for stage assign.
#pragma once

#include <cuda_runtime.h>

#include "cuda/memory/device_buffer.cuh"
#include "cuda/memory/scene_arrays.cuh"

namespace deformable_contact_monitor {

// Bodies whose tiles are to be made: from that one on, with its first triangle and tile.
struct UngroupedBodies {
  BodyIndex first;
  std::uint32_t first_triangle, first_tile;
  std::uint32_t most_triangles;  // of a body
};

// Any grouping is right; this is by where the bodies' triangles are by now. Reads scene.bodies,
// scene.corners, scene.received and the blocks; writes scene.tile_body and scene.slot_triangle,
// and scene.body_ranges, scene.body_boxes and the keys on the way. `scratch`: grows as is needed.
// Throws CudaError.
void launchGroup(const SceneArrays& scene, const UngroupedBodies& bodies,
                 DeviceBuffer<unsigned char>& scratch, cudaStream_t stream);

}  // namespace deformable_contact_monitor
