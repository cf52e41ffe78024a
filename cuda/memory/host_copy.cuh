// From the host's memory to the device by a kernel.
#pragma once

#include <cuda_runtime.h>

#include <cstddef>

namespace deformable_contact_monitor {

// Copies `count` numbers, behind what is in the stream. `from`: where the device reaches
// page-locked memory (reachedAt()), which may go once the stream has been waited for. The driver's
// copies run on an engine of their own, and kernels behind one may begin some 5 us later.
void copyFromHost(const float* from, std::size_t count, float* to, cudaStream_t stream);

}  // namespace deformable_contact_monitor
