// The plain settings and states of backends: which one is asked for, how CUDA is set up, and why
// it does not run. They need no CUDA, so that programs can read and store them without it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/backend_error.h"
#include "core/export.h"
#include "core/options.h"

namespace deformable_contact_monitor {

enum class BackendChoice {
  kAuto,  // CUDA where it works, else the CPU
  kCuda,
  kCpu,
};

// Returns "auto", "cuda" or "cpu".
DCM_EXPORT const char* toString(BackendChoice choice);
// Returns the choice of that name. Throws std::invalid_argument at any other name.
DCM_EXPORT BackendChoice toBackendChoice(const std::string& name);

// The answer if BackendChoice::kCuda is asked for and CUDA cannot be used.
enum class WithoutCuda {
  kTryAgain,  // The CPU takes over until CUDA works again. For a monitor that runs for days.
  kFallBack,  // The CPU takes over for good. For a program that detects once.
  kRefuse,    // BackendError is thrown. For measurements, where "cuda" must mean CUDA.
};

// Which CUDA devices run, and how much memory they may use.
struct CudaSettings {
  int device = 0;
  // If not empty, replaces `device`. Several devices share each cycle of a scene that is large
  // enough. The first device alone runs all other scenes, and those with vertices on a device.
  // Results are the same.
  std::vector<int> devices;
  // Scenes with at least so many triangles, in bodies that take part, are shared among `devices`.
  // Below it two devices find contacts sooner, but need longer to bring them to the host.
  std::size_t shared_from_triangles = 1000000;
  // Is called for each of several devices that fails, from within detect() or while the detector
  // is made. The other devices go on without it, and repeat that cycle. May be empty.
  // makeDetector() sets it.
  std::function<void(const BackendError&)> device_lost;
  // Upper bound of the device memory for lists of candidates and contacts [bytes]. A cycle that
  // needs more takes several passes, and then leaves contacts out of the result's list. If that is
  // not enough either, the result is cut off because of "memory_limit_mib".
  std::uint64_t memory_limit_bytes = std::uint64_t{4} << 30;
  // The kernels of cycles with such options are loaded when the detector is made; for swept motion
  // also those of instant motion. Others are loaded, and take device memory for their stacks, when
  // a cycle first needs them. That cycle takes longer, and so may other detectors at that moment.
  Options warm_up;
  // Measures each stage. Stages do not overlap then, so cycles take longer: for benchmarks.
  bool time_stages = false;
};

// Why the device's backend does not run, or not for every scene.
struct DCM_EXPORT BackendState {
  std::string problem;  // one line; empty: there is no problem
  BackendFault fault = BackendFault::kTransient;
  bool tried_again = false;  // the backend is tried again later, without help
  bool partly = false;       // CUDA runs, but without one of several devices
};

}  // namespace deformable_contact_monitor
