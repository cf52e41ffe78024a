// The detector on an NVIDIA GPU.
#pragma once

#include <cstdint>
#include <memory>

#include "core/detector.h"
#include "core/export.h"

namespace deformable_contact_monitor {

struct CudaSettings {
  int device = 0;
  // Upper bound of the device memory that the lists of candidates and contacts may take [bytes].
  // Beyond it a cycle takes several passes, and contacts are left out of the result's list. Where
  // that does not do either, the result is cut off: "memory_limit_mib".
  std::uint64_t memory_limit_bytes = std::uint64_t{4} << 30;
  // Times each stage, which keeps stages from overlapping: for benchmarks.
  bool time_stages = false;
};

// Throws BackendError, one line, if the build is without CUDA, there is no driver, no such device,
// one older than compute capability 7.5, or if it fails; so may detect(). After kSceneTooLarge
// (more than 2^27 triangles or vertices, or too crowded) the detector goes on with other scenes;
// after other errors, make another one. Detectors in one process do not wait for each other.
DCM_EXPORT std::unique_ptr<Detector> makeCudaDetector(
    const CudaSettings& settings = CudaSettings());

}  // namespace deformable_contact_monitor
