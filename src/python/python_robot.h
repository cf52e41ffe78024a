// The class Robot of the Python module, in builds with ROS.
#pragma once

#include <pybind11/pybind11.h>

namespace deformable_contact_monitor {

// Adds the class Robot.
void bindRobot(pybind11::module& module);  // NOLINT(google-runtime-references): pybind11's custom

}  // namespace deformable_contact_monitor
