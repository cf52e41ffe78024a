#include "batch_verdicts.h"
#include "cuda/device/stream.cuh"
#include "cuda/memory/device_buffer.cuh"
#include "pair_verdict.h"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;

__global__ void __launch_bounds__(kThreads)
    verdictKernel(const VerdictQuestion* pairs, unsigned count, AdjacentPairs adjacent,
                  Predicates predicates, float margin_m, BatchVerdict* verdicts) {
  const unsigned i = blockIdx.x * kThreads + threadIdx.x;
  if (i >= count) return;
  const VerdictQuestion pair = pairs[i];
  PredicateState state;
  state.mode = predicates;
  const Verdict verdict = pairVerdict(pair.a, pair.b, pair.same_body, adjacent, margin_m, state);
  verdicts[i] = {verdict.contact ? 1U : 0U, state.exact > 0 ? 1U : 0U, verdict.separation_m};
}

}  // namespace

std::vector<BatchVerdict> batchVerdicts(const std::vector<VerdictQuestion>& pairs,
                                        AdjacentPairs adjacent, Predicates predicates,
                                        float margin_m) {
  std::vector<BatchVerdict> verdicts(pairs.size());
  CudaStream stream;
  if (pairs.empty()) return verdicts;
  DeviceBuffer<VerdictQuestion> device_pairs(pairs.size(), stream.get());
  DeviceBuffer<BatchVerdict> device_verdicts(pairs.size(), stream.get());
  device_pairs.upload(pairs.data(), pairs.size(), stream.get());
  const auto count = static_cast<unsigned>(pairs.size());
  const unsigned blocks = (count + kThreads - 1) / kThreads;
  verdictKernel<<<blocks, kThreads, 0, stream.get()>>>(
      device_pairs.data(), count, adjacent, predicates, margin_m, device_verdicts.data());
  checkCuda(cudaGetLastError(), "verdictKernel");
  device_verdicts.download(verdicts.data(), verdicts.size(), stream.get());
  stream.synchronise();
  return verdicts;
}

}  // namespace deformable_contact_monitor
