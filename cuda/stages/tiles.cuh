// Declares what the device builds when a scene is laid out, before the stages: the tiles of
// triangles, and the rings of triangles around vertices (core/cpu/fans.h).
#pragma once

#include <cuda_runtime.h>

#include "cuda/memory/cycle_arrays.cuh"
#include "cuda/memory/device_buffer.cuh"

namespace deformable_contact_monitor {

// The bodies whose tiles must be made: all from `first` on. `first_triangle` and `first_tile` are
// those of that body.
struct UntiledBodies {
  BodyIndex first;
  std::uint32_t first_triangle, first_tile;
  std::uint32_t most_triangles;  // the greatest number of triangles of a body
};

// Groups the triangles of these bodies into tiles, by their present positions. Any grouping gives
// correct results. Reads scene.bodies, scene.corners, scene.received and the blocks; writes
// scene.tile_body, scene.slot_numbers and scene.slot_neighbours, and as intermediate results
// scene.body_ranges, scene.body_boxes and the keys. `scratch` grows as needed. Throws CudaError.
void launchTiles(const SceneArrays& scene, const UntiledBodies& bodies,
                 DeviceBuffer<unsigned char>& scratch, cudaStream_t stream);

// Finds the vertex rings of `vertices` vertices. Reads scene.corners, scene.bodies and the blocks;
// writes scene.fan_begin and scene.fan_ring. `scratch` grows as needed. Throws CudaError.
void launchFanRings(const SceneArrays& scene, std::uint32_t vertices,
                    DeviceBuffer<unsigned char>& scratch, cudaStream_t stream);

}  // namespace deformable_contact_monitor
