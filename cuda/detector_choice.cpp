#include "cuda/detector_choice.h"

#include <optional>
#include <stdexcept>

#include "core/cpu/cpu_detector.h"
#include "core/pair_set_detector.h"

namespace deformable_contact_monitor {

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
                                       const std::function<void(const BackendState&)>& changed) {
  PairSetLimits limits;
  limits.memory_bytes = settings.memory_limit_bytes;
  const DetectorMaker on_cpu = [settings, limits] {
    const CpuSettings cpu{settings.memory_limit_bytes};
    return makePairSetDetector([cpu] { return makeCpuDetector(cpu); }, limits);
  };
  const DetectorMaker on_cuda = [settings, limits] {
    return makePairSetDetector([settings] { return makeCudaDetector(settings); }, limits);
  };
  if (choice == BackendChoice::kCpu) return on_cpu();
  if (choice == BackendChoice::kCuda && without_cuda == WithoutCuda::kRefuse) return on_cuda();
  return makeFallbackDetector(
      on_cuda, on_cpu, changed,
      without_cuda == WithoutCuda::kTryAgain ? std::optional(RetryTimes()) : std::nullopt);
}

}  // namespace deformable_contact_monitor
