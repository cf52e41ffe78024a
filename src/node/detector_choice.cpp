#include "node/detector_choice.h"

namespace deformable_contact_monitor {

std::unique_ptr<Detector> makeDetectorFor(BackendChoice choice, const CudaSettings& settings,
                                          const std::function<void(const std::string&)>& warn) {
  return makeChosenDetector(
      choice, WithoutCuda::kFallBack, settings, [warn](const std::string& why) {
        warn("contacts are found on the CPU, for CUDA cannot be used: " + why);
      });
}

}  // namespace deformable_contact_monitor
