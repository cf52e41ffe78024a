// The backend that the node runs, and what it says where that is not the one asked for.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "cuda/detector_choice.h"

namespace deformable_contact_monitor {

// A monitor goes on without CUDA, whatever was chosen, and says so: one warn(why), one line.
std::unique_ptr<Detector> makeDetectorFor(BackendChoice choice, const CudaSettings& settings,
                                          const std::function<void(const std::string&)>& warn);

}  // namespace deformable_contact_monitor
