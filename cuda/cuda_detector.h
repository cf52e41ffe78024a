// The detector on an NVIDIA GPU.
#pragma once

#include <memory>

#include "core/backend_choice.h"
#include "core/detector.h"
#include "core/export.h"

namespace deformable_contact_monitor {

// Makes a detector on an NVIDIA GPU. Throws BackendError, with one line of text, if the build is
// without CUDA, there is no driver or no such device, the device is older than compute capability
// 7.5, or it fails; detect() may throw it too. After kSceneTooLarge (more than 2^27 triangles or
// vertices, or too dense a scene) the detector goes on with other scenes; after any other error
// make another one. Several devices count as failed only if all of them fail. Detectors of one
// process do not wait for each other. From the first detector on, the process keeps 96 MiB of each
// device that it uses, if it has as much, and 16 MiB of page-locked memory. In a process that is
// forked after that, this function and the detect() of all detectors throw BackendError
// (kUnavailable) at once, and what lies in their vertexMemory() must not be read.
DCM_EXPORT std::unique_ptr<Detector> makeCudaDetector(
    const CudaSettings& settings = CudaSettings());

}  // namespace deformable_contact_monitor
