// Which backend runs, decided in one place.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "core/detector.h"
#include "cuda/cuda_detector.h"

namespace deformable_contact_monitor {

enum class BackendChoice { kAuto, kCuda, kCpu };

// auto and cuda: on the GPU; where that cannot be, or once it fails, one warn(why), and on the CPU.
std::unique_ptr<Detector> makeDetectorFor(BackendChoice choice, const CudaSettings& settings,
                                          const std::function<void(const std::string&)>& warn);

}  // namespace deformable_contact_monitor
