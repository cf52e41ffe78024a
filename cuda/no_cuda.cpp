// Stands in for the CUDA backend in builds without nvcc.
#include "cuda/cuda_detector.h"
#include "cuda/cuda_state_checker.h"
#include "cuda/device/cuda_error.h"
#include "cuda/memory/copy_from_device.h"
#include "cuda/partitions/partitioned_detector.h"

namespace deformable_contact_monitor {
namespace {

[[noreturn]] void refuseCuda() {
  throw CudaError(BackendFault::kUnavailable,
                  "this build has no CUDA backend: there was no nvcc of CUDA 11.4 or newer, or "
                  "WITH_CUDA was off");
}

}  // namespace

std::unique_ptr<Detector> makeCudaDetector(const CudaSettings& settings) {
  return makeCudaPartitionDetector(settings);
}

std::unique_ptr<PartitionDetector> makeCudaPartitionDetector(const CudaSettings& /*settings*/) {
  refuseCuda();
}

std::unique_ptr<StateChecker> makeCudaStateChecker(const CudaSettings& /*settings*/) {
  refuseCuda();
}

void copyFromDevice(void* /*to*/, const void* /*from*/, std::size_t /*bytes*/, void* /*stream*/) {
  refuseCuda();
}

}  // namespace deformable_contact_monitor
