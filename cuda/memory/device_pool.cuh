// Allocates and frees device memory in the order of a stream.
#pragma once

#include <cuda_runtime.h>

#include <cstddef>
#include <cstdint>

namespace deformable_contact_monitor {

// The memory that this process holds on one device. All functions may be called by any thread.
class DevicePool {
 public:
  // Returns the pool of the current device. It is the same one in all calls and is never destroyed.
  static DevicePool& ofCurrentDevice();

  explicit DevicePool(int device);
  DevicePool(const DevicePool&) = delete;
  DevicePool& operator=(const DevicePool&) = delete;

  // Allocates for work that is enqueued in the stream after this call. Throws CudaError if the
  // memory is exhausted. The first 96 MiB in use at a time were reserved when the pool was made;
  // allocating more than that, or on devices that have no pools, takes longer than a cycle.
  void* take(std::size_t bytes, cudaStream_t stream);

  // Frees the memory once the work in the stream is over.
  void giveBack(void* memory, cudaStream_t stream);

  // Returns how much memory the pool holds, the reserve included [bytes]; 0 on devices that have no
  // pools.
  std::uint64_t bytes() const;

 private:
  void reserve();

  cudaMemPool_t pool_ = nullptr;  // null if the device has no pools: then cudaMalloc is used
};

}  // namespace deformable_contact_monitor
