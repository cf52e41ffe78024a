// Implements the Python class Scene. Each function converts and checks its arguments first, and
// changes the scene last.
#include "python/python_scene.h"

#include <pybind11/stl.h>

#include <stdexcept>

#include "python/array_arguments.h"

namespace deformable_contact_monitor {
namespace py = pybind11;
namespace {

// Checks both arrays before anything is changed.
TriangleMesh toMesh(py::handle vertices, py::handle triangles, const std::string& body) {
  TriangleMesh mesh;
  mesh.vertices = toVertices(vertices, body);
  mesh.triangles = toTriangles(triangles, mesh.vertexCount(), body);
  return mesh;
}

constexpr const char* kSceneText = R"(Bodies, their poses, and which pairs of bodies matter.

Pairs of bodies, and a body with itself, are off until set_pair_enabled() switches them on. Every
refusal is a ValueError that names the body and leaves the scene as it was. For one thread at a
time: while a detect() in another thread looks at the scene, a change is refused by a RuntimeError.

Arrays are copied: yours may change or go. Vertices: real numbers of shape (n, 3), x y z [m];
float32 is taken as it is, anything else is rounded to the nearest float32 (beyond its range:
infinity). Triangles: integers of shape (m, 3), three vertex indices each. Triangles with a NaN or
infinite vertex take no part and are counted in Result.counters["rejected"]; the result is not
complete then.)";

constexpr const char* kAddBodyText = R"(Adds a body and returns its id; ids count up from 0.

vertices: (n, 3) [m], in the body's frame. triangles: (m, 3). Both may be empty, of shape (0, 3),
and set later.
Raises ValueError where a shape, a dtype or an index does not fit, or a body has that name.)";

constexpr const char* kSetMeshText = R"(Replaces vertices, (n, 3) [m], and triangles, (m, 3).

Raises ValueError as add_body() does.)";

constexpr const char* kSetVerticesText = R"(Replaces the vertices, (n, 3) [m].

Raises ValueError where there are not as many as before.)";

constexpr const char* kSetDeviceVerticesText =
    R"(Replaces the vertices by some in a CUDA device's memory, (n, 3) float32 [m].

vertices: contiguous, with __cuda_array_interface__ of version 2 or later, as CuPy, Numba and
    PyTorch have it; it may be read-only. Nothing is copied, and the array is kept until the body
    has other vertices. After writing to it, call this again ahead of the next detect().
stream: behind which the vertices are ready: a cudaStream_t as an int; None: the interface's own, or
    else the legacy default stream. PyTorch's says none: where the current stream is not the default
    one, pass torch.cuda.current_stream().cuda_stream. It must live as long as the array is used.
The CUDA backend alone reads them, on its own device: detect() on any other raises ValueError.
Raises ValueError where there are not as many as before, or where they are not such an array.)";

constexpr const char* kSetPoseText = R"(Where the body is: p_scene = rotation p_body + translation.

rotation: (3, 3). translation: (3,) [m]. Both float64. A vertex in the scene's frame is the float32
of that sum; the identity leaves it untouched.
Raises ValueError at a wrong shape, a number that is not finite, or a rotation that scales, shears or
mirrors (by more than 1e-3).)";

constexpr const char* kSetMarginText = R"(At which distance triangles of the body count [m], >= 0.

Of a pair of bodies, the larger of the two margins holds; a distance equal to it counts.
Raises ValueError at a margin that is negative or not finite.)";

constexpr const char* kSetPartMarginsText =
    R"(Gives parts of the body margins of their own [m], in place of all earlier ones.

margins_m: a dict of part numbers, 0 to 255, to margins >= 0. Other parts have the body's margin. Of
two triangles, the larger margin of their parts holds. Detector.detect() raises ValueError for such a
body with a tolerance.
Raises ValueError at a part out of range, and at a margin that is negative or not finite.)";

constexpr const char* kSetRadiusText =
    R"(Makes the body all points at most this far from its triangles [m], >= 0.

A polyline of triangles (i, i + 1, i + 1) is a rope then, and points (i, i, i) are grains. Two
bodies touch where their triangles are at most the sum of their radii apart, and all distances are
those of the triangles minus the radii. Contacts of the body with itself leave out triangles that
are less than pi radii apart along its edges. Detector.detect() raises ValueError for such a body
with motion='swept' or with a tolerance. Raises ValueError at a radius that is negative or not
finite.)";

constexpr const char* kSetEarlierText = R"(Where the body was at the beginning of a step.

With Detector(motion='swept') each vertex moves from its place then, in the scene's frame, to its
present one on a straight line. The state stays until it is set again, cleared, or set_mesh() is
called; a body without one stands still (Result.without_step).

vertices: (n, 3) [m], in the body's frame then; None: those that the body has when it is looked at.
rotation, translation: the pose then, as in set_pose(); both, or None: the body's pose at this call.
Raises ValueError where there are not as many vertices as the body has, at a wrong shape, at a pose
that is not finite or only half given.)";

constexpr const char* kClearEarlierText = "Forgets the earlier state: the body stands still.";

constexpr const char* kSetPadText =
    R"(How far the body's points may be from their straight ways in a step [m], >= 0.

The pads of two bodies add up. Contacts that they alone make are marked in Result.within_pad.
Raises ValueError at a pad that is negative or not finite.)";

constexpr const char* kSetPairEnabledText = R"(Whether contacts of bodies a and b are looked for.

a == b: contacts of the body with itself.)";

constexpr const char* kSetPartsText = R"(Divides a body into parts, such as the hem of a cloth.

parts: (n,) integers in [0, 255], the part of each triangle; 0 is what belongs to no named part.
None, or set_mesh(), removes the parts.
Raises ValueError where there are not as many as triangles, or where one is not in that range.)";

constexpr const char* kSetPartPairEnabledText =
    R"(Whether contacts of two parts are looked for, while those of their bodies are.

All pairs of parts are enabled at first. Part 0 of a body without parts is all of it. The setting
stays when meshes and parts change. a == b: contacts within one body.
Raises ValueError where there is no such body, or a part is not in [0, 255].)";

// Returns the number of a part of that body. Checks before narrowing.
PartId checkedPart(std::int64_t part, const std::string& body) {
  if (part >= 0 && part <= 255) return static_cast<PartId>(part);
  throw std::invalid_argument(body + ": part " + std::to_string(part) + " is not in [0, 255]");
}

}  // namespace

// The checks of the core follow: indices beyond the vertices, and the body's name.
BodyId PythonScene::addBody(const std::string& name, py::handle vertices, py::handle triangles) {
  TriangleMesh mesh = toMesh(vertices, triangles, name);
  for (BodyId id = 0; id < scene_.bodyCount(); ++id) {
    if (scene_.body(id).name == name) {
      throw std::invalid_argument("body '" + name + "' is in the scene already (id " +
                                  std::to_string(id) +
                                  "): choose another name, or set_mesh() to replace its mesh");
    }
  }
  return changeable().addBody(name, std::move(mesh));
}

// Vertices on the host replace those on a device.
void PythonScene::setMesh(std::int64_t id, py::handle vertices, py::handle triangles) {
  TriangleMesh mesh = toMesh(vertices, triangles, nameOf(id));
  changeable().setMesh(checkedId(id), std::move(mesh));
  device_arrays_.erase(checkedId(id));
}

// The array's memory is copied by the core.
void PythonScene::setVertices(std::int64_t id, py::handle vertices) {
  const VertexArray array = toVertexArray(vertices, nameOf(id));
  changeable().setVertices(checkedId(id), array.data(), static_cast<std::size_t>(array.shape(0)));
  device_arrays_.erase(checkedId(id));
}

// Keeps the Python object, so that the device memory stays valid.
void PythonScene::setDeviceVertices(std::int64_t id, py::object vertices,
                                    std::optional<std::uintptr_t> stream) {
  const DeviceArray array = toDeviceArray(vertices, stream, nameOf(id));
  changeable().setDeviceVertices(checkedId(id), array.xyz, array.count, array.stream);
  device_arrays_[checkedId(id)] = std::move(vertices);
}

// The pose maps the body's coordinates to the scene's.
void PythonScene::setPose(std::int64_t id, py::handle rotation, py::handle translation) {
  const RigidTransform pose = toPose(rotation, translation, nameOf(id));
  changeable().setPose(checkedId(id), pose);
}

// The core checks the values, here and in the functions below.
void PythonScene::setPartMargins(std::int64_t id, const std::map<std::int64_t, float>& margins_m) {
  std::map<PartId, float> of_parts;
  for (const auto& [part, margin_m] : margins_m) of_parts[checkedPart(part, nameOf(id))] = margin_m;
  changeable().setPartMargins(checkedId(id), std::move(of_parts));
}

// Without vertices, the body was rigid; without a pose, it did not move.
void PythonScene::setEarlier(std::int64_t id, py::handle vertices, py::handle rotation,
                             py::handle translation) {
  const std::string name = nameOf(id);
  if (rotation.is_none() != translation.is_none()) {
    throw std::invalid_argument(name +
                                ": rotation and translation: one is given without the other");
  }
  const RigidTransform pose =
      rotation.is_none() ? scene_.body(checkedId(id)).pose : toPose(rotation, translation, name);
  // An empty list means that the vertices did not change.
  HostList<float> earlier;
  if (!vertices.is_none()) earlier = toVertices(vertices, name);
  if (!vertices.is_none() && earlier.empty() && scene_.body(checkedId(id)).mesh.vertexCount() > 0) {
    throw std::invalid_argument(name + ": vertices has none, must have as many as the body");
  }
  changeable().setEarlier(checkedId(id), pose, std::move(earlier));
}

void PythonScene::setPairEnabled(std::int64_t a, std::int64_t b, bool enabled) {
  changeable().setPairEnabled(checkedId(a), checkedId(b), enabled);
}

// The core checks how many there are.
void PythonScene::setParts(std::int64_t id, py::handle parts) {
  std::vector<PartId> part_of_triangle;
  if (!parts.is_none()) {
    const auto array = py::array::ensure(parts);
    if (!array || array.ndim() != 1 ||
        (array.dtype().kind() != 'i' && array.dtype().kind() != 'u')) {
      throw std::invalid_argument(nameOf(id) + ": parts must be integers of shape (n,)");
    }
    const auto numbers = py::array_t<std::int64_t, py::array::forcecast>::ensure(array);
    const std::string name = nameOf(id);
    for (py::ssize_t t = 0; t < numbers.size(); ++t) {
      part_of_triangle.push_back(checkedPart(numbers.at(t), name));
    }
    if (part_of_triangle.empty() && scene_.body(checkedId(id)).mesh.triangleCount() > 0) {
      throw std::invalid_argument(nameOf(id) + ": parts has none, must have as many as triangles");
    }
  }
  changeable().setParts(checkedId(id), std::move(part_of_triangle));
}

void PythonScene::setPartPairEnabled(std::int64_t a, std::int64_t part_a, std::int64_t b,
                                     std::int64_t part_b, bool enabled) {
  changeable().setPartPairEnabled(checkedId(a), checkedPart(part_a, nameOf(a)), checkedId(b),
                                  checkedPart(part_b, nameOf(b)), enabled);
}

bool PythonScene::pairEnabled(std::int64_t a, std::int64_t b) const {
  return scene_.pairEnabled(checkedId(a), checkedId(b));
}

// The order is that of the ids.
std::vector<std::string> PythonScene::names() const {
  std::vector<std::string> names;
  for (const Body& body : scene_.bodies()) names.push_back(body.name);
  return names;
}

// The detections of a process that this one was forked from are gone, and have changed nothing.
int& PythonScene::lookers() {
  if (lookers_forks_ != forkCount()) lookers_ = 0;
  lookers_forks_ = forkCount();
  return lookers_;
}

// Every change goes through here, so that no detector sees half of it.
Scene& PythonScene::changeable() {
  if (lookers() > 0) {
    throw std::runtime_error(
        "the scene cannot change while detect() looks at it in another thread");
  }
  return scene_;
}

// Checks before narrowing, because a number that BodyId cannot hold would otherwise wrap around to
// the id of another body.
BodyId PythonScene::checkedId(std::int64_t id) const {
  if (id < 0 || static_cast<std::uint64_t>(id) >= scene_.bodyCount()) {
    throw std::invalid_argument("body " + std::to_string(id) + " does not exist; there are " +
                                std::to_string(scene_.bodyCount()));
  }
  return static_cast<BodyId>(id);
}

void bindScene(py::module& module) {
  using Self = PythonScene;
  py::class_<Self>(module, "Scene", kSceneText)
      .def(py::init<>(), "An empty scene.")
      .def("add_body", &Self::addBody, py::arg("name"), py::arg("vertices"), py::arg("triangles"),
           kAddBodyText)
      .def("set_mesh", &Self::setMesh, py::arg("id"), py::arg("vertices"), py::arg("triangles"),
           kSetMeshText)
      .def("set_vertices", &Self::setVertices, py::arg("id"), py::arg("vertices"), kSetVerticesText)
      .def("set_device_vertices", &Self::setDeviceVertices, py::arg("id"), py::arg("vertices"),
           py::arg("stream") = py::none(), kSetDeviceVerticesText)
      .def("set_pose", &Self::setPose, py::arg("id"), py::arg("rotation"), py::arg("translation"),
           kSetPoseText)
      .def("set_margin", &Self::change<&Scene::setMargin, float>, py::arg("id"),
           py::arg("margin_m"), kSetMarginText)
      .def("set_part_margins", &Self::setPartMargins, py::arg("id"), py::arg("margins_m"),
           kSetPartMarginsText)
      .def("set_radius", &Self::change<&Scene::setRadius, float>, py::arg("id"),
           py::arg("radius_m"), kSetRadiusText)
      .def("set_earlier", &Self::setEarlier, py::arg("id"), py::arg("vertices") = py::none(),
           py::arg("rotation") = py::none(), py::arg("translation") = py::none(), kSetEarlierText)
      .def("clear_earlier", &Self::change<&Scene::clearEarlier>, py::arg("id"), kClearEarlierText)
      .def("set_pad", &Self::change<&Scene::setPad, float>, py::arg("id"), py::arg("pad_m"),
           kSetPadText)
      .def("set_pair_enabled", &Self::setPairEnabled, py::arg("a"), py::arg("b"),
           py::arg("enabled") = true, kSetPairEnabledText)
      .def("set_parts", &Self::setParts, py::arg("id"), py::arg("parts"), kSetPartsText)
      .def("set_part_pair_enabled", &Self::setPartPairEnabled, py::arg("a"), py::arg("part_a"),
           py::arg("b"), py::arg("part_b"), py::arg("enabled") = true, kSetPartPairEnabledText)
      .def("pair_enabled", &Self::pairEnabled, py::arg("a"), py::arg("b"),
           "Whether contacts of bodies a and b are looked for.")
      .def("enabled_pairs", &Self::enabledPairs,
           "All enabled pairs of ids, (a, b) with a <= b, ascending.")
      .def_property_readonly("body_count", &Self::bodyCount, "How many bodies there are.")
      .def_property_readonly("triangle_count", &Self::triangleCount, "Of all bodies together.")
      .def_property_readonly("names", &Self::names, "The bodies' names, by id.");
}

}  // namespace deformable_contact_monitor
