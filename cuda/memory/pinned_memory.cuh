// Page-locked memory for containers that the device reads or writes itself.
#pragma once

#include <memory_resource>

namespace deformable_contact_monitor {

// The same one always, which outlives everything; any thread. Throws CudaError where there is no
// more. The first 16 MiB that are in use at a time were taken when it was first asked for; beyond,
// to allocate takes some 0.3 ms and as much for each 2 MiB. What is given back, others may have at
// once: no work of the device may be left that knows of it.
std::pmr::memory_resource& pinnedMemory();

// The same for what the host alone needs to reach: plain memory where there is no other.
std::pmr::memory_resource& pinnedOrPlainMemory();

}  // namespace deformable_contact_monitor
