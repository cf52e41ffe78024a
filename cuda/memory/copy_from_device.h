// Copies an array that the user keeps on a device. Declared without CUDA's headers.
#pragma once

#include <cstddef>

namespace deformable_contact_monitor {

// Copies from a CUDA device's memory to the host's, behind the work that is now in `stream` (a
// cudaStream_t; null: the legacy default stream), and waits for the copy. Throws
// std::invalid_argument if `from` is no memory of a CUDA device, and CudaError if CUDA fails or
// this build has none. Any thread; the calling thread's current device stays.
void copyFromDevice(void* to, const void* from, std::size_t bytes, void* stream);

}  // namespace deformable_contact_monitor
