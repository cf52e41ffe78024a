// How many blocks a kernel takes, and kernels that are launched before the one ahead has ended.
#pragma once

#include <cuda_runtime.h>

#include <cstddef>

#include "cuda/device/check.cuh"

// Recorded graphs know of early launches from CUDA 12.3 on. Below, every launch is a plain one.
constexpr int kEarlyLaunchesFrom = 12030;
#define DCM_EARLY_LAUNCHES (CUDART_VERSION >= 12030)

namespace deformable_contact_monitor {

struct DeviceTraits {
  unsigned multiprocessors = 1;
  bool overlaps_launches = false;  // programmatic dependent launch

  // Whether a driver of that version (as cudaDriverGetVersion() says it, which may be older than
  // the runtime) records early launches for devices of that compute capability.
  static bool overlapsLaunches(int driver_version, int capability_major) {
    return DCM_EARLY_LAUNCHES && driver_version >= kEarlyLaunchesFrom && capability_major >= 9;
  }

  // Of the device with that number; throws CudaError.
  static DeviceTraits of(int device) {
    const auto get = [device](cudaDeviceAttr attribute) {
      int value = 0;
      checkCuda(cudaDeviceGetAttribute(&value, attribute, device), "cudaDeviceGetAttribute");
      return value;
    };
    DeviceTraits traits;
    traits.multiprocessors = static_cast<unsigned>(get(cudaDevAttrMultiProcessorCount));
    int driver = 0;
    checkCuda(cudaDriverGetVersion(&driver), "cudaDriverGetVersion");
    traits.overlaps_launches = overlapsLaunches(driver, get(cudaDevAttrComputeCapabilityMajor));
    return traits;
  }
  bool operator==(const DeviceTraits& o) const {
    return multiprocessors == o.multiprocessors && overlaps_launches == o.overlaps_launches;
  }
};

// How many blocks of a kernel the device holds at once.
template <class Kernel>
unsigned blocksInOneWave(Kernel kernel, unsigned threads, std::size_t shared_bytes,
                         const DeviceTraits& device) {
  int each = 0;
  checkCuda(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&each, kernel, static_cast<int>(threads),
                                                          shared_bytes),
            "cudaOccupancyMaxActiveBlocksPerMultiprocessor");
  return device.multiprocessors * static_cast<unsigned>(each > 0 ? each : 1);
}

// Launches a kernel that begins with awaitKernelAhead(), right behind another kernel of the stream.
// The device may start it once all blocks of that one have ended or called letNextStart().
template <class Argument>
void launchEarly(void (*kernel)(Argument), dim3 blocks, unsigned threads, std::size_t shared_bytes,
                 const DeviceTraits& device, cudaStream_t stream, const Argument& argument) {
#if DCM_EARLY_LAUNCHES
  // Code for older devices, which newer ones may run too, does not await anything.
  cudaFuncAttributes code{};
  checkCuda(cudaFuncGetAttributes(&code, kernel), "cudaFuncGetAttributes");
  const bool awaits = code.ptxVersion >= 90;
  cudaLaunchAttribute early{};
  early.id = cudaLaunchAttributeProgrammaticStreamSerialization;
  early.val.programmaticStreamSerializationAllowed = 1;
  cudaLaunchConfig_t config{};
  config.gridDim = blocks;
  config.blockDim = dim3(threads);
  config.dynamicSmemBytes = shared_bytes;
  config.stream = stream;
  config.attrs = &early;
  config.numAttrs = device.overlaps_launches && awaits ? 1 : 0;
  checkCuda(cudaLaunchKernelEx(&config, kernel, argument), "cudaLaunchKernelEx");
#else
  static_cast<void>(device);
  void* arguments[] = {const_cast<Argument*>(&argument)};
  checkCuda(cudaLaunchKernel(reinterpret_cast<const void*>(kernel), blocks, dim3(threads),
                             arguments, shared_bytes, stream),
            "cudaLaunchKernel");
#endif
}

// Until the kernel ahead has ended and all that it wrote can be read; before anything else.
__device__ inline void awaitKernelAhead() {
#if DCM_EARLY_LAUNCHES && __CUDA_ARCH__ >= 900
  cudaGridDependencySynchronize();
#endif
}

// In a kernel that was itself launched early, only after awaitKernelAhead(): else what comes next
// could overtake the kernel before this one.
__device__ inline void letNextStart() {
#if DCM_EARLY_LAUNCHES && __CUDA_ARCH__ >= 900
  cudaTriggerProgrammaticLaunchCompletion();
#endif
}

}  // namespace deformable_contact_monitor
