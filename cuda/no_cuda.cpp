// Stands in for the CUDA backend in builds without nvcc.
#include "cuda/cuda_detector.h"
#include "cuda/device/cuda_error.h"

namespace deformable_contact_monitor {

std::unique_ptr<Detector> makeCudaDetector(const CudaSettings& /*settings*/) {
  throw CudaError(BackendFault::kUnavailable,
                  "this build has no CUDA backend: no nvcc was there that could, or WITH_CUDA was off");
}

}  // namespace deformable_contact_monitor
