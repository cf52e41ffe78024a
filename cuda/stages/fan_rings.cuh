// The rings of triangles around the vertices of a scene that was laid out
// (core/common/vertex_fans.h).
#pragma once

#include <cuda_runtime.h>

#include "cuda/memory/device_buffer.cuh"
#include "cuda/memory/scene_arrays.cuh"

namespace deformable_contact_monitor {

// Reads scene.corners, scene.bodies and the blocks; writes scene.fan_begin and scene.fan_ring, of
// `vertices` vertices. `scratch`: grows as is needed. Throws CudaError.
void launchFanRings(const SceneArrays& scene, std::uint32_t vertices,
                    DeviceBuffer<unsigned char>& scratch, cudaStream_t stream);

}  // namespace deformable_contact_monitor
