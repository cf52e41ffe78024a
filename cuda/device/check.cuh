// Checks the status of CUDA calls and whether a device can be used.
#pragma once

#include <cuda_runtime.h>

#include <string>

#include "cuda/device/cuda_error.h"

namespace deformable_contact_monitor {

// Classifies CUDA errors by how a caller can recover. After a fatal error in this process, a device
// reports one of the kSticky errors for every call. Errors that are not listed may succeed on
// another try.
inline BackendFault faultOf(cudaError_t status) {
  switch (status) {
    case cudaErrorAssert:
    case cudaErrorContextIsDestroyed:
    case cudaErrorCudartUnloading:
    case cudaErrorECCUncorrectable:
    case cudaErrorHardwareStackError:
    case cudaErrorIllegalAddress:
    case cudaErrorIllegalInstruction:
    case cudaErrorInvalidAddressSpace:
    case cudaErrorInvalidPc:
    case cudaErrorLaunchFailure:
    case cudaErrorLaunchTimeout:
    case cudaErrorMisalignedAddress:
    case cudaErrorNvlinkUncorrectable:
    case cudaErrorUnknown:
      return BackendFault::kSticky;
    case cudaErrorCallRequiresNewerDriver:
    case cudaErrorCompatNotSupportedOnDevice:
    case cudaErrorInitializationError:
    case cudaErrorInsufficientDriver:
    case cudaErrorInvalidDevice:
    case cudaErrorInvalidKernelImage:
    case cudaErrorNoDevice:
    case cudaErrorNoKernelImageForDevice:
    case cudaErrorStubLibrary:
    case cudaErrorSystemDriverMismatch:
      return BackendFault::kUnavailable;
    default:
      return BackendFault::kTransient;
  }
}

// Throws CudaError, which names the call, unless it succeeded.
inline void checkCuda(cudaError_t status, const char* call) {
  if (status != cudaSuccess) {
    cudaGetLastError();  // clears the error; the next check would report it again
    throw CudaError(faultOf(status), std::string(call) + ": " + cudaGetErrorString(status));
  }
}

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
