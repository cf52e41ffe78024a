// Which backend runs, decided in one place.
#include "node/detector_choice.h"

#include "core/cpu_detector.h"

namespace deformable_contact_monitor {

ChosenDetector makeDetectorFor(BackendChoice choice) {
  ChosenDetector chosen{makeCpuDetector(), ""};
  if (choice != BackendChoice::kCpu) {
    chosen.warning = "this build has no CUDA backend; contacts are found on the CPU";
  }
  return chosen;
}

}  // namespace deformable_contact_monitor
