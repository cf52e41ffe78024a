// Keeps CUDA out of processes that were forked after they had used it: the driver may hang there.
#pragma once

namespace deformable_contact_monitor {

// Any thread may call these functions.

// Throws BackendError (kUnavailable) if this process was forked after noteDeviceUse().
void requireOwnProcess();

// Notes that this process uses a device from now on.
void noteDeviceUse();

}  // namespace deformable_contact_monitor
