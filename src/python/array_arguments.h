// Checks arrays that callers pass, and converts them to the core's layout. Every function throws
// std::invalid_argument that names the body and the argument, and says what was given.
//
// Arrays that fit already are not copied: the caller's memory is read directly.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/rigid_transform.h"

namespace deformable_contact_monitor {

// An array of C order with aligned native numbers. It shares the caller's memory if that fits
// already.
constexpr int kPlain = pybind11::array::c_style | pybind11::array::forcecast |
                       pybind11::detail::npy_api::NPY_ARRAY_ALIGNED_;
using VertexArray = pybind11::array_t<float, kPlain>;

// Converts vertices: real numbers of shape (n, 3). Other types are rounded to the nearest float32.
// Here and below, an argument may be anything that numpy converts to an array: an array, a list, or
// a tensor in host memory.
VertexArray toVertexArray(pybind11::handle vertices, const std::string& body);

// Converts vertices [m], with the same checks, to the list x y z x y z ... that a mesh has.
std::vector<float> toVertices(pybind11::handle vertices, const std::string& body);

// Converts triangles: integers of shape (m, 3). Rejects an index that does not fit into uint32.
// validate() rejects those beyond the vertices.
std::vector<std::uint32_t> toTriangles(pybind11::handle triangles, std::size_t vertex_count,
                                       const std::string& body);

// Converts a rotation, shape (3, 3), and a translation, shape (3,) [m], both of real numbers.
// Rejects finite ones of which isRotation() says no; whether they are finite is checked by
// Scene::setPose().
RigidTransform toPose(pybind11::handle rotation, pybind11::handle translation,
                      const std::string& body);

// An argument of Scene::setDeviceVertices(): an array in the memory of a CUDA device, through the
// interface that CuPy, Numba and PyTorch share. The Python array owns the memory.
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

// Returns an array of any shape in host memory: `value` itself, what numpy makes of it, or a copy
// of an array of float32 or float64 numbers in the memory of a CUDA device, made behind the work
// that is in the interface's stream. Throws std::invalid_argument that begins with `name`, and
// CudaError if the copy fails.
pybind11::array toHostArray(pybind11::handle value, const std::string& name);

}  // namespace deformable_contact_monitor
