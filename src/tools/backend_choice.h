// From a backend's name to a detector, for the tools.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/detector.h"

namespace deformable_contact_monitor {

// "auto" and the backends' names, whether this build has them or not.
const std::vector<std::string>& backendNames();

// "auto" is the fastest backend that this build and this machine have. Throws std::runtime_error,
// one line with a way out, where the backend is not built.
std::unique_ptr<Detector> makeDetector(const std::string& backend);

// Whether the backend reports pairs at a distance; FCL's finds intersections alone.
bool supportsMargins(const Detector& detector);

}  // namespace deformable_contact_monitor
