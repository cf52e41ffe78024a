#include <cuda_runtime.h>
#include <sys/mman.h>

#include <cstdint>
#include <string>

#include "cuda/device/check.cuh"
#include "cuda/memory/pinned_pages.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20;

// For so many, from a place on that a huge page may begin at.
std::size_t mappedBytes(std::size_t bytes) { return bytes + kHugePage; }

// Returns whether kernels of every device can use the host's address of memory that is page-locked
// after its allocation.
bool canLockPages() {
  int devices = 0;
  if (cudaGetDeviceCount(&devices) != cudaSuccess) devices = 0;
  bool can = devices > 0;
  for (int device = 0; device < devices; ++device) {
    for (const cudaDeviceAttr what :
         {cudaDevAttrHostRegisterSupported, cudaDevAttrCanUseHostPointerForRegisteredMem}) {
      int has = 0;
      can = can && cudaDeviceGetAttribute(&has, what, device) == cudaSuccess && has != 0;
    }
  }
  cudaGetLastError();  // of a question that a driver does not know
  return can;
}

}  // namespace

PinnedPages::PinnedPages(std::size_t bytes) {
  static const bool can_lock = canLockPages();
  bytes_ = (bytes + kHugePage - 1) / kHugePage * kHugePage;
  if (!can_lock) {
    checkCuda(cudaHostAlloc(&data_, bytes_, cudaHostAllocMapped | cudaHostAllocPortable),
              "cudaHostAlloc");
    return;
  }
  mapped_ = mmap(nullptr, mappedBytes(bytes_), PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS,
                 -1, 0);
  if (mapped_ == MAP_FAILED) {
    throw CudaError(BackendFault::kTransient,
                    "no memory for " + std::to_string(bytes_) + " bytes to page-lock");
  }
  const std::size_t ahead = kHugePage - reinterpret_cast<std::uintptr_t>(mapped_) % kHugePage;
  data_ = static_cast<char*>(mapped_) + ahead % kHugePage;
  madvise(data_, bytes_, MADV_HUGEPAGE);  // small pages do, too
  // Excludes the pages from forks: a page that a fork shares moves at the next write, and a device
  // would go on using the old one.
  madvise(mapped_, mappedBytes(bytes_), MADV_DONTFORK);
  const cudaError_t locked =
      cudaHostRegister(data_, bytes_, cudaHostRegisterMapped | cudaHostRegisterPortable);
  if (locked != cudaSuccess) munmap(mapped_, mappedBytes(bytes_));
  checkCuda(locked, "cudaHostRegister");
}

PinnedPages::~PinnedPages() {
  if (mapped_ == nullptr) {
    cudaFreeHost(data_);
  } else {
    cudaHostUnregister(data_);
    munmap(mapped_, mappedBytes(bytes_));
  }
}

const void* reachedAt(const void* memory) {
  cudaPointerAttributes attributes{};
  const bool known = cudaPointerGetAttributes(&attributes, memory) == cudaSuccess;
  if (!known) cudaGetLastError();  // or the next check of it would report this
  return known && attributes.type == cudaMemoryTypeHost ? attributes.devicePointer : nullptr;
}

}  // namespace deformable_contact_monitor
