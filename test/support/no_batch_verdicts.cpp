// Stands in for batch_verdicts.cu in builds without nvcc.
#include "batch_verdicts.h"
#include "cuda/device/cuda_error.h"

namespace deformable_contact_monitor {

std::vector<BatchVerdict> batchVerdicts(const std::vector<VerdictQuestion>& /*pairs*/,
                                        AdjacentPairs /*adjacent*/, Predicates /*predicates*/,
                                        float /*margin_m*/) {
  throw CudaError(BackendFault::kUnavailable, "this build has no CUDA backend");
}

}  // namespace deformable_contact_monitor
