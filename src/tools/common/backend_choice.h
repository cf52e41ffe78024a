// Makes a detector from a backend's name: the package's backends and the reference detectors.
//
// "fcl" and "brute_force" are references: slow, simple detectors that others are compared with.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/detector.h"
#include "cuda/detector_choice.h"

namespace deformable_contact_monitor {

// Returns "auto" and the names of all backends, whether this build has them or not.
const std::vector<std::string>& backendNames();

// Makes a detector. "auto" falls back to the CPU silently, "cuda" calls warn(why) first; both warn
// if one of several devices cannot be used. Throws BackendError if `without_cuda` is kRefuse and
// there is no CUDA, and std::runtime_error, one line that says what to install, if a reference is
// not built. `tilings` is for detection with a tolerance; the reference detectors ignore it.
std::unique_ptr<Detector> makeDetector(const std::string& backend, WithoutCuda without_cuda,
                                       const CudaSettings& settings,
                                       const std::function<void(const std::string&)>& warn,
                                       const std::shared_ptr<TilingCache>& tilings = nullptr);

// Builds the tilings of all bodies and waits for them, so that the next detection uses them.
void makeTilings(const Scene& scene, TilingCache* tilings);

// Returns true if the backend reports pairs at a distance. FCL finds only intersections.
bool supportsMargins(const Detector& detector);

}  // namespace deformable_contact_monitor
