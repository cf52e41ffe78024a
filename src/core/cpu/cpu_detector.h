// The CPU backend: the detector's stages on threads.
#pragma once

#include <memory>

#include "core/detector.h"

namespace deformable_contact_monitor {

std::unique_ptr<Detector> makeCpuDetector();

}  // namespace deformable_contact_monitor
