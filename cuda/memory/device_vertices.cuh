// Copies vertices that the user keeps on the device (Scene::setDeviceVertices).
#pragma once

#include "core/scene.h"
#include "cuda/device/stream.cuh"

namespace deformable_contact_monitor {

// Checks that the current device, whose number is `device`, can copy the body's device_vertices and
// wait for their stream. Throws std::invalid_argument, naming the body, if it cannot, and CudaError
// if CUDA fails.
void requireReadable(const Body& body, int device);

class DeviceVertexCopier {
 public:
  // Copies a body's device_vertices in `stream`, ordered after the work that is now in their own
  // stream. requireReadable() must have accepted the body. Throws std::invalid_argument, naming the
  // body, if their stream belongs to another device.
  void copy(const Body& body, float* to, cudaStream_t stream);

 private:
  CudaEvent written_;
};

}  // namespace deformable_contact_monitor
