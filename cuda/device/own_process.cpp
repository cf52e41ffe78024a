#include "cuda/device/own_process.h"

#include "core/backend_error.h"
#include "core/common/forks.h"

namespace deformable_contact_monitor {
namespace {

ProcessMark uses_devices;

}  // namespace

// The driver may hang there, if the fork came while another thread called it.
void requireOwnProcess() {
  if (!uses_devices.isInherited()) return;
  throw BackendError(BackendFault::kUnavailable,
                     "CUDA cannot be used in a process that was forked after it had been used "
                     "(start processes by exec, or by multiprocessing's 'spawn')");
}

void noteDeviceUse() { uses_devices.set(); }

}  // namespace deformable_contact_monitor
