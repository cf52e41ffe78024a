#include "cuda/detector_choice.h"

#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "core/bounded_detector.h"
#include "core/common/pair_set_detector.h"
#include "core/cpu_detector.h"

namespace deformable_contact_monitor {
namespace {

// What `changed` is told: also of devices of several, which each detector of a set of pairs loses
// by itself, once.
class BackendNews {
 public:
  explicit BackendNews(std::function<void(const BackendState&)> changed)
      : changed_(std::move(changed)) {}

  void tell(const BackendState& state) {
    const bool all_are_made_anew = state.fault != BackendFault::kSceneTooLarge;
    if (!state.problem.empty() && all_are_made_anew) lost_.clear();
    changed_(state.problem.empty() && !lost_.empty() ? last_lost_ : state);
  }

  void tellLost(const BackendError& error) {
    if (!lost_.insert(error.what()).second) return;
    last_lost_.problem = error.what();
    last_lost_.fault = error.fault();
    last_lost_.partly = true;
    changed_(last_lost_);
  }

 private:
  const std::function<void(const BackendState&)> changed_;
  std::set<std::string> lost_;
  BackendState last_lost_;
};

}  // namespace

const char* toString(BackendChoice choice) {
  switch (choice) {
    case BackendChoice::kCuda:
      return "cuda";
    case BackendChoice::kCpu:
      return "cpu";
    default:
      return "auto";
  }
}

BackendChoice toBackendChoice(const std::string& name) {
  for (const BackendChoice choice :
       {BackendChoice::kAuto, BackendChoice::kCuda, BackendChoice::kCpu}) {
    if (name == toString(choice)) return choice;
  }
  throw std::invalid_argument("backend '" + name + "' is none of auto, cuda, cpu");
}

std::unique_ptr<Detector> makeDetector(BackendChoice choice, WithoutCuda without_cuda,
                                       const CudaSettings& settings,
                                       const std::function<void(const BackendState&)>& changed,
                                       const std::shared_ptr<TilingCache>& tilings) {
  PairSetLimits limits;
  limits.memory_bytes = settings.memory_limit_bytes;
  const DetectorMaker on_cpu = [settings, limits, tilings] {
    const CpuSettings cpu{settings.memory_limit_bytes};
    auto exact = makePairSetDetector([cpu] { return makeCpuDetector(cpu); }, limits);
    return tilings == nullptr ? std::move(exact) : makeBoundedDetector(std::move(exact), tilings);
  };
  CudaSettings cuda = settings;
  std::function<void(const BackendState&)> tell;
  if (changed) {
    const auto news = std::make_shared<BackendNews>(changed);
    tell = [news](const BackendState& state) { news->tell(state); };
    cuda.device_lost = [news](const BackendError& error) { news->tellLost(error); };
  }
  const DetectorMaker on_cuda = [cuda, limits] {
    return makePairSetDetector([cuda] { return makeCudaDetector(cuda); }, limits);
  };
  if (choice == BackendChoice::kCpu) return on_cpu();
  if (choice == BackendChoice::kCuda && without_cuda == WithoutCuda::kRefuse) return on_cuda();
  return makeFallbackDetector(
      on_cuda, on_cpu, tell,
      without_cuda == WithoutCuda::kTryAgain ? std::optional(RetryTimes()) : std::nullopt);
}

}  // namespace deformable_contact_monitor
