// From a backend's name to a detector, for the tools: the package's backends and the references.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/detector.h"
#include "cuda/detector_choice.h"

namespace deformable_contact_monitor {

// "auto" and the backends' names, whether this build has them or not.
const std::vector<std::string>& backendNames();

// "auto", "cuda" and "cpu" as makeDetector() has them; "auto" falls back without a word, and
// "cuda" with one warn(why); either warns where it loses one of several devices. Throws CudaError
// where kRefuse asks for it, and std::runtime_error, one line with a way out, where a reference is
// not built. `tilings`: as there; the references are exact.
std::unique_ptr<Detector> makeDetector(const std::string& backend, WithoutCuda without_cuda,
                                       const CudaSettings& settings,
                                       const std::function<void(const std::string&)>& warn,
                                       const std::shared_ptr<TilingCache>& tilings = nullptr);

// Has the tilings of all bodies made, so that the scene's next detection is bounded by them.
void makeTilings(const Scene& scene, TilingCache* tilings);

// Whether the backend reports pairs at a distance; FCL's finds intersections alone.
bool supportsMargins(const Detector& detector);

}  // namespace deformable_contact_monitor
