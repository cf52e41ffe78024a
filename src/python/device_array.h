// Arrays in the memory of a CUDA device, through the interface that CuPy, Numba and PyTorch share.
//
// Vertices stay on the device; only the address, the size and the stream are read here.
#pragma once

#include <pybind11/pybind11.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace deformable_contact_monitor {

// An argument of Scene::setDeviceVertices(). The Python array owns the memory.
struct DeviceArray {
  const float* xyz;  // null: there are none
  std::size_t count;
  void* stream;  // a cudaStream_t; null: the legacy default stream
};

// Reads `vertices`' __cuda_array_interface__, version 2 or later: (n, 3) float32, contiguous.
// `stream` takes precedence over the interface's own stream; 1 and 2 are the legacy and the
// per-thread default stream. Makes no CUDA call. Throws std::invalid_argument that names the body
// and the argument, and says what was given.
DeviceArray toDeviceArray(pybind11::handle vertices, std::optional<std::uintptr_t> stream,
                          const std::string& body);

}  // namespace deformable_contact_monitor
