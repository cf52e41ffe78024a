// From a backend's name to a detector, for the tools.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/detector.h"
#include "cuda/cuda_detector.h"

namespace deformable_contact_monitor {

// "auto" and the backends' names, whether this build has them or not.
const std::vector<std::string>& backendNames();

// "auto" is the fastest backend that this build and this machine have. "cuda" where there is no
// device, or once it fails: one warn(why), and the CPU. Throws std::runtime_error, one line with a
// way out, where another backend is not built.
std::unique_ptr<Detector> makeDetector(const std::string& backend, const CudaSettings& settings,
                                       const std::function<void(const std::string&)>& warn);

// Whether the backend reports pairs at a distance; FCL's finds intersections alone.
bool supportsMargins(const Detector& detector);

}  // namespace deformable_contact_monitor
