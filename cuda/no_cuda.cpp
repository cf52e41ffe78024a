// Stands in for the CUDA backend in builds without nvcc.
#include "cuda/batch_verdicts.h"
#include "cuda/cuda_detector.h"
#include "cuda/cuda_error.h"

namespace deformable_contact_monitor {
namespace {

constexpr const char* kWhy =
    "this build has no CUDA backend: nvcc was not there, or WITH_CUDA was off";

}  // namespace

std::unique_ptr<Detector> makeCudaDetector(const CudaSettings& /*settings*/) {
  throw CudaError(kWhy);
}

std::vector<BatchVerdict> batchVerdicts(const std::vector<VerdictQuestion>& /*pairs*/,
                                        AdjacentPairs /*adjacent*/, Predicates /*predicates*/,
                                        float /*margin_m*/) {
  throw CudaError(kWhy);
}

}  // namespace deformable_contact_monitor
