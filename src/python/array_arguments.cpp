// Converts numpy arrays, and what numpy can make arrays of, to the core's lists. Types and shapes
// are checked first, because numpy would convert silently, for example texts to numbers.
#include "python/array_arguments.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <type_traits>

namespace deformable_contact_monitor {
namespace py = pybind11;
namespace {

// Returns the shape as Python shows it, for example (3, 2).
std::string shapeOf(const py::array& array) { return py::str(array.attr("shape")); }

// An argument of a Python call, with the names that error messages give. Every check throws
// std::invalid_argument.
struct Argument {
  const std::string& body;
  const char* name;

  [[noreturn]] void refuse(const std::string& what) const {
    throw std::invalid_argument(body + ": " + name + " " + what);
  }

  // Returns the value as an array of any type and shape; copies nothing if it is an array.
  py::array toArray(py::handle value) const {
    py::array array = py::array::ensure(value);
    if (array) return array;
    // numpy cannot read device memory, so the message names the function that can.
    if (py::hasattr(value, "__cuda_array_interface__")) {
      refuse("is in a device's memory; set_device_vertices takes vertices from there");
    }
    refuse("is not an array");
  }

  // `kinds`: numpy's letters, of which dtype.kind must be one.
  void requireKind(const py::array& array, const char* kinds, const char* wanted) const {
    if (std::string(kinds).find(array.dtype().kind()) == std::string::npos) {
      refuse("has dtype " + std::string(py::str(array.dtype())) + ", must be " + wanted);
    }
  }

  // Requires the shape (n, 3); n may be 0.
  void requireRowsOfThree(const py::array& array) const {
    if (array.ndim() != 2 || array.shape(1) != 3) {
      refuse("has shape " + shapeOf(array) + ", must be (n, 3)");
    }
  }
};

// Letters of numpy's dtype.kind.
constexpr const char* kReal = "fiu";
constexpr const char* kIntegers = "iu";

// Converts indices of any integer type to uint32, and names the first triangle that does not fit.
template <class Index>
std::vector<std::uint32_t> narrowed(const py::array& array, std::size_t vertex_count,
                                    const std::string& body) {
  const auto plain = py::array_t<Index, kPlain>::ensure(array);
  if (!plain) throw py::error_already_set();
  const Index* const from = plain.data();
  const auto size = static_cast<std::size_t>(plain.size());
  // Nothing can be lost, so the values are copied at once.
  if (std::is_same<Index, std::uint32_t>::value) return {from, from + size};
  std::vector<std::uint32_t> indices(size);
  for (std::size_t i = 0; i < size; ++i) {
    indices[i] = static_cast<std::uint32_t>(from[i]);
    if (from[i] < 0 || static_cast<Index>(indices[i]) != from[i]) {
      throw std::invalid_argument(body + ": triangle " + std::to_string(i / 3) +
                                  " refers to vertex " + std::to_string(from[i]) +
                                  ", but there are " + std::to_string(vertex_count) + " vertices");
    }
  }
  return indices;
}

// Copies real numbers of exactly this shape.
void copyReal(const Argument& argument, py::handle value, const std::vector<Py_ssize_t>& shape,
              double* to) {
  const py::array array = argument.toArray(value);
  argument.requireKind(array, kReal, "real numbers");
  if (!std::equal(shape.begin(), shape.end(), array.shape(), array.shape() + array.ndim())) {
    argument.refuse("has shape " + shapeOf(array) + ", must be " +
                    (shape.size() == 2 ? "(3, 3)" : "(3,)"));
  }
  const auto plain = py::array_t<double, kPlain>::ensure(array);
  if (!plain) throw py::error_already_set();
  std::copy_n(plain.data(), plain.size(), to);
}

}  // namespace

// ensure() returns the same array if it has the right layout.
VertexArray toVertexArray(py::handle vertices, const std::string& body) {
  const Argument argument{body, "vertices"};
  const py::array array = argument.toArray(vertices);
  argument.requireKind(array, kReal, "real numbers");
  argument.requireRowsOfThree(array);
  VertexArray plain = VertexArray::ensure(array);
  if (!plain) throw py::error_already_set();
  return plain;
}

// Makes one copy, which the mesh then owns. numpy has rounded to the nearest float32 before.
std::vector<float> toVertices(py::handle vertices, const std::string& body) {
  const VertexArray array = toVertexArray(vertices, body);
  return {array.data(), array.data() + array.size()};
}

// Chooses the widest type of the same sign, so that no index is rounded or wraps around.
std::vector<std::uint32_t> toTriangles(py::handle triangles, std::size_t vertex_count,
                                       const std::string& body) {
  const Argument argument{body, "triangles"};
  const py::array array = argument.toArray(triangles);
  argument.requireKind(array, kIntegers, "integers");
  argument.requireRowsOfThree(array);
  const bool is_signed = array.dtype().kind() == 'i';
  const auto bytes = array.dtype().itemsize();
  if (is_signed && bytes <= 4) return narrowed<std::int32_t>(array, vertex_count, body);
  if (is_signed) return narrowed<std::int64_t>(array, vertex_count, body);
  if (bytes <= 4) return narrowed<std::uint32_t>(array, vertex_count, body);
  return narrowed<std::uint64_t>(array, vertex_count, body);
}

// Reads both arrays as float64, which RigidTransform keeps.
RigidTransform toPose(py::handle rotation, py::handle translation, const std::string& body) {
  RigidTransform pose;
  copyReal({body, "rotation"}, rotation, {3, 3}, pose.rotation);
  copyReal({body, "translation"}, translation, {3}, pose.translation);
  return pose;
}

}  // namespace deformable_contact_monitor
