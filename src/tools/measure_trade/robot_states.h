// States of a robot beside a mesh, for measure_trade --states.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "tools/measure_trade/state_measurement.h"

namespace deformable_contact_monitor {

// What --states measures on. The mesh is in the frame of the robot's root link.
struct RobotStateFiles {
  std::string urdf;       // its joints are anywhere within their limits, each state by itself
  std::string mesh;       // body 0
  float margin_m = 0.1F;  // of the mesh
};

// Reads the files, and poses the links' collision meshes for `count` random states. Pairs of the
// mesh and links are enabled. Throws std::runtime_error or std::invalid_argument, one line, if a
// file cannot be read or no joint moves a link with a mesh, and always in a build without ROS.
SceneStates makeRobotStates(const RobotStateFiles& files, std::size_t count, std::uint32_t seed);

}  // namespace deformable_contact_monitor
