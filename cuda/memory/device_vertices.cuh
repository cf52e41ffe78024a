// Vertices that somebody else keeps on the device (Scene::setDeviceVertices).
#pragma once

#include "core/scene.h"
#include "cuda/device/stream.cuh"

namespace deformable_contact_monitor {

// Throws std::invalid_argument, naming the body, unless its device_vertices are where the current
// device, `device`, can copy them from, and their stream is one that it can wait for. CudaError
// where CUDA fails.
void requireReadable(const Body& body, int device);

class DeviceVertexCopier {
 public:
  // Copies device_vertices of a body that is readable: in `stream`, behind what is in their own one
  // by now. Throws std::invalid_argument, naming the body, if that is another device's.
  void copy(const Body& body, float* to, cudaStream_t stream);

 private:
  CudaEvent written_;
};

}  // namespace deformable_contact_monitor
