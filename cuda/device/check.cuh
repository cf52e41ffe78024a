// The check that every CUDA call goes through.
#pragma once

#include <cuda_runtime.h>

#include <string>

#include "cuda/device/cuda_error.h"

namespace deformable_contact_monitor {

// What helps against CUDA's errors. A device that has died in this process says one of kSticky
// whatever it is asked; what is not listed is worth another try.
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
    cudaGetLastError();  // or the next check of it would report this again
    throw CudaError(faultOf(status), std::string(call) + ": " + cudaGetErrorString(status));
  }
}

}  // namespace deformable_contact_monitor
