// Knows which backends this build has.
#include "tools/common/backend_choice.h"

#include <cstdint>
#include <stdexcept>

#include "reference/reference_detectors.h"

namespace deformable_contact_monitor {

const std::vector<std::string>& backendNames() {
  static const std::vector<std::string> kNames = {"auto", "cpu", "cuda", "fcl", "brute_force"};
  return kNames;
}

std::unique_ptr<Detector> makeDetector(const std::string& backend, WithoutCuda without_cuda,
                                       const CudaSettings& settings,
                                       const std::function<void(const std::string&)>& warn,
                                       const std::shared_ptr<TilingCache>& tilings) {
  if (backend == "brute_force") return makeBruteForceDetector();
  if (backend == "fcl") {
#ifdef DCM_HAVE_FCL
    return makeFclDetector();
#else
    throw std::runtime_error("this build has no FCL backend; install libfcl-dev and build again");
#endif
  }
  const BackendChoice choice = toBackendChoice(backend);
  const auto tell = [warn, choice](const BackendState& state) {
    if (state.partly) return warn("one device less: " + state.problem);
    if (choice == BackendChoice::kAuto) return;
    warn("CUDA cannot be used, so on the CPU: " + state.problem);
  };
  return makeDetector(choice, without_cuda, settings, tell, tilings);
}

// A tiling is begun once its triangles were asked for kSettledAfter times, so each body is asked
// for that often.
void makeTilings(const Scene& scene, TilingCache* tilings) {
  for (std::uint32_t time = 0; time <= TilingCache::kSettledAfter; ++time) {
    for (const Body& body : scene.bodies()) tilings->of(body);
  }
  tilings->wait();
}

bool supportsMargins(const Detector& detector) { return detector.backend() != "fcl"; }

}  // namespace deformable_contact_monitor
