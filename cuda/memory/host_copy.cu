#include <algorithm>

#include "cuda/device/check.cuh"
#include "cuda/memory/host_copy.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 256;
constexpr std::size_t kMostBlocks = 1024;

__global__ void __launch_bounds__(kThreads)
    copyKernel(const std::uint32_t* from, std::size_t count, std::uint32_t* to) {
  const std::size_t stride = gridDim.x * kThreads;
  for (std::size_t i = blockIdx.x * kThreads + threadIdx.x; i < count; i += stride) to[i] = from[i];
}

}  // namespace

void copyWordsFromHost(const std::uint32_t* from, std::size_t count, std::uint32_t* to,
                       cudaStream_t stream) {
  if (count == 0) return;
  const std::size_t blocks = std::min(kMostBlocks, (count + kThreads - 1) / kThreads);
  copyKernel<<<static_cast<unsigned>(blocks), kThreads, 0, stream>>>(from, count, to);
  checkCuda(cudaGetLastError(), "a kernel that copies from the host");
}

}  // namespace deformable_contact_monitor
