// The compiled part of the Python package deformable_contact.
//
// It binds the classes of python_scene, python_detector and python_result, and the function
// read_mesh. Docstrings stand beside the functions that they describe.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

#include "core/mesh_file.h"
#include "python/others_run.h"
#include "python/python_detector.h"
#include "python/python_result.h"
#include "python/python_robot.h"
#include "python/python_scene.h"
#include "python/python_states.h"

namespace deformable_contact_monitor {
namespace {

namespace py = pybind11;

constexpr const char* kModuleText = "Contacts between deforming triangle meshes.";

constexpr const char* kReadMeshText = R"(Reads OBJ, PLY, STL or OFF, by the file name's ending.

Returns vertices, (n, 3) float32, and triangles, (m, 3) uint32, in file order. Convex polygons are
fanned from their first vertex, other planar ones are triangulated. Nothing is welded, removed or
scaled. A coordinate is the nearest float32 of its text or double. Warns (UserWarning) of what may
not be meant as it was read, such as polygons that are not planar.
Raises OSError where the file cannot be opened; ValueError, "path: what" or "path:line: what", where
it is no mesh or holds no triangle.)";

// Returns the list as an array of shape (n, 3) without a copy: the array owns the moved list, and
// deletes it when Python releases the array.
template <class List>
py::array_t<typename List::value_type> toRowsOfThree(List values) {
  auto* const owned = new List(std::move(values));
  const py::capsule owner(owned, [](void* at) { delete static_cast<List*>(at); });
  return py::array_t<typename List::value_type>({owned->size() / 3, std::size_t{3}}, owned->data(),
                                                owner);
}

// Throws the exception that Python's open() would throw for this file: FileNotFoundError,
// PermissionError or IsADirectoryError.
void requireReadable(const std::string& path) {
  std::error_code no_file;
  const bool is_directory = std::filesystem::is_directory(path, no_file);
  if (!is_directory && access(path.c_str(), R_OK) == 0) return;
  if (is_directory) errno = EISDIR;
  PyErr_SetFromErrnoWithFilename(PyExc_OSError, path.c_str());
  throw py::error_already_set();
}

// Accepts text, bytes and path objects, as open() does. Other Python threads run while the file is
// read.
py::tuple readMesh(const py::object& path) {
  const AtWork at_work;
  PyObject* bytes = nullptr;
  if (PyUnicode_FSConverter(path.ptr(), &bytes) == 0) throw py::error_already_set();
  const std::string name = py::reinterpret_steal<py::bytes>(bytes);
  requireReadable(name);
  TriangleMesh mesh;
  MeshFileReport report;
  try {
    const py::gil_scoped_release others_run;
    mesh = readMeshFile(name, &report);
  } catch (const std::runtime_error& refused) {
    throw std::invalid_argument(refused.what());
  }
  for (const std::string& note : report.notes) {
    if (PyErr_WarnFormat(PyExc_UserWarning, 1, "%s: %s", name.c_str(), note.c_str()) != 0) {
      throw py::error_already_set();
    }
  }
  return py::make_tuple(toRowsOfThree(std::move(mesh.vertices)),
                        toRowsOfThree(std::move(mesh.triangles)));
}

}  // namespace

// The package __init__.py imports the names of this module.
PYBIND11_MODULE(_core, module) {
  module.doc() = kModuleText;
  module.attr("__version__") = DCM_VERSION;
  bindResult(module);
  bindScene(module);
  bindDetector(module);
  bindStates(module);
#ifdef DCM_WITH_ROBOT
  bindRobot(module);
#endif
  waitForOthersAtExit();
  module.def("read_mesh", &readMesh, py::arg("path"), kReadMeshText);
  // Users then see deformable_contact.Scene and not deformable_contact._core.Scene.
  for (const char* name : {"BodyDistance", "Detector", "NearestPair", "Result", "Scene",
                           "StateChecker", "StateResults", "read_mesh"}) {
    module.attr(name).attr("__module__") = "deformable_contact";
  }
}

}  // namespace deformable_contact_monitor
