// Which devices the detector runs on.
#pragma once

#include <cuda_runtime.h>

#include <string>

#include "cuda/device/check.cuh"

namespace deformable_contact_monitor {

// Makes the device with that number the current one. Throws CudaError, one line, where there is no
// driver, no such device, or one older than compute capability 7.5.
inline void requireUsable(int device) {
  int count = 0;
  checkCuda(cudaGetDeviceCount(&count), "no CUDA device can be used");
  if (device < 0 || device >= count) {
    throw CudaError(BackendFault::kUnavailable, "there is no CUDA device " +
                                                    std::to_string(device) + "; there are " +
                                                    std::to_string(count));
  }
  checkCuda(cudaSetDevice(device), "cudaSetDevice");
  int major = 0, minor = 0;
  checkCuda(cudaDeviceGetAttribute(&major, cudaDevAttrComputeCapabilityMajor, device),
            "cudaDeviceGetAttribute");
  checkCuda(cudaDeviceGetAttribute(&minor, cudaDevAttrComputeCapabilityMinor, device),
            "cudaDeviceGetAttribute");
  constexpr int kLeastCapability = 75;
  if (10 * major + minor < kLeastCapability) {
    throw CudaError(BackendFault::kUnavailable,
                    "CUDA device " + std::to_string(device) + " is of compute capability " +
                        std::to_string(major) + "." + std::to_string(minor) +
                        "; 7.5 or newer is needed");
  }
}

}  // namespace deformable_contact_monitor
