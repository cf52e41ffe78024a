// The detector on an NVIDIA GPU.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "core/backend_error.h"
#include "core/detector.h"
#include "core/export.h"

namespace deformable_contact_monitor {

struct CudaSettings {
  int device = 0;
  // Not empty: in place of `device`. Several share each cycle of scenes that are large enough;
  // others run on the first, as do those whose vertices are on a device. Results are the same.
  std::vector<int> devices;
  // From so many triangles on, in bodies that take part: below, two devices take longer until the
  // contacts are on the host, though they find them sooner.
  std::size_t shared_from_triangles = 1000000;
  // Told of each of several devices that fails, from within detect() or while the detector is made;
  // the others go on without it, and make that cycle again. May be empty; makeDetector() sets it.
  std::function<void(const BackendError&)> device_lost;
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
// after other errors, make another one. Of several devices, all must fail for that. Detectors in
// one process do not wait for each other. From the first one on the process holds 128 MiB of each
// device that it uses, where there is as much, and 16 MiB of page-locked memory.
DCM_EXPORT std::unique_ptr<Detector> makeCudaDetector(
    const CudaSettings& settings = CudaSettings());

}  // namespace deformable_contact_monitor
