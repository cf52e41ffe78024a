#include <cuda_runtime.h>

#include <cstddef>
#include <mutex>
#include <set>

#include "cuda/device/check.cuh"
#include "cuda/memory/pinned_memory.cuh"
#include "cuda/memory/reserved_memory.h"

namespace deformable_contact_monitor {
namespace {

// For as many as a scene of some 100 000 triangles needs in a process.
constexpr std::size_t kReservedBytes = std::size_t{16} << 20;

// Its pages are aligned to more than anybody asks for.
class PinnedMemory : public std::pmr::memory_resource {
 public:
  PinnedMemory() {
    try {
      reserved_ = ReservedMemory(pinned(kReservedBytes), kReservedBytes);
    } catch (const CudaError&) {
      cudaGetLastError();  // it does without
    }
  }

 private:
  static void* pinned(std::size_t bytes) {
    void* memory = nullptr;
    checkCuda(cudaHostAlloc(&memory, bytes, cudaHostAllocMapped | cudaHostAllocPortable),
              "cudaHostAlloc");
    return memory;
  }
  void* do_allocate(std::size_t bytes, std::size_t) override {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (void* const piece = reserved_.take(bytes)) return piece;
    }
    return pinned(bytes);
  }
  void do_deallocate(void* memory, std::size_t, std::size_t) override {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (reserved_.giveBack(memory)) return;
    }
    cudaFreeHost(memory);
  }
  bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override {
    return this == &other;
  }

  std::mutex mutex_;
  ReservedMemory reserved_;
};

class LentMemory : public std::pmr::memory_resource {
  void* do_allocate(std::size_t bytes, std::size_t alignment) override {
    try {
      return pinnedMemory().allocate(bytes, alignment);
    } catch (const CudaError&) {
      void* const memory = plain_.allocate(bytes, alignment);
      const std::lock_guard<std::mutex> lock(mutex_);
      in_plain_.insert(memory);
      return memory;
    }
  }
  void do_deallocate(void* memory, std::size_t bytes, std::size_t alignment) override {
    if (isPlain(memory)) {
      plain_.deallocate(memory, bytes, alignment);
    } else {
      pinnedMemory().deallocate(memory, bytes, alignment);
    }
  }
  bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override {
    return this == &other;
  }
  bool isPlain(void* memory) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return in_plain_.erase(memory) > 0;
  }

  std::pmr::memory_resource& plain_ = *std::pmr::new_delete_resource();
  std::mutex mutex_;
  std::set<void*> in_plain_;
};

}  // namespace

std::pmr::memory_resource& pinnedMemory() {
  static auto* const memory = new PinnedMemory;  // lists may end after static objects do
  return *memory;
}

std::pmr::memory_resource& lentMemory() {
  static auto* const memory = new LentMemory;
  return *memory;
}

const void* reachedAt(const void* memory) {
  cudaPointerAttributes attributes{};
  const bool known = cudaPointerGetAttributes(&attributes, memory) == cudaSuccess;
  if (!known) cudaGetLastError();  // or the next check of it would report this
  return known && attributes.type == cudaMemoryTypeHost ? attributes.devicePointer : nullptr;
}

}  // namespace deformable_contact_monitor
