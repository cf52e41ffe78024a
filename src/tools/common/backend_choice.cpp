// Which backends this build has.
#include "tools/common/backend_choice.h"

#include <stdexcept>

#include "core/cpu/cpu_detector.h"
#include "core/fallback_detector.h"
#include "reference/brute_force_detector.h"
#ifdef DCM_HAVE_FCL
#include "reference/fcl_detector.h"
#endif

namespace deformable_contact_monitor {

const std::vector<std::string>& backendNames() {
  static const std::vector<std::string> kNames = {"auto", "cpu", "cuda", "fcl", "brute_force"};
  return kNames;
}

std::unique_ptr<Detector> makeDetector(const std::string& backend, const CudaSettings& settings,
                                       const std::function<void(const std::string&)>& warn) {
  if (backend == "cpu") return makeCpuDetector();
  if (backend == "brute_force") return makeBruteForceDetector();
  if (backend == "auto" || backend == "cuda") {
    const bool asked = backend == "cuda";
    return makeFallbackDetector([&settings] { return makeCudaDetector(settings); }, makeCpuDetector,
                                [warn, asked](const std::string& why) {
                                  if (asked) warn("CUDA cannot be used, so on the CPU: " + why);
                                });
  }
#ifdef DCM_HAVE_FCL
  if (backend == "fcl") return makeFclDetector();
#else
  if (backend == "fcl") {
    throw std::runtime_error("this build has no FCL backend; install libfcl-dev and build again");
  }
#endif
  throw std::runtime_error("no backend is called '" + backend + "'");
}

bool supportsMargins(const Detector& detector) { return detector.backend() != "fcl"; }

}  // namespace deformable_contact_monitor
