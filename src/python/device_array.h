// Arrays in the memory of a CUDA device, by the interface that CuPy, Numba and PyTorch share.
#pragma once

#include <pybind11/pybind11.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace deformable_contact_monitor {

// As Scene::setDeviceVertices() takes it; the array owns the memory.
struct DeviceArray {
  const float* xyz;  // null: there are none
  std::size_t count;
  void* stream;  // a cudaStream_t; null: the legacy default stream
};

// Reads `vertices`' __cuda_array_interface__, version 2 or later: (n, 3) float32, contiguous.
// `stream`, where given, goes before the interface's own; 1 and 2 are the legacy and the
// per-thread default stream, as there. Calls no CUDA. Every refusal is a std::invalid_argument that
// names body and argument and says what was given.
DeviceArray toDeviceArray(pybind11::handle vertices, std::optional<std::uintptr_t> stream,
                          const std::string& body);

}  // namespace deformable_contact_monitor
