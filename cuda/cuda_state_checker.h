// Checks states on an NVIDIA GPU.
#pragma once

#include <memory>

#include "core/backend_choice.h"
#include "core/export.h"
#include "core/state_checker.h"

namespace deformable_contact_monitor {

// Makes a checker on settings.device, or on the first of settings.devices. Throws BackendError as
// makeCudaDetector() does; check() may throw it too, and then make another checker, unless it is
// kSceneTooLarge. Bodies may have their vertices on that device. The kernels of a kind of check are
// loaded at its first use. Of the other settings only memory_limit_bytes counts, for lists of
// triangles that are the nearest so far: a check that needs more is divided, and throws
// kSceneTooLarge if one state alone needs more.
DCM_EXPORT std::unique_ptr<StateChecker> makeCudaStateChecker(
    const CudaSettings& settings = CudaSettings());

}  // namespace deformable_contact_monitor
