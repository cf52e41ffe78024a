// Owns arrays in device memory and in page-locked host memory.
#pragma once

#include <cuda_runtime.h>

#include <cstddef>
#include <utility>

#include "cuda/device/check.cuh"
#include "cuda/memory/device_pool.cuh"
#include "cuda/memory/pinned_memory.cuh"

namespace deformable_contact_monitor {

// Owns an array on the current device. It belongs to one stream, which must outlive it. Work in
// other streams that uses the array must be ordered by events, after its allocation and before its
// release.
template <class T>
class DeviceBuffer {
 public:
  DeviceBuffer() = default;
  DeviceBuffer(std::size_t size, cudaStream_t stream) { grow(size, stream); }
  DeviceBuffer(const DeviceBuffer&) = delete;
  DeviceBuffer& operator=(const DeviceBuffer&) = delete;
  ~DeviceBuffer() { release(); }
  void swap(DeviceBuffer& o) {
    std::swap(data_, o.data_);
    std::swap(size_, o.size_);
    std::swap(pool_, o.pool_);
    std::swap(stream_, o.stream_);
  }

  T* data() { return data_; }
  const T* data() const { return data_; }
  std::size_t size() const { return size_; }
  std::size_t bytes() const { return size_ * sizeof(T); }

  // Grows to at least `size` elements. If it grows, the contents are lost and the address changes.
  // Returns whether it grew.
  bool grow(std::size_t size, cudaStream_t stream) {
    if (size <= size_) return false;
    release();
    pool_ = &DevicePool::ofCurrentDevice();
    stream_ = stream;
    data_ = static_cast<T*>(pool_->take(size * sizeof(T), stream));
    size_ = size;
    return true;
  }

  void upload(const T* from, std::size_t count, cudaStream_t stream, std::size_t first = 0) {
    if (count == 0) return;
    checkCuda(
        cudaMemcpyAsync(data_ + first, from, count * sizeof(T), cudaMemcpyHostToDevice, stream),
        "cudaMemcpyAsync to the device");
  }
  void download(T* to, std::size_t count, cudaStream_t stream) const {
    if (count == 0) return;
    checkCuda(cudaMemcpyAsync(to, data_, count * sizeof(T), cudaMemcpyDeviceToHost, stream),
              "cudaMemcpyAsync to the host");
  }

 private:
  void release() {
    if (data_ != nullptr) pool_->giveBack(data_, stream_);
    data_ = nullptr;
    size_ = 0;
  }

  T* data_ = nullptr;
  std::size_t size_ = 0;
  DevicePool* pool_ = nullptr;
  cudaStream_t stream_ = nullptr;
};

// Owns an array in page-locked host memory. Copies from and to it run while the host goes on, and
// kernels may access it. It must not grow or end while the device uses it.
template <class T>
class PinnedBuffer {
 public:
  PinnedBuffer() = default;
  explicit PinnedBuffer(std::size_t size) { grow(size); }
  PinnedBuffer(const PinnedBuffer&) = delete;
  PinnedBuffer& operator=(const PinnedBuffer&) = delete;
  ~PinnedBuffer() { release(); }

  T* data() { return data_; }
  const T* data() const { return data_; }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  std::size_t size() const { return size_; }

  // Grows to at least `size` elements. If it grows, the contents are lost.
  void grow(std::size_t size) {
    if (size <= size_) return;
    release();
    data_ = static_cast<T*>(pinnedMemory().allocate(size * sizeof(T)));
    size_ = size;
  }

 private:
  void release() {
    if (data_ != nullptr) pinnedMemory().deallocate(data_, size_ * sizeof(T));
    data_ = nullptr;
    size_ = 0;
  }

  T* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace deformable_contact_monitor
