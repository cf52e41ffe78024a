// Page-locked memory for containers that the device reads or writes itself.
#pragma once

#include <memory_resource>

namespace deformable_contact_monitor {

// The same one always, which outlives everything. Throws CudaError where there is no more. To
// allocate takes some 0.1 ms and more.
std::pmr::memory_resource& pinnedMemory();

// The same for what the host alone needs to reach: plain memory where there is no other.
std::pmr::memory_resource& lentMemory();

// Whether the device reaches it: then copies run from it while the host goes on.
bool isPinned(const void* memory);

}  // namespace deformable_contact_monitor
