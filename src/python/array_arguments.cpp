// Converts numpy arrays, and what numpy can make arrays of, to the core's lists. Types and shapes
// are checked first, because numpy would convert silently, for example texts to numbers.
#include "python/array_arguments.h"

#include <algorithm>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "cuda/memory/copy_from_device.h"
#include "python/others_run.h"

namespace deformable_contact_monitor {
namespace py = pybind11;
namespace {

constexpr int kOldestVersion = 2;  // before it, no stride and no pointer meant other things

// Returns an array's __cuda_array_interface__; null if it has none. Passes on what else goes wrong
// there, such as torch's advice on tensors with gradients.
py::object deviceInterface(py::handle array) {
  try {
    return array.attr("__cuda_array_interface__");
  } catch (const py::error_already_set& error) {
    if (!error.matches(PyExc_AttributeError)) throw;
    return py::object();
  }
}

// The __cuda_array_interface__ of an argument, with the names that error messages give.
class Interface {
 public:
  // `argument` is what messages begin with.
  Interface(const py::object& interface, std::string argument) : argument_(std::move(argument)) {
    if (!py::isinstance<py::dict>(interface)) refuse("is no dict");
    fields_ = interface;
    if (as<int>("version", field("version")) < kOldestVersion) {
      refuse("has version " + shown("version") + ", must be 2 or later");
    }
    if (!field("mask").is_none()) refuse("has a mask, must have none");
  }

  // Throws with the argument's name.
  [[noreturn]] void refuse(const std::string& what) const {
    throw std::invalid_argument(argument_ + ": its __cuda_array_interface__ " + what);
  }

  // Returns a field; None if it is missing.
  py::object field(const char* name) const {
    if (!fields_.contains(name)) return py::none();
    return fields_[name];
  }

  // Converts a field, or throws with its name and value.
  template <class T>
  T as(const char* name, const py::object& value) const {
    try {
      return value.cast<T>();
    } catch (const py::cast_error&) {
      refuse(std::string("has ") + name + " " + std::string(py::repr(value)));
    }
  }

  // Returns a field that must be a tuple.
  py::tuple tuple(const char* name) const {
    py::object value = field(name);
    if (!py::isinstance<py::tuple>(value)) refuse(std::string("has ") + name + " " + shown(name));
    return value;
  }

  // Returns a field that must be a tuple of integers.
  std::vector<std::int64_t> numbers(const char* name) const {
    std::vector<std::int64_t> values;
    for (const py::handle value : tuple(name)) {
      values.push_back(as<std::int64_t>(name, py::reinterpret_borrow<py::object>(value)));
    }
    return values;
  }

  // Returns a field as Python shows it.
  std::string shown(const char* name) const { return py::repr(field(name)); }

 private:
  const std::string argument_;
  py::dict fields_;
};

// Converts an address, which the interface holds as an integer, to a pointer.
template <class T>
T* toPointer(std::uintptr_t address) {
  return reinterpret_cast<T*>(address);  // NOLINT(performance-no-int-to-ptr)
}

// Requires C order without gaps. Strides may be absent, which means just that; a single row may
// have any row stride.
void requireContiguous(const Interface& interface, const std::vector<std::int64_t>& shape,
                       std::int64_t number_size) {
  if (interface.field("strides").is_none()) return;
  if (std::count(shape.begin(), shape.end(), 0) != 0) return;
  const std::vector<std::int64_t> strides = interface.numbers("strides");
  std::int64_t stride = number_size;
  bool fits = strides.size() == shape.size();
  for (std::size_t i = shape.size(); fits && i > 0; --i) {
    fits = shape[i - 1] == 1 || strides[i - 1] == stride;
    stride *= shape[i - 1];
  }
  if (!fits) {
    interface.refuse("has strides " + interface.shown("strides") + ", must be contiguous");
  }
}

// Returns the address of the first of `count` numbers.
std::uintptr_t addressOf(const Interface& interface, std::size_t count) {
  const py::tuple data = interface.tuple("data");
  if (data.empty()) interface.refuse("has data ()");
  const auto address = interface.as<std::uintptr_t>("data", data[0]);
  if (address == 0 && count > 0) {
    interface.refuse("has no data, but shape " + interface.shown("shape"));
  }
  return address;
}

// The values 1 and 2 are CUDA's handles of the default streams; 0 is ambiguous and is rejected.
void* toStream(const Interface& interface, std::optional<std::uintptr_t> given) {
  if (given) return toPointer<void>(*given);
  const py::object stream = interface.field("stream");
  if (stream.is_none()) return nullptr;  // nothing to wait for, or nothing known
  const auto handle = interface.as<std::uintptr_t>("stream", stream);
  if (handle == 0) interface.refuse("has stream 0, which means none in particular");
  return toPointer<void>(handle);
}

// Returns whether numpy would take the values of an array that its mask declares invalid.
bool hasMask(py::handle value) {
  return py::hasattr(value, "mask") &&
         py::module::import("numpy.ma").attr("is_masked")(value).cast<bool>();
}

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
    if (hasMask(value)) refuse("has masked values; fill or leave them out first");
    py::array array = py::array::ensure(value);
    if (array) return array;
    // numpy cannot read device memory, so the message names the function that can.
    PyErr_Clear();
    if (deviceInterface(value)) {
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

// Checks the fields in the order in which they are most often wrong.
DeviceArray toDeviceArray(py::handle vertices, std::optional<std::uintptr_t> stream,
                          const std::string& body) {
  const py::object fields = deviceInterface(vertices);
  if (!fields) {
    throw std::invalid_argument(body +
                                ": vertices is not in a device's memory (it has no "
                                "__cuda_array_interface__); set_vertices takes it");
  }
  const Interface interface(fields, body + ": vertices");
  const std::vector<std::int64_t> shape = interface.numbers("shape");
  if (shape.size() != 2 || shape[0] < 0 || shape[1] != 3) {
    interface.refuse("has shape " + interface.shown("shape") + ", must be (n, 3)");
  }
  if (interface.as<std::string>("typestr", interface.field("typestr")) != "<f4") {
    interface.refuse("has typestr " + interface.shown("typestr") + ", must be '<f4', float32");
  }
  const auto count = static_cast<std::size_t>(shape[0]);
  requireContiguous(interface, shape, sizeof(float));
  return {toPointer<const float>(addressOf(interface, count)), count, toStream(interface, stream)};
}

py::array toHostArray(py::handle value, const std::string& name) {
  const py::object fields = deviceInterface(value);
  if (!fields) {
    if (hasMask(value)) throw std::invalid_argument(name + " has masked values");
    py::array array = py::array::ensure(value);
    if (array) return array;
    PyErr_Clear();
    throw std::invalid_argument(name + " must be an array");
  }
  const Interface interface(fields, name);
  const std::vector<std::int64_t> shape = interface.numbers("shape");
  std::size_t count = 1;
  for (const std::int64_t size : shape) {
    if (size < 0) interface.refuse("has shape " + interface.shown("shape"));
    count *= static_cast<std::size_t>(size);
  }
  const auto type = interface.as<std::string>("typestr", interface.field("typestr"));
  if (type != "<f4" && type != "<f8") {
    interface.refuse("has typestr " + interface.shown("typestr") + ", must be '<f4' or '<f8'");
  }
  py::array array(py::dtype(type), std::vector<py::ssize_t>(shape.begin(), shape.end()));
  requireContiguous(interface, shape, array.itemsize());
  const std::uintptr_t from = addressOf(interface, count);
  void* const stream = toStream(interface, std::nullopt);
  const auto bytes = static_cast<std::size_t>(array.nbytes());
  void* const to = array.mutable_data();
  if (bytes > 0) {
    // The stream may wait for work of other Python threads.
    const AtWork at_work;
    const py::gil_scoped_release others_run;
    copyFromDevice(to, toPointer<const void>(from), bytes, stream);
  }
  return array;
}

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
  if (isFinite(pose) && !isRotation(pose.rotation)) {
    Argument{body, "rotation"}.refuse("is no rotation: it scales, shears or mirrors");
  }
  return pose;
}

}  // namespace deformable_contact_monitor
