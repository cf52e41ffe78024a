// Owning device memory, and the check that every CUDA call goes through.
#pragma once

#include <cuda_runtime.h>

#include <cstddef>
#include <string>

#include "cuda/cuda_error.h"

namespace deformable_contact_monitor {

inline void checkCuda(cudaError_t status, const char* call) {
  if (status != cudaSuccess) {
    throw CudaError(std::string(call) + ": " + cudaGetErrorString(status));
  }
}

// A device array of fixed size, on the current device.
template <class T>
class DeviceBuffer {
 public:
  explicit DeviceBuffer(std::size_t size) : size_(size) {
    if (size > 0) checkCuda(cudaMalloc(&data_, size * sizeof(T)), "cudaMalloc");
  }
  DeviceBuffer(const DeviceBuffer&) = delete;
  DeviceBuffer& operator=(const DeviceBuffer&) = delete;
  ~DeviceBuffer() { cudaFree(data_); }

  T* data() { return data_; }
  const T* data() const { return data_; }
  std::size_t size() const { return size_; }

  void upload(const T* from, cudaStream_t stream) {
    checkCuda(cudaMemcpyAsync(data_, from, size_ * sizeof(T), cudaMemcpyHostToDevice, stream),
              "cudaMemcpyAsync to the device");
  }
  void download(T* to, cudaStream_t stream) const {
    checkCuda(cudaMemcpyAsync(to, data_, size_ * sizeof(T), cudaMemcpyDeviceToHost, stream),
              "cudaMemcpyAsync to the host");
  }

 private:
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

// A stream of its own, so that nothing waits for the default one.
class CudaStream {
 public:
  CudaStream() {
    checkCuda(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "cudaStreamCreate");
  }
  CudaStream(const CudaStream&) = delete;
  CudaStream& operator=(const CudaStream&) = delete;
  ~CudaStream() { cudaStreamDestroy(stream_); }

  cudaStream_t get() const { return stream_; }
  void synchronise() { checkCuda(cudaStreamSynchronize(stream_), "cudaStreamSynchronize"); }

 private:
  cudaStream_t stream_ = nullptr;
};

}  // namespace deformable_contact_monitor
