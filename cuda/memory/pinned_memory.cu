#include <cuda_runtime.h>

#include <cstddef>

#include "cuda/device/check.cuh"
#include "cuda/memory/pinned_memory.cuh"

namespace deformable_contact_monitor {
namespace {

// Its pages are aligned to more than anybody asks for.
class PinnedMemory : public std::pmr::memory_resource {
  void* do_allocate(std::size_t bytes, std::size_t) override {
    void* memory = nullptr;
    checkCuda(cudaHostAlloc(&memory, bytes, cudaHostAllocMapped | cudaHostAllocPortable),
              "cudaHostAlloc");
    return memory;
  }
  void do_deallocate(void* memory, std::size_t, std::size_t) override { cudaFreeHost(memory); }
  bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override {
    return this == &other;
  }
};

}  // namespace

std::pmr::memory_resource& pinnedMemory() {
  static auto* const memory = new PinnedMemory;  // lists may end after static objects do
  return *memory;
}

}  // namespace deformable_contact_monitor
