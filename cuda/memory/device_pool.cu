#include <cstdint>
#include <map>
#include <memory>
#include <mutex>

#include "cuda/device/stream.cuh"
#include "cuda/memory/device_pool.cuh"

namespace deformable_contact_monitor {
namespace {

// The reserve suffices for a scene of some 100 000 triangles that grows, with its arrays in two
// places at a time.
constexpr std::uint64_t kReservedBytes = std::uint64_t{96} << 20;

// Returns whether the device has memory pools. Old drivers do not know the attribute.
bool hasPools(int device) {
  int has = 0;
  const bool known =
      cudaDeviceGetAttribute(&has, cudaDevAttrMemoryPoolsSupported, device) == cudaSuccess;
  if (!known) cudaGetLastError();
  return known && has != 0;
}

}  // namespace

DevicePool& DevicePool::ofCurrentDevice() {
  static std::mutex mutex;
  static auto* const pools = new std::map<int, std::unique_ptr<DevicePool>>;
  int device = 0;
  checkCuda(cudaGetDevice(&device), "cudaGetDevice");
  const std::lock_guard<std::mutex> lock(mutex);
  std::unique_ptr<DevicePool>& pool = (*pools)[device];
  if (pool == nullptr) pool = std::make_unique<DevicePool>(device);
  return *pool;
}

DevicePool::DevicePool(int device) {
  if (!hasPools(device)) return;
  cudaMemPoolProps properties{};
  properties.allocType = cudaMemAllocationTypePinned;
  properties.location.type = cudaMemLocationTypeDevice;
  properties.location.id = device;
  checkCuda(cudaMemPoolCreate(&pool_, &properties), "cudaMemPoolCreate");
  std::uint64_t kept = kReservedBytes;
  checkCuda(cudaMemPoolSetAttribute(pool_, cudaMemPoolAttrReleaseThreshold, &kept),
            "cudaMemPoolSetAttribute");
  try {
    reserve();
  } catch (const CudaError&) {
    // The pool works without a reserve too, only slower.
  }
}

// Allocates the reserve once and frees it, so that the pool keeps it.
void DevicePool::reserve() {
  CudaStream stream;
  giveBack(take(kReservedBytes, stream.get()), stream.get());
  stream.synchronise();
}

void* DevicePool::take(std::size_t bytes, cudaStream_t stream) {
  void* memory = nullptr;
  if (pool_ == nullptr) {
    checkCuda(cudaMalloc(&memory, bytes), "cudaMalloc");
  } else {
    checkCuda(cudaMallocFromPoolAsync(&memory, bytes, pool_, stream), "cudaMallocFromPoolAsync");
  }
  return memory;
}

std::uint64_t DevicePool::bytes() const {
  std::uint64_t held = 0;
  if (pool_ != nullptr) {
    checkCuda(cudaMemPoolGetAttribute(pool_, cudaMemPoolAttrReservedMemCurrent, &held),
              "cudaMemPoolGetAttribute");
  }
  return held;
}

void DevicePool::giveBack(void* memory, cudaStream_t stream) {
  if (pool_ == nullptr) {
    cudaFree(memory);
  } else {
    cudaFreeAsync(memory, stream);
  }
}

}  // namespace deformable_contact_monitor
