// Reads and checks __cuda_array_interface__, a Python dict that describes an array on a CUDA
// device: its shape, type, strides, address, and the stream that writes it.
#include "python/device_array.h"

#include <stdexcept>
#include <vector>

namespace deformable_contact_monitor {
namespace py = pybind11;
namespace {

constexpr int kOldestVersion = 2;  // before it, no stride and no pointer meant other things

// The __cuda_array_interface__ of an argument, with the names that error messages give.
class Interface {
 public:
  Interface(py::handle vertices, const std::string& body) : body_(body) {
    try {
      const py::object interface = vertices.attr("__cuda_array_interface__");
      if (!py::isinstance<py::dict>(interface)) refuse("is no dict");
      fields_ = interface;
    } catch (const py::error_already_set& error) {
      if (!error.matches(PyExc_AttributeError)) throw;
      throw std::invalid_argument(body +
                                  ": vertices is not in a device's memory (it has no "
                                  "__cuda_array_interface__); set_vertices takes it");
    }
  }

  // Throws with the body's name.
  [[noreturn]] void refuse(const std::string& what) const {
    throw std::invalid_argument(body_ + ": vertices: its __cuda_array_interface__ " + what);
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
  const std::string& body_;
  py::dict fields_;
};

// Converts an address, which the interface holds as an integer, to a pointer.
template <class T>
T* toPointer(std::uintptr_t address) {
  return reinterpret_cast<T*>(address);  // NOLINT(performance-no-int-to-ptr)
}

// Strides may be absent, which means C order.
void requireContiguous(const Interface& interface, std::size_t count) {
  if (interface.field("strides").is_none() || count == 0) return;
  const std::vector<std::int64_t> strides = interface.numbers("strides");
  const auto size = static_cast<std::int64_t>(sizeof(float));
  // A single row may have any row stride.
  if (strides.size() != 2 || strides[1] != size || (count > 1 && strides[0] != 3 * size)) {
    interface.refuse("has strides " + interface.shown("strides") + ", must be contiguous");
  }
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

}  // namespace

// Checks the fields in the order in which they are most often wrong.
DeviceArray toDeviceArray(py::handle vertices, std::optional<std::uintptr_t> stream,
                          const std::string& body) {
  const Interface interface(vertices, body);
  if (interface.as<int>("version", interface.field("version")) < kOldestVersion) {
    interface.refuse("has version " + interface.shown("version") + ", must be 2 or later");
  }
  const std::vector<std::int64_t> shape = interface.numbers("shape");
  if (shape.size() != 2 || shape[0] < 0 || shape[1] != 3) {
    interface.refuse("has shape " + interface.shown("shape") + ", must be (n, 3)");
  }
  if (interface.as<std::string>("typestr", interface.field("typestr")) != "<f4") {
    interface.refuse("has typestr " + interface.shown("typestr") + ", must be '<f4', float32");
  }
  if (!interface.field("mask").is_none()) interface.refuse("has a mask, must have none");
  const auto count = static_cast<std::size_t>(shape[0]);
  requireContiguous(interface, count);
  const py::tuple data = interface.tuple("data");
  if (data.empty()) interface.refuse("has data ()");
  const auto address = interface.as<std::uintptr_t>("data", data[0]);
  if (address == 0 && count > 0)
    interface.refuse("has no data, but shape " + interface.shown("shape"));
  return {toPointer<const float>(address), count, toStream(interface, stream)};
}

}  // namespace deformable_contact_monitor
