// Memory of a device, taken and given back in the order of a stream.
#pragma once

#include <cuda_runtime.h>

#include <cstddef>

namespace deformable_contact_monitor {

// What a process has of one device's memory. Any thread.
class DevicePool {
 public:
  // The current device's: the same one always, which outlives everything.
  static DevicePool& ofCurrentDevice();

  explicit DevicePool(int device);
  DevicePool(const DevicePool&) = delete;
  DevicePool& operator=(const DevicePool&) = delete;

  // For what comes behind this in the stream. Throws CudaError where there is no more. The first
  // 128 MiB that are in use at a time were taken when the pool was made; beyond, and on devices
  // that have no pools, to allocate takes longer than a cycle.
  void* take(std::size_t bytes, cudaStream_t stream);

  // Others may have it once what is in the stream is over.
  void giveBack(void* memory, cudaStream_t stream);

 private:
  void reserve();

  cudaMemPool_t pool_ = nullptr;  // none: memory comes piece by piece
};

}  // namespace deformable_contact_monitor
