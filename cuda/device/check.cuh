// The check that every CUDA call goes through.
#pragma once

#include <cuda_runtime.h>

#include <string>

#include "cuda/device/cuda_error.h"

namespace deformable_contact_monitor {

// Throws CudaError, which names the call, unless it succeeded.
inline void checkCuda(cudaError_t status, const char* call) {
  if (status != cudaSuccess) {
    cudaGetLastError();  // or the next check of it would report this again
    throw CudaError(std::string(call) + ": " + cudaGetErrorString(status));
  }
}

}  // namespace deformable_contact_monitor
