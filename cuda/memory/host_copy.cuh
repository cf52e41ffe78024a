// From the host's memory to the device by a kernel.
#pragma once

#include <cuda_runtime.h>

#include <cstddef>
#include <cstdint>

namespace deformable_contact_monitor {

// Copies `count` words, behind what is in the stream. `from`: where the device reaches page-locked
// memory (reachedAt()), which may go once the stream has been waited for. The driver's copies run
// on an engine of their own, and kernels behind one may begin some 5 us later.
void copyWordsFromHost(const std::uint32_t* from, std::size_t count, std::uint32_t* to,
                       cudaStream_t stream);

// The same for elements of whole words.
template <class T>
void copyFromHost(const T* from, std::size_t count, T* to, cudaStream_t stream) {
  static_assert(sizeof(T) % sizeof(std::uint32_t) == 0);
  copyWordsFromHost(reinterpret_cast<const std::uint32_t*>(from),
                    count * (sizeof(T) / sizeof(std::uint32_t)),
                    reinterpret_cast<std::uint32_t*>(to), stream);
}

}  // namespace deformable_contact_monitor
