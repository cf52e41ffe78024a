// Launches kernels. Programmatic dependent launch lets a kernel start before the previous one in
// its stream has ended, which hides the latency of the launch.
#pragma once

#include <cuda_runtime.h>

#include <cstddef>

#include "cuda/device/check.cuh"

// CUDA graphs support programmatic dependent launch from CUDA 12.3 on. Older versions use plain
// launches.
constexpr int kDependentLaunchesFrom = 12030;
#define DCM_DEPENDENT_LAUNCHES (CUDART_VERSION >= 12030)

namespace deformable_contact_monitor {

struct DeviceTraits {
  unsigned multiprocessors = 1;
  bool dependent_launches = false;  // programmatic dependent launch

  // Returns whether a driver of that version (from cudaDriverGetVersion(), and perhaps older than
  // the runtime) records dependent launches for devices of that compute capability.
  static bool supportsDependentLaunches(int driver_version, int capability_major) {
    return DCM_DEPENDENT_LAUNCHES && driver_version >= kDependentLaunchesFrom &&
           capability_major >= 9;
  }

  // Returns the traits of the device with that number. Throws CudaError.
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
    traits.dependent_launches =
        supportsDependentLaunches(driver, get(cudaDevAttrComputeCapabilityMajor));
    return traits;
  }
  bool operator==(const DeviceTraits& o) const {
    return multiprocessors == o.multiprocessors && dependent_launches == o.dependent_launches;
  }
};

// Returns how many blocks of a kernel the device can run at the same time.
template <class Kernel>
unsigned blocksInOneWave(Kernel kernel, unsigned threads, std::size_t shared_bytes,
                         const DeviceTraits& device) {
  int each = 0;
  checkCuda(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&each, kernel, static_cast<int>(threads),
                                                          shared_bytes),
            "cudaOccupancyMaxActiveBlocksPerMultiprocessor");
  return device.multiprocessors * static_cast<unsigned>(each > 0 ? each : 1);
}

// Launches a kernel by programmatic dependent launch. It must begin with awaitPreviousKernel(), and
// directly follow another kernel in the stream. The device may start it once all blocks of that
// kernel have ended or called letNextKernelStart().
template <class Argument>
void launchDependent(void (*kernel)(Argument), dim3 blocks, unsigned threads,
                     std::size_t shared_bytes, const DeviceTraits& device, cudaStream_t stream,
                     const Argument& argument) {
#if DCM_DEPENDENT_LAUNCHES
  // Code that was compiled for older architectures may run on newer devices too, but it does not
  // wait for the previous kernel. So it must not be launched early.
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
  config.numAttrs = device.dependent_launches && awaits ? 1 : 0;
  checkCuda(cudaLaunchKernelEx(&config, kernel, argument), "cudaLaunchKernelEx");
#else
  static_cast<void>(device);
  void* arguments[] = {const_cast<Argument*>(&argument)};
  checkCuda(cudaLaunchKernel(reinterpret_cast<const void*>(kernel), blocks, dim3(threads),
                             arguments, shared_bytes, stream),
            "cudaLaunchKernel");
#endif
}

// Waits until the previous kernel has ended and all that it wrote can be read. Must come before the
// kernel reads any of that.
__device__ inline void awaitPreviousKernel() {
#if DCM_DEPENDENT_LAUNCHES && __CUDA_ARCH__ >= 900
  cudaGridDependencySynchronize();
#endif
}

// Lets the next kernel of the stream start. A kernel that is itself a dependent launch must call
// awaitPreviousKernel() first; else the next kernel could overtake the one before this one.
__device__ inline void letNextKernelStart() {
#if DCM_DEPENDENT_LAUNCHES && __CUDA_ARCH__ >= 900
  cudaTriggerProgrammaticLaunchCompletion();
#endif
}

}  // namespace deformable_contact_monitor
