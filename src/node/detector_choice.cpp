#include "node/detector_choice.h"

#include "core/cpu/cpu_detector.h"
#include "core/fallback_detector.h"

namespace deformable_contact_monitor {

std::unique_ptr<Detector> makeDetectorFor(BackendChoice choice, const CudaSettings& settings,
                                          const std::function<void(const std::string&)>& warn) {
  if (choice == BackendChoice::kCpu) return makeCpuDetector();
  return makeFallbackDetector(
      [&settings] { return makeCudaDetector(settings); }, makeCpuDetector,
      [warn](const std::string& why) {
        warn("contacts are found on the CPU, for CUDA cannot be used: " + why);
      });
}

}  // namespace deformable_contact_monitor
