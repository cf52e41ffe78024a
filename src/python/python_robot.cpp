// Implements the Python class Robot: link meshes of a URDF, and their poses by joint positions.
#include "python/python_robot.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "python/array_arguments.h"
#include "python/python_scene.h"
#include "robot/robot_poses.h"

namespace deformable_contact_monitor {
namespace py = pybind11;
namespace {

constexpr const char* kRobotText = R"(A robot's link meshes, and where joint positions put them.

For StateChecker: robot.add_to(scene) gives the bodies, robot.poses(positions) their poses.)";

constexpr const char* kRobotInitText =
    R"(Reads a robot description and the mesh files that it names.

urdf: the text of a URDF (the parameter robot_description). Mesh files are found as ROS finds them
    (package:// by ROS_PACKAGE_PATH) and read by processes of their own.
frame: the link in whose frame poses are; empty: the root link.
geometry: 'collision', 'visual' or 'collision_or_visual'.
Raises ValueError where the URDF is malformed, its joints form no tree or mimic no joint, a link's
mesh cannot be read, or no link has one.)";

constexpr const char* kPosesText = R"(Returns the poses of all links for joint positions.

positions: (n, len(joints)) real numbers [rad or m], in the order of `joints`; in host memory or, as
    CuPy, Numba and PyTorch have it, in that of a CUDA device, from where it is copied. Mimic joints
    follow; planar and floating joints stay at their origins.
Returns (n, len(links), 4, 4) float64, frame from link, as StateChecker.check takes it. A position
that is not finite gives poses that are not finite. Limits are not applied: see `limits`.)";

class PythonRobot {
 public:
  PythonRobot(const std::string& urdf, const std::string& frame, const std::string& geometry)
      : robot_(loadRobotGeometry(urdf, optionsOf(geometry), makeRosResolver())),
        poses_(robot_, frame) {
    if (robot_.links.empty()) {
      throw std::invalid_argument("no link of the robot has " + geometry + " geometry");
    }
    const std::vector<std::string>& all = poses_.links();
    for (const LinkGeometry& link : robot_.links) {
      if (!link.problem.empty()) throw std::invalid_argument(link.link + ": " + link.problem);
      places_.push_back(
          static_cast<std::size_t>(std::find(all.begin(), all.end(), link.link) - all.begin()));
    }
  }

  std::vector<std::string> joints() const {
    std::vector<std::string> names;
    for (const RobotJoint& joint : poses_.joints()) names.push_back(joint.name);
    return names;
  }

  py::array limits() const {
    py::array_t<double> list({poses_.joints().size(), std::size_t{2}});
    double* to = list.mutable_data();
    for (const RobotJoint& joint : poses_.joints()) {
      *to++ = joint.lower;
      *to++ = joint.upper;
    }
    return py::array(std::move(list));
  }

  std::vector<std::string> links() const {
    std::vector<std::string> names;
    for (const LinkGeometry& link : robot_.links) names.push_back(link.link);
    return names;
  }

  // Bodies are where the joints at zero put them.
  std::vector<BodyId> addTo(PythonScene* scene) {
    std::vector<RigidTransform> at_zero(poses_.links().size());
    poses_.pose(std::vector<double>(poses_.joints().size(), 0).data(), at_zero.data());
    for (const std::string& name : scene->names()) {
      for (const LinkGeometry& link : robot_.links) {
        if (link.link == name) {
          throw std::invalid_argument("the scene has a body '" + name + "' already");
        }
      }
    }
    std::vector<BodyId> bodies;
    for (std::size_t i = 0; i < robot_.links.size(); ++i) {
      const RigidTransform& pose = at_zero[places_[i]];
      const std::vector<float>& vertices = robot_.links[i].mesh.vertices;
      const std::vector<std::uint32_t>& triangles = robot_.links[i].mesh.triangles;
      bodies.push_back(scene->addBody(
          robot_.links[i].link,
          py::array_t<float>({vertices.size() / 3, std::size_t{3}}, vertices.data()),
          py::array_t<std::uint32_t>({triangles.size() / 3, std::size_t{3}}, triangles.data())));
      scene->setPose(bodies.back(),
                     py::array_t<double>({std::size_t{3}, std::size_t{3}}, pose.rotation),
                     py::array_t<double>(std::size_t{3}, pose.translation));
    }
    return bodies;
  }

  py::array poses(py::handle positions) {
    const py::array given = toHostArray(positions, "positions");
    const char kind = given.dtype().kind();
    const auto joints = static_cast<py::ssize_t>(poses_.joints().size());
    if (kind != 'f' && kind != 'i' && kind != 'u') {
      throw std::invalid_argument("positions must be real numbers");
    }
    if (given.ndim() != 2 || given.shape(1) != joints) {
      throw std::invalid_argument("positions must have shape (n, " + std::to_string(joints) +
                                  "), a column for each of `joints`, but have " +
                                  std::string(py::str(given.attr("shape"))));
    }
    const auto numbers = py::array_t<double, kPlain>::ensure(given);
    if (!numbers) throw py::error_already_set();
    const auto count = static_cast<std::size_t>(given.shape(0));
    py::array_t<double> matrices({count, places_.size(), std::size_t{4}, std::size_t{4}});
    double* to = matrices.mutable_data();
    std::vector<RigidTransform> of_state(poses_.links().size());
    for (std::size_t i = 0; i < count; ++i) {
      poses_.pose(numbers.data() + i * static_cast<std::size_t>(joints), of_state.data());
      for (const std::size_t place : places_) to = writeMatrix(of_state[place], to);
    }
    return py::array(std::move(matrices));
  }

 private:
  static RobotGeometryOptions optionsOf(const std::string& geometry) {
    RobotGeometryOptions options;
    const auto found = std::find(kGeometryKinds.begin(), kGeometryKinds.end(), geometry);
    if (found == kGeometryKinds.end()) {
      throw std::invalid_argument("geometry is '" + geometry +
                                  "', must be 'collision', 'visual' or 'collision_or_visual'");
    }
    options.kind = static_cast<GeometryKind>(found - kGeometryKinds.begin());
    return options;
  }

  // Returns where the next matrix begins.
  static double* writeMatrix(const RigidTransform& pose, double* to) {
    for (int r = 0; r < 3; ++r) {
      to = std::copy_n(pose.rotation + 3 * r, 3, to);
      *to++ = pose.translation[r];
    }
    constexpr double kLastRow[] = {0, 0, 0, 1};
    return std::copy_n(kLastRow, 4, to);
  }

  RobotGeometry robot_;
  RobotPoses poses_;
  std::vector<std::size_t> places_;  // of the links with meshes, in poses_.links()
};

}  // namespace

void bindRobot(py::module& module) {
  using Self = PythonRobot;
  py::class_<Self>(module, "Robot", kRobotText)
      .def(py::init<const std::string&, const std::string&, const std::string&>(), py::arg("urdf"),
           py::arg("frame") = "", py::arg("geometry") = "collision", kRobotInitText)
      .def("add_to", &Self::addTo, py::arg("scene").none(false),
           "Adds a body for each of `links` to a Scene, at the poses of all joints at zero, and "
           "returns their ids. Its pairs are not enabled yet. Raises ValueError if the scene has a "
           "body of such a name.")
      .def("poses", &Self::poses, py::arg("positions"), kPosesText)
      .def_property_readonly("joints", &Self::joints,
                             "Names of the joints that have a position of their own, sorted.")
      .def_property_readonly("limits", &Self::limits,
                             "(len(joints), 2) float64: lower and upper positions [rad or m]; "
                             "infinite where there are none.")
      .def_property_readonly("links", &Self::links, "Names of the links that have a mesh.")
      .def("__repr__", [](const Self& self) {
        return "<Robot: " + std::to_string(self.links().size()) + " links with meshes, " +
               std::to_string(self.joints().size()) + " joints>";
      });
  module.attr("Robot").attr("__module__") = "deformable_contact";
}

}  // namespace deformable_contact_monitor
