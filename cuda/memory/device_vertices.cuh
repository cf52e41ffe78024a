// Reads vertices that the user keeps on a device (Scene::setDeviceVertices()).
#pragma once

#include <cuda_runtime.h>

#include "core/scene.h"
#include "cuda/device/stream.cuh"

namespace deformable_contact_monitor {

// Belongs to one detector or checker; for one thread at a time. Errors that are the user's are
// std::invalid_argument with the body's name, and those of CUDA are CudaError.
class DeviceVerticesReader {
 public:
  // Checks that the current device, whose number is `device`, can copy the body's device_vertices
  // and wait for their stream. Throws if it cannot.
  static void requireReadable(const Body& body, int device);

  // Copies a body's device_vertices in `stream`, ordered after the work that is now in their own
  // stream. requireReadable() must have accepted the body. Throws if their stream belongs to
  // another device.
  void copy(const Body& body, float* to, cudaStream_t stream);

 private:
  CudaEvent written_;  // by the owner of the vertices
};

}  // namespace deformable_contact_monitor
