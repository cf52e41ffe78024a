// What callers pass as arrays, checked and brought into the core's layout. Every refusal is a
// std::invalid_argument that names the body and the argument and says what was given.
#pragma once

#include <pybind11/numpy.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/rigid_transform.h"

namespace deformable_contact_monitor {

// C-contiguous, aligned, native numbers: the caller's own memory where it is that already.
constexpr int kPlain = pybind11::array::c_style | pybind11::array::forcecast |
                       pybind11::detail::npy_api::NPY_ARRAY_ALIGNED_;
using VertexArray = pybind11::array_t<float, kPlain>;

// Anything that numpy takes for an array: its own arrays, lists, tensors in host memory.
// Vertices: real numbers of shape (n, 3); what is not float32 is rounded to the nearest one.
VertexArray toVertexArray(pybind11::handle vertices, const std::string& body);

// The same, as a mesh has them.
std::vector<float> toVertices(pybind11::handle vertices, const std::string& body);

// Triangles: integers of shape (m, 3). Refuses an index that would not survive as uint32; of the
// others, those beyond the vertices are left to validate().
std::vector<std::uint32_t> toTriangles(pybind11::handle triangles, std::size_t vertex_count,
                                       const std::string& body);

// Real numbers of shapes (3, 3) and (3,).
RigidTransform toPose(pybind11::handle rotation, pybind11::handle translation,
                      const std::string& body);

}  // namespace deformable_contact_monitor
