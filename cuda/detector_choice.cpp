#include "cuda/detector_choice.h"

#include <memory>
#include <set>
#include <string>
#include <utility>

#include "core/cpu_detector.h"
#include "core/detector_pool.h"
#include "cuda/cuda_detector.h"

namespace deformable_contact_monitor {
namespace {

// Combines two kinds of news into what `changed` is called with: the state of the pool, and devices
// of several that were lost. Each warm detector loses the same device by itself, but it is reported
// once. While such a device is missing, the state that follows a recovery is "partly".
class BackendNews {
 public:
  explicit BackendNews(std::function<void(const BackendState&)> changed)
      : changed_(std::move(changed)) {}

  void report(const BackendState& state) {
    // After any other fault all detectors are made again, and may lose devices again.
    const bool all_are_made_anew = state.fault != BackendFault::kSceneTooLarge;
    if (!state.problem.empty() && all_are_made_anew) lost_.clear();
    changed_(state.problem.empty() && !lost_.empty() ? last_lost_ : state);
  }

  void reportLost(const BackendError& error) {
    if (!lost_.insert(error.what()).second) return;
    last_lost_.problem = error.what();
    last_lost_.fault = error.fault();
    last_lost_.partly = true;
    changed_(last_lost_);
  }

 private:
  const std::function<void(const BackendState&)> changed_;
  std::set<std::string> lost_;  // what() of each
  BackendState last_lost_;
};

}  // namespace

std::unique_ptr<Detector> makeDetector(BackendChoice choice, WithoutCuda without_cuda,
                                       const CudaSettings& settings,
                                       const std::function<void(const BackendState&)>& changed,
                                       const std::shared_ptr<TilingCache>& tilings) {
  PoolSettings pool;
  pool.memory_bytes = settings.memory_limit_bytes;
  pool.tilings = tilings;
  const bool is_cuda_alone = choice == BackendChoice::kCuda && without_cuda == WithoutCuda::kRefuse;
  if (!is_cuda_alone) {
    CpuSettings cpu;
    cpu.memory_limit_bytes = settings.memory_limit_bytes;
    cpu.tilings = tilings ? tilings : std::make_shared<TilingCache>();
    pool.cpu = [cpu] { return makeCpuDetector(cpu); };
  }
  if (choice != BackendChoice::kCpu) {
    CudaSettings cuda = settings;
    if (changed) {
      const auto news = std::make_shared<BackendNews>(changed);
      pool.changed = [news](const BackendState& state) { news->report(state); };
      cuda.device_lost = [news](const BackendError& error) { news->reportLost(error); };
    }
    pool.device = [cuda] { return makeCudaDetector(cuda); };
  }
  if (without_cuda == WithoutCuda::kTryAgain) pool.retry.emplace();
  return makeDetectorPool(std::move(pool));
}

}  // namespace deformable_contact_monitor
